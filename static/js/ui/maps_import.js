// Import: upload, then a list of what the file holds, with a choice and a kind for each shape.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const ACCEPT = ".geojson,.json,.kml,.kmz,.zip,.shp,.xml,.gpx,.csv,.dxf,.tif,.tiff,.pmtiles";
  const TAKE_MS = 60000;

  function progress(file, cancel) {
    const bar = el("progress", { class: "m-progress", max: "1", value: "0", "aria-label": "Upload" });
    const line = el("p", { class: "h-t14 h-2", role: "status" }, "Sending 0 %");
    const close = HL.sheet({ title: `Import ${file.name}`, hook: "import-progress", body: [bar, line], buttons: [["Cancel", () => cancel()]] });
    return {
      close,
      show(share) {
        if (share === null) bar.removeAttribute("value");
        else bar.value = share;
        text(line, share === null ? "Reading the file" : `Sending ${Math.round(share * 100)} %`);
      },
    };
  }

  // act: {opened() -> Promise(true if there is a draft), take(id, items, kinds) -> Promise(answer)}
  async function importFile(file, act) {
    if (!(await act.opened())) return;
    let sending = null;
    const sheet = progress(file, () => sending?.cancel());
    sending = M.upload(file, (share) => sheet.show(share));
    const answer = await sending.answer;
    sheet.close();
    if (answer.code === "cancelled") return void HL.toast("Import cancelled", "cancel");
    if (!answer.ok) return failed(file, answer, act);
    if (!answer.items?.length && !answer.skipped?.length) return failed(file, { text: "There are no shapes in it." }, act);
    preview(file, answer, act);
  }

  function failed(file, answer, act) {
    HL.sheet({ title: `${file.name} was not read`, hook: "import-failed", body: [el("p", { class: "h-t16" }, answer.text), answer.advice ? el("p", { class: "h-t14 h-2" }, answer.advice) : ""], buttons: [["Close", (close) => close()], ["Try again", (close) => (close(), importFile(file, act)), true]] });
  }

  class Item {
    constructor(item, changed) {
      this.item = item;
      this.box = el("input", { type: "checkbox", "data-testid": `import-item-${item.n}`, "aria-label": `Take ${item.name || `shape ${item.n}`}`, onchange: changed });
      this.box.checked = !item.problems?.length;
      this.kind = el("select", { class: "h-select", "data-testid": `import-kind-${item.n}`, "aria-label": "Kind" }, ...(item.kinds?.length ? item.kinds : [item.kind]).map((kind) => el("option", { value: kind }, M.label(kind))));
      this.kind.value = item.kind;
      const facts = [M.count(item.vertices ?? 0, "corner"), item.area_m2 ? M.words(M.area(item.area_m2)) : ""].filter(Boolean).join(", ");
      const problems = (item.problems ?? []).map((words) => el("div", { class: "h-row h-t13 h-b m-problem" }, HL.alarm(3, 20), words));
      this.node = el("div", { class: "m-item" }, el("label", { class: "h-check" }, this.box), el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b h-ell" }, item.name || `Shape ${item.n}`), el("div", { class: "h-t13 h-2" }, facts), ...problems), this.kind);
    }
  }

  function preview(file, found, act) {
    const all = found.items.length + (found.skipped?.length ?? 0);
    const take = el("button", { type: "button", class: "h-btn pri", "data-testid": "import-take", onclick: () => go() });
    const said = el("p", { class: "h-error", role: "alert" });
    const rows = found.items.map((item) => new Item(item, () => paint()));
    const chosen = () => rows.filter((row) => row.box.checked);
    const paint = () => {
      text(take, `Take ${chosen().length} of ${all}`);
      attr(take, "disabled", chosen().length === 0);
    };
    const skipped = (found.skipped ?? []).map((one) => el("div", { class: "m-item" }, el("span", { class: "m-skip" }, icon("block", "m")), el("div", { class: "h-sp" }, el("div", { class: "h-t14 h-b" }, `${one.which}: ${one.why}`), el("div", { class: "h-t13 h-2" }, one.mend))));
    const close = HL.sheet({
      title: `Import ${file.name}`,
      hook: "import-sheet",
      body: [
        el("p", { class: "h-t14 h-2" }, [found.format, found.crs].filter(Boolean).join(", ")),
        el("div", { class: "m-items" }, ...rows.map((row) => row.node)),
        ...(skipped.length ? [el("h3", { class: "h-t16 h-b", "data-testid": "import-skipped" }, `Import skipped ${skipped.length} of ${M.count(all, "shape")}`), el("div", { class: "m-items" }, ...skipped)] : []),
        said,
        el("div", { class: "foot" }, el("button", { type: "button", class: "h-btn", onclick: () => close() }, "Cancel"), take),
      ],
    });
    paint();
    async function go() {
      attr(take, "disabled", true);
      const kinds = Object.fromEntries(chosen().map((row) => [row.item.n, row.kind.value]));
      const answer = await act.take(found.id, chosen().map((row) => row.item.n), kinds, TAKE_MS);
      if (answer.ok) return close();
      text(said, answer.text || "The server did not answer. Try again.");
      return paint();
    }
  }

  HL.maps.importFile = importFile;
  HL.maps.ACCEPT = ACCEPT;
})();
