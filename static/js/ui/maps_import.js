// Import: upload and reading with progress and a way to stop both, then a list of what the file holds to choose from.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const ACCEPT = ".geojson,.json,.kml,.kmz,.zip,.shp,.xml,.gpx,.csv,.dxf,.tif,.tiff,.pmtiles";
  const FORMATS = { geojson: "GeoJSON", kml: "KML", kmz: "KMZ", shapefile: "Shapefile", isoxml: "ISOXML", gpx: "GPX", fiware: "FIWARE" };
  const TAKE_MS = 180000; // thousands of shapes at once
  const ASK_MS = 500; // how far the server is

  function progress(file, cancel) {
    const bar = el("progress", { class: "m-progress", max: "1", value: "0", "aria-label": "Import" });
    const line = el("p", { class: "h-t14 h-2", role: "status", "data-testid": "import-state" }, "Sending 0 %");
    const close = HL.sheet({ title: `Import ${file.name}`, hook: "import-progress", body: [bar, line], buttons: [["Cancel", () => cancel()]] });
    return {
      close,
      sending(share) {
        if (share === null) bar.removeAttribute("value");
        else bar.value = share;
        text(line, share === null ? "Reading the file" : `Sending ${Math.round(share * 100)} %`);
      },
      reading({ share, shapes }) {
        bar.value = share;
        text(line, `Reading the file, ${Math.round(share * 100)} %${shapes ? `, ${M.count(shapes, "shape")} so far` : ""}`);
      },
    };
  }

  // act: {opened() -> Promise(true if there is a draft), take(id, items, kinds) -> Promise(answer)}
  async function importFile(file, act) {
    if (!(await act.opened())) return;
    const ref = window.headland.uuid();
    let sending = null;
    let asking = null;
    const sheet = progress(file, () => {
      sending?.cancel();
      HL.port.api("DELETE", `/map/imports/${ref}`); // the server stops reading, too
    });
    const ask = async () => {
      const answer = await HL.port.api("GET", `/map/imports/${ref}/progress`);
      if (asking && answer.ok) sheet.reading(answer);
    };
    sending = M.upload(file, `/map/imports?ref=${ref}&geometry=false`, (share) => {
      sheet.sending(share);
      if (share === null) asking ??= setInterval(ask, ASK_MS);
    });
    const answer = await sending.answer;
    clearInterval(asking);
    asking = null;
    sheet.close();
    if (answer.code === "cancelled") return void HL.toast("Import cancelled", "cancel");
    if (!answer.ok) return failed(file, answer, act);
    if (!answer.items?.length && !answer.skipped?.length) return failed(file, { text: "There are no shapes in it." }, act);
    preview(file, answer, act);
  }

  function failed(file, answer, act) {
    HL.sheet({ title: `${file.name} was not read`, hook: "import-failed", body: [el("p", { class: "h-t16" }, answer.text), answer.advice ? el("p", { class: "h-t14 h-2" }, answer.advice) : ""], buttons: [["Close", (close) => close()], ["Try again", (close) => (close(), importFile(file, act)), true]] });
  }

  function preview(file, found, act) {
    const skipped = found.skipped ?? [];
    const all = found.items.length + skipped.length;
    const take = el("button", { type: "button", class: "h-btn pri", "data-testid": "import-take", onclick: () => go() });
    const said = el("p", { class: "h-error", role: "alert" });
    const list = new M.ImportList(found.items, () => paint());
    const paint = () => {
      text(take, `Take ${list.taken.length} of ${all}`);
      attr(take, "disabled", list.taken.length === 0);
    };
    const row = (one) => el("div", { class: "m-item" }, el("span", { class: "m-skip" }, icon("block", "m")), el("div", { class: "h-sp" }, el("div", { class: "h-t14 h-b" }, `${one.which[0].toUpperCase()}${one.which.slice(1)}: ${one.why}`), el("div", { class: "h-t13 h-2" }, one.mend)));
    const close = HL.sheet({
      title: `Import ${file.name}`,
      hook: "import-sheet",
      body: [
        el("p", { class: "h-t14 h-2" }, [FORMATS[found.format] ?? found.format, found.crs].filter(Boolean).join(", ")),
        list.node,
        ...(skipped.length ? [el("h3", { class: "h-t16 h-b", "data-testid": "import-skipped" }, `Import skipped ${skipped.length} of ${M.count(all, "shape")}`), M.longList(skipped, row)] : []),
        said,
        el("div", { class: "foot" }, el("button", { type: "button", class: "h-btn", onclick: () => leave() }, "Cancel"), take),
      ],
    });
    paint();
    function leave() {
      HL.port.api("DELETE", `/map/imports/${found.id}`); // it would wait for a choice
      close();
    }
    async function go() {
      attr(take, "disabled", true);
      text(take, "Taking");
      const taken = list.taken;
      const kinds = Object.fromEntries(taken.map((one) => [one.n, list.kindOf(one)]));
      const answer = await act.take(found.id, taken.map((one) => one.n), kinds, TAKE_MS);
      if (answer.ok) return close();
      text(said, answer.text);
      if (await answer.later) return close(); // it was taken, its answer was lost: a second time it would come twice
      if (answer.later) text(said, "Not taken. Try again.");
      return paint();
    }
  }

  HL.maps.importFile = importFile;
  HL.maps.ACCEPT = ACCEPT;
})();
