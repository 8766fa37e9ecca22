// Base maps of the farm: a list to look at, and for planners upload, rename and delete.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const PATH = "/base-maps";
  const ACCEPT = ".tif,.tiff,.pmtiles";
  const LOOK_MS = 1000;
  const QUIET_MS = 5000; // without work: somebody else may have added one
  const KINDS = { photo: "Aerial photo", raster: "Map of pictures", vector: "Vector map, without names" };
  const LOST = "The server was restarted while it worked on this. Upload the file again.";
  const sending = new Map(); // uploads of this page by number, also while the panel is closed
  let uploads = 0;
  let panel = null;

  const size = (bytes) => (bytes >= 1e9 ? `${(bytes / 1e9).toFixed(1)} GB` : bytes >= 1e6 ? `${Math.round(bytes / 1e6)} MB` : `${Math.max(1, Math.round(bytes / 1e3))} KB`);

  function extent([west, south, east, north]) {
    const high = (north - south) * 111.2;
    const wide = (east - west) * 111.3 * Math.cos((((north + south) / 2) * Math.PI) / 180);
    const km = (value) => (value >= 20 ? String(Math.round(value)) : value >= 1 ? value.toFixed(1) : value.toFixed(2));
    return wide > 5000 ? "the world" : `${km(wide)} × ${km(high)} km`;
  }

  const isBaseFile = (file) => /\.(tiff?|pmtiles)$/i.test(file.name);

  class Panel {
    // act: {mayEdit, reason, show(map)}
    constructor(act) {
      this.act = act;
      this.opened = new Map(); // id -> "rename" or "delete": rows that ask something
      this.file = el("input", { type: "file", hidden: true, accept: ACCEPT, "data-testid": "base-file", onchange: () => this.picked() });
      this.add = el("button", { type: "button", class: "h-btn pri", "data-testid": "base-add", disabled: !act.mayEdit, onclick: () => this.file.click() }, icon("upload_file", "m"), "Add photo or map");
      this.room = el("p", { class: "h-t14 h-2", "data-testid": "base-room" });
      this.why = el("p", { class: "h-error", role: "alert", hidden: true, "data-testid": "base-error" });
      this.rows = el("div", { class: "m-items", "data-testid": "base-list" });
      const hint = el("p", { class: "h-t14 h-2" }, act.mayEdit ? "GeoTIFF from a drone or land survey, or PMTiles. It lies under the map of everybody on this farm." : `${act.reason} You can look at what is there.`);
      this.close = HL.sheet({ title: "Base maps", hook: "base-maps", body: [hint, el("div", { class: "h-row h-wrap m-base-head" }, this.add, this.room), this.why, this.rows, this.file], buttons: [["Close", (close) => close(), true]] });
      this.rows.replaceChildren(el("div", { class: "h-card h-skeleton", "aria-label": "Loading" }, el("i"), el("i"), el("i")));
      this.look();
    }

    get isOpen() {
      return this.rows.isConnected;
    }

    async look() {
      clearTimeout(this.timer);
      const answer = await HL.port.api("GET", PATH);
      if (!this.isOpen) return;
      const wasStale = this.isStale;
      this.isStale = !answer.ok;
      if (answer.ok && wasStale) this.say("");
      if (answer.ok) this.take(answer);
      else if (!this.answer) this.failed(answer);
      else this.say(`The list is not new: ${answer.text || "the server did not answer"}`);
      const isBusy = sending.size > 0 || this.answer?.work?.some((one) => one.state !== "failed");
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.isOpen && this.look(), isBusy ? LOOK_MS : QUIET_MS);
    }

    failed(answer) {
      this.rows.replaceChildren(el("div", { class: "h-card h-notice", role: "alert" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "Base maps did not load"), el("span", { class: "h-2" }, answer.text || "Server did not answer. STOP still works."), el("button", { type: "button", class: "h-btn", onclick: () => this.look() }, icon("refresh", "m"), "Try again")));
    }

    take(answer) {
      const before = this.answer;
      this.answer = answer;
      for (const one of before?.work ?? []) {
        if (one.state === "failed" || answer.work.some((now) => now.id === one.id) || this.opened.get(one.id) === "cancelled") continue;
        const ready = answer.maps.find((map) => map.id === one.id);
        if (ready) HL.toast(`${ready.name} is ready`, "check");
        else this.say(`${one.name}: ${LOST}`);
      }
      this.paint();
    }

    say(words) {
      this.said = words;
      text(this.why, words);
      attr(this.why, "hidden", !words);
    }

    paint() {
      const { maps, work, room, online } = this.answer;
      text(this.room, `${size(room.used_bytes)} of ${size(room.most_bytes)} used`);
      const key = JSON.stringify([maps, work, online, [...sending.values()].map((one) => [one.name, one.share]), [...this.opened]]);
      if (key === this.painted) return;
      this.painted = key;
      if (this.rows.contains(document.activeElement) && document.activeElement.matches("input")) return void (this.painted = null); // somebody types
      const rows = [...[...sending].map(([n, one]) => this.sendingRow(n, one)), ...work.map((one) => this.workRow(one)), ...maps.map((one) => this.mapRow(one))];
      if (online) rows.push(this.row(icon("network_cell"), "Online map", `From ${new URL(online.url).host}. Tablets ask that server themselves. Set by an admin.`));
      if (!rows.length) rows.push(HL.records.empty("No base map yet", this.act.mayEdit ? "Add an aerial photo, and field edges can be drawn on it." : "Maps show plain ground."));
      this.rows.replaceChildren(...rows);
    }

    row(sign, name, line, ...more) {
      return el("div", { class: "m-item m-base" }, sign, el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b" }, name), el("div", { class: "h-t13 h-2" }, line)), ...more);
    }

    button(hook, sign, word, run) {
      return el("button", { type: "button", class: "h-btn ico", "data-testid": hook, title: word, "aria-label": word, onclick: run }, icon(sign, "m"));
    }

    sendingRow(n, one) {
      const bar = el("progress", { class: "m-progress", max: "1", "aria-label": `Sending ${one.name}` });
      if (one.share !== null) bar.value = one.share;
      const line = one.share === null ? "The server is taking it" : `Sending ${Math.round(one.share * 100)} % of ${size(one.size)}`;
      return el("div", { class: "m-item m-base", "data-testid": "base-sending" }, icon("upload_file"), el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b h-ell" }, one.name), el("div", { class: "h-t13 h-2", role: "status" }, line), bar), el("button", { type: "button", class: "h-btn", "data-testid": `base-sending-cancel-${n}`, onclick: () => one.cancel() }, "Cancel"));
    }

    workRow(one) {
      const mayEnd = this.act.mayEdit;
      if (one.state === "failed") return el("div", { class: "m-item m-base", "data-testid": `base-work-${one.id}`, "data-state": "failed", role: "alert" }, HL.alarm(3, 24), el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b h-ell" }, `${one.name}: not taken`), el("div", { class: "h-t14" }, one.text)), mayEnd ? el("button", { type: "button", class: "h-btn", "data-testid": `base-dismiss-${one.id}`, onclick: () => this.end(one) }, "Dismiss") : "");
      const bar = el("progress", { class: "m-progress", max: "1", "aria-label": `Preparing ${one.name}` });
      if (one.share > 0) bar.value = one.share;
      const line = { sending: "Being sent from another screen", waiting: "Waiting for its turn", working: `Preparing ${Math.round(one.share * 100)} %` }[one.state];
      return el("div", { class: "m-item m-base", "data-testid": `base-work-${one.id}`, "data-state": one.state }, icon("hourglass_top"), el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b h-ell" }, one.name), el("div", { class: "h-t13 h-2", role: "status" }, line), bar), mayEnd && one.state !== "sending" ? el("button", { type: "button", class: "h-btn", "data-testid": `base-cancel-${one.id}`, onclick: () => this.end(one) }, "Cancel") : "");
    }

    mapRow(one) {
      const asks = this.opened.get(one.id);
      if (asks === "rename") return this.renameRow(one);
      if (asks === "delete") return this.deleteRow(one);
      const line = one.is_there ? `${KINDS[one.kind] ?? one.kind}, ${extent(one.bounds)}, ${size(one.size_bytes)} · ${one.by}, ${HL.records.when(one.added_utc)}` : "Its file is gone from the server. Delete it and upload it again.";
      const open = (what) => () => (this.opened.set(one.id, what), this.paint());
      const edits = this.act.mayEdit ? [this.button(`base-rename-${one.id}`, "edit", `Rename ${one.name}`, open("rename")), this.button(`base-delete-${one.id}`, "delete", `Delete ${one.name}`, open("delete"))] : [];
      const made = this.row(one.is_there ? icon(one.kind === "photo" ? "layers" : "map") : HL.alarm(3, 24), one.name, line, one.is_there ? el("button", { type: "button", class: "h-btn", "data-testid": `base-show-${one.id}`, onclick: () => (this.close(), this.act.show(one)) }, "Show") : "", ...edits);
      attr(made, "data-testid", `base-map-${one.id}`);
      return made;
    }

    back(id) {
      this.opened.delete(id);
      document.activeElement?.blur();
      this.painted = null;
      this.paint();
    }

    renameRow(one) {
      const name = el("input", { class: "h-input", value: one.name, maxlength: "80", "aria-label": "Name", "data-testid": "base-name" });
      const credit = el("input", { class: "h-input", value: one.credit, maxlength: "160", "aria-label": "Source to be named on the map", placeholder: "Source to be named, e.g. © Land survey", "data-testid": "base-credit" });
      const save = async () => this.done(one.id, await HL.port.api("PATCH", `${PATH}/${one.id}`, { name: name.value.trim(), credit: credit.value.trim() }), "Not renamed");
      return el("div", { class: "m-item m-base m-ask" }, name, credit, el("div", { class: "h-row" }, el("button", { type: "button", class: "h-btn", onclick: () => this.back(one.id) }, "Cancel"), el("button", { type: "button", class: "h-btn pri", "data-testid": "base-save", onclick: save }, "Save")));
    }

    deleteRow(one) {
      const go = async () => this.done(one.id, await HL.port.api("DELETE", `${PATH}/${one.id}`), "Not deleted");
      return el("div", { class: "m-item m-base m-ask", role: "alert" }, el("div", { class: "h-t16 h-b" }, `Delete ${one.name} for everybody? It cannot be brought back.`), el("div", { class: "h-row" }, el("button", { type: "button", class: "h-btn", onclick: () => this.back(one.id) }, "Keep it"), el("button", { type: "button", class: "h-btn pri", "data-testid": "base-delete-yes", onclick: go }, `Delete, ${size(one.size_bytes)}`)));
    }

    done(id, answer, words) {
      if (!answer.ok && answer.status !== 404) return this.say(`${words}: ${answer.text || "the server did not answer"}`);
      this.say("");
      this.back(id);
      return this.look();
    }

    async end(one) {
      this.opened.set(one.id, "cancelled");
      this.done("", await HL.port.api("DELETE", `${PATH}/${one.id}`), "Not cancelled");
    }

    picked() {
      const [file] = this.file.files;
      this.file.value = "";
      if (file) send(file);
    }
  }

  async function send(file) {
    const now = panel?.isOpen ? panel : null;
    now?.say("");
    const most = now?.answer?.room.upload_bytes;
    if (!isBaseFile(file)) return void now?.say(`${file.name} is neither a GeoTIFF (.tif) nor PMTiles.`);
    if (file.size > most) return void now?.say(`${file.name} has ${size(file.size)}; ${size(most)} are allowed. Cut the photo.`);
    uploads += 1;
    const n = uploads;
    const one = { name: file.name, size: file.size, share: 0 };
    const upload = M.upload(file, PATH, (share) => { one.share = share; panel?.isOpen && panel.answer && panel.paint(); }, 0);
    one.cancel = upload.cancel;
    sending.set(n, one);
    panel?.isOpen && panel.look();
    const answer = await upload.answer;
    sending.delete(n);
    const shown = panel?.isOpen ? panel : null;
    if (answer.code === "cancelled") HL.toast("Upload cancelled", "cancel");
    else if (!answer.ok && shown) shown.say(`${file.name}: ${answer.text}`);
    else if (!answer.ok) HL.toast(`${file.name}: ${answer.text}`, "block");
    await shown?.look();
    return undefined;
  }

  // act: {mayEdit, reason, show(map)}; with a file, its upload begins
  function showBaseMaps(act, file = null) {
    panel = new Panel(act);
    if (file) send(file);
  }

  Object.assign(M, { showBaseMaps, isBaseFile });
})();
