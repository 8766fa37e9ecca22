// Tools of the map: the column beside it, the bar above it, and their keys.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const { LAYERS, dropdown } = HL.maps;
  const TOOLS = [
    ["select", "Select", "V", "arrow_selector_tool"], ["parcel", "Parcel", "P", "pentagon"], ["hole", "Hole", "H", "trip_origin"], ["obstacle", "Obstacle", "O", "dangerous"],
    ["road", "Road", "R", "edit_road"], ["home", "Home", "G", "home"], ["rows", "Rows", "D", "align_vertical_bottom"], ["split", "Split", "X", "content_cut"],
    ["merge", "Merge", "M", "merge"], ["measure", "Measure", "L", "straighten"],
  ];
  const FREE = new Set(["select", "measure"]); // change nothing: for everybody
  const FORMATS = [["geojson", "GeoJSON"], ["kml", "KML"], ["kmz", "KMZ"], ["shapefile", "Shapefile"], ["isoxml", "ISOXML"], ["gpx", "GPX"], ["fiware", "FIWARE"]];
  const SNAP = "headland.map.snap";
  const HIDDEN = "headland.map.hidden";
  const LEADER_MS = 1500; // "g" then a letter moves to another screen
  const isTyping = (target) => target instanceof HTMLElement && target.closest("input, textarea, select, [contenteditable]");

  // act: {tool, undo, redo, snap, layers, walk, pick, baseMaps, versions, undoPoint, remove, nudge, unsaved}
  class Tools {
    constructor(act) {
      this.act = act;
      this.buttons = new Map(TOOLS.map(([name, word, key, sign]) => [name, el("button", { type: "button", class: "m-tool", "data-testid": `editor-tool-${name}`, "aria-pressed": "false", title: `${word} (${key})`, "aria-keyshortcuts": key, onclick: () => this.press(name) }, icon(sign), el("span", {}, word))]));
      this.column = el("div", { class: "m-tools", role: "toolbar", "aria-label": "Tools" }, ...this.buttons.values());
      this.tool = "select";
    }
    press(name) {
      const button = this.buttons.get(name);
      if (button.getAttribute("aria-disabled") === "true") return button.dataset.reason && HL.toast(button.dataset.reason, "lock");
      return this.act.tool(name);
    }
    // reason: why nothing may be changed; noDrawing: why this device cannot draw
    paint(tool, reason, noDrawing = "") {
      this.tool = tool;
      for (const [name, button] of this.buttons) {
        const why = name === "select" ? "" : FREE.has(name) ? noDrawing : reason || noDrawing;
        attr(button, "aria-pressed", String(name === tool));
        attr(button, "aria-disabled", why ? "true" : null);
        attr(button, "data-reason", why || null);
      }
    }
    // true: it was one of ours
    key(event, isBuilding) {
      if (isTyping(event.target) || event.altKey || document.querySelector(".h-scrim")) return false;
      const letter = event.key.toLowerCase();
      if (event.ctrlKey || event.metaKey) {
        if (letter !== "z" && letter !== "y") return false;
        if (isBuilding) (letter === "y" || event.shiftKey ? this.act.redo : this.act.undo)();
        return true;
      }
      const isLed = performance.now() - (this.leaderAt ?? -Infinity) < LEADER_MS;
      this.leaderAt = letter === "g" ? performance.now() : -Infinity;
      const found = TOOLS.find(([, , key]) => key.toLowerCase() === letter);
      if (!found || event.shiftKey || isLed) return false;
      this.press(found[0]);
      return true;
    }
  }

  class Bar {
    constructor(act, { mayEdit }) {
      const button = (hook, sign, word, run, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, title: word, "aria-label": word, onclick: run }, icon(sign), el("span", { class: "m-word" }, word));
      this.act = act;
      this.hidden = new Set(HL.keep.read(HIDDEN, []));
      this.undo = button("editor-undo", "undo", "Undo", () => act.undo());
      this.redo = button("editor-redo", "redo", "Redo", () => act.redo());
      this.isSnap = HL.keep.read(SNAP, true) !== false;
      this.snap = el("button", { type: "button", "data-testid": "editor-snap", "aria-pressed": String(this.isSnap), title: "Corners snap to edges and corners nearby", "aria-label": "Snap", onclick: () => this.toggleSnap() }, icon("grid_goldenratio", "m"), el("span", { class: "m-word" }, "Snap"));
      this.layersButton = el("button", { type: "button", "data-testid": "editor-layers", "aria-label": "Layers" }, icon("layers", "m"), el("span", { class: "m-word" }, "Layers"));
      this.layers = dropdown(this.layersButton, (close) => this.layerRows(close));
      this.walk = button("editor-walk", "my_location", "Walk the edge", () => act.walk());
      this.import = button("editor-import", "upload_file", "Import", () => act.pick());
      this.exportButton = button("editor-export", "download", "Export", () => {});
      this.export = dropdown(this.exportButton, (close) => this.exportRows(close), "right");
      this.versions = button("editor-versions", "history", "Versions", () => act.versions(), "ico");
      for (const one of [this.exportButton, this.versions]) attr(one, "disabled", true); // until the map is there
      const edits = [this.undo, this.redo, el("i", { class: "m-rule" })];
      this.node = el("div", { class: "m-bar", role: "toolbar", "aria-label": "Map" }, ...(mayEdit ? edits : []), el("div", { class: "h-seg m-seg" }, ...(mayEdit ? [this.snap] : []), this.layers.node), ...(mayEdit ? [this.walk] : []), el("span", { class: "h-sp" }), ...(mayEdit ? [this.import] : []), this.export.node, this.versions);
    }
    toggleSnap() {
      this.isSnap = !this.isSnap;
      HL.keep.write(SNAP, this.isSnap);
      attr(this.snap, "aria-pressed", String(this.isSnap));
      this.act.snap(this.isSnap);
    }
    layerRows(close) {
      const base = el("button", { type: "button", class: "item", "data-testid": "editor-base-maps", onclick: () => (close(), this.act.baseMaps()) }, icon("map", "m"), "Base maps");
      return [...LAYERS.map(([name, word]) => {
        const box = el("input", { type: "checkbox", "data-testid": `editor-layer-${name}`, onchange: () => this.toggleLayer(name, box.checked) });
        box.checked = !this.hidden.has(name);
        return el("label", { class: "h-check m-layer" }, box, word);
      }), base];
    }
    toggleLayer(name, isOn) {
      if (isOn) this.hidden.delete(name);
      else this.hidden.add(name);
      HL.keep.write(HIDDEN, [...this.hidden]);
      this.act.layers();
    }
    isShown(kind) {
      return !LAYERS.some(([name, , kinds]) => this.hidden.has(name) && kinds.includes(kind));
    }
    exportRows(close) {
      const group = (of, title) => el("div", {},
        el("div", { class: "line h-2 h-t13" }, title),
        ...FORMATS.map(([format, word]) => el("a", { class: "item m-format", href: HL.maps.exportPath(format, of), download: "", "data-testid": `editor-export-${of}-${format}`, onclick: (event) => (event.preventDefault(), close(), HL.maps.exportMap([format, word], of)) }, icon("download", "m"), word)),
      );
      const { version, hasDraft } = this.of;
      return [el("div", { class: "m-exports" }, hasDraft ? group("draft", "This draft") : "", version ? group("published", `Published v${version}`) : "")];
    }
    paint({ undo, redo, reason, version, hasDraft, isEmpty, isNew }) {
      this.of = { version, hasDraft };
      const off = (button, isOff, why) => { attr(button, "disabled", isOff); attr(button, "title", why); };
      off(this.undo, Boolean(reason) || !undo, undo ? `Undo: ${undo} (Ctrl Z)` : reason || "Nothing to undo");
      off(this.redo, Boolean(reason) || !redo, redo ? `Redo: ${redo} (Ctrl Shift Z)` : reason || "Nothing to redo");
      off(this.exportButton, isEmpty, isEmpty ? "There is nothing to export yet" : "Export");
      off(this.versions, isNew, isNew ? "No version is published yet" : "Versions");
      attr(this.snap, "disabled", Boolean(reason));
      attr(this.walk, "disabled", Boolean(reason));
    }
  }

  Object.assign(HL.maps, { Tools, Bar, isTyping, isFree: (tool) => FREE.has(tool) });
})();
