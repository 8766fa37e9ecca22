// The map of the rest sheet: the new path, and ground drawn on it that is left out or driven around.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const KINDS = { leave_out: ["Area left out", "content_cut"], obstacle: ["Obstacle", "block"] };
  const CLEAR = [["0.5", "0.5 m clear"], ["1", "1 m clear"], ["2", "2 m clear"], ["5", "5 m clear"]];
  const USUAL_CLEAR_M = 1;
  const MOST = 20;
  const DIGITS = 8; // of degrees: a millimetre

  class RestMap {
    // arrow: what it stands for; changed(): areas are others now
    constructor(title, arrow, changed) {
      Object.assign(this, { title, changed, areas: [], kind: "leave_out" });
      this.holder = el("div", { class: "h-mpicture a-map", "data-testid": "rest-map" });
      const tool = (kind, hook, sign, words) => el("button", { type: "button", class: "h-btn", "data-testid": hook, onclick: () => this.draw(kind) }, icon(sign, "m"), words);
      this.tools = el("div", { class: "h-row h-wrap", role: "group", "aria-label": "Draw on the map" }, tool("leave_out", "rest-draw-area", "content_cut", "Leave out an area"), tool("obstacle", "rest-draw-obstacle", "block", "Mark an obstacle"));
      this.list = el("div", { class: "a-list" });
      this.legend = el("p", { class: "h-t13 h-2", hidden: true, "data-testid": "rest-legend" }, `Grey is done. ${arrow}`);
      this.note = el("p", { class: "h-t13 h-2" }, "What is drawn here counts for this mission only. An obstacle that stays belongs on the map: Maps, Obstacle.");
      this.node = el("div", { class: "h-col", hidden: true }, this.tools, this.holder, this.legend, this.list, this.note);
    }

    // geometry of the mission as GeoJSON, and how far it was then; the sight stays where a person moved it
    show(geometry, progress) {
      if (this.pen?.isOn) return (this.waiting = [geometry, progress]); // nothing changes under a drawing finger
      this.waiting = null;
      const before = this.view?.isWhole === false ? this.view.window : null;
      this.geometry = geometry;
      const root = HL.fieldPicture({ ...geometry, features: geometry.features.filter((one) => !(one.properties.kind in KINDS)) }, this.title, progress);
      this.frame = root.frame;
      this.legend.hidden = !root.querySelector(".here");
      this.shapes = document.createElementNS("http://www.w3.org/2000/svg", "g");
      root.append(this.shapes);
      this.view?.sized.disconnect();
      this.view = new HL.SvgView(root, { isWheelFree: () => Boolean(this.pen?.isOn) });
      this.pen = new HL.AreaPen(this.view, (ring) => this.add(ring));
      this.pen.ended = () => ((this.tools.hidden = false), this.waiting && this.show(...this.waiting));
      this.holder.replaceChildren(root, this.view.buttons(), this.pen.bar);
      this.node.hidden = false;
      this.view.fit(this.frame.field); // what is drawn lies in the field, the way home is of no use here
      if (before) Object.assign(this.view, { window: before, isWhole: false });
      this.view.apply();
      this.paint();
    }

    draw(kind) {
      this.kind = kind;
      this.tools.hidden = true;
      this.holder.scrollIntoView({ block: "nearest" });
      this.pen.start();
    }

    add(ring) {
      const outline = ring.map((point) => this.frame.unflat(point).map((one) => Number(one.toFixed(DIGITS))));
      this.areas.push({ kind: this.kind, outline, clearance_m: this.kind === "obstacle" ? USUAL_CLEAR_M : 0 });
      this.told();
    }

    remove(area) {
      this.areas = this.areas.filter((one) => one !== area);
      this.told();
    }

    told() {
      this.paint();
      this.changed();
    }

    paint() {
      this.shapes?.replaceChildren(...HL.areaShapes(this.areas.map((one) => ({ look: one.kind, clearance_m: one.clearance_m, ring: one.outline.map(this.frame.flat) }))));
      for (const button of this.tools.children) button.disabled = this.areas.length >= MOST;
      this.list.replaceChildren(...this.areas.map((area, k) => this.row(area, k)));
    }

    row(area, k) {
      const [name, sign] = KINDS[area.kind];
      const title = el("span", { class: "h-sp h-t16 h-b" });
      text(title, `${name} ${this.areas.slice(0, k + 1).filter((one) => one.kind === area.kind).length}`);
      const pick = el("select", { class: "h-select", "aria-label": "Clearance", "data-testid": `rest-clear-${k}`, onchange: () => ((area.clearance_m = Number(pick.value)), this.told()) }, ...CLEAR.map(([value, words]) => el("option", { value }, words)));
      pick.value = String(area.clearance_m);
      return el("div", { class: "h-row", "data-testid": `rest-area-${k}`, "data-state": area.kind }, icon(sign, "m"), title, area.kind === "obstacle" ? pick : "", el("button", { type: "button", class: "h-btn ico", "aria-label": `Take ${title.textContent.toLowerCase()} away`, "data-testid": `rest-area-remove-${k}`, onclick: () => this.remove(area) }, icon("delete", "m")));
    }
  }

  HL.RestMap = RestMap;
})();
