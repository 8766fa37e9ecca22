// What the tool in hand waits for, over the map, and what else the same tool can draw.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  // tool of the column: [pen of the surface, word, what it waits for]; the first is what the tool draws at once
  const VARIANTS = {
    parcel: [["parcel", "Parcel", "Tap the corners of the field."]],
    hole: [["hole", "Hole", "Tap the corners of what is left out, inside a parcel."]],
    obstacle: [["obstacle", "Outline", "Tap the corners of the obstacle."], ["circle", "Round", "Tap its middle, then drag or type how far it reaches."], ["no-go", "Keep-out zone", "Tap the corners. No robot drives in there."], ["slow", "Slow zone", "Tap the corners. Set the speed in the panel."], ["building", "Building", "Tap its corners."], ["water", "Pond", "Tap along its edge."]],
    road: [["road", "Road", "Tap along the middle of the road, then Done."], ["yard", "Yard", "Tap the corners of the yard."], ["hedge", "Hedge", "Tap along the middle of the hedge, then Done."]],
    home: [["home", "Home", "Tap where a robot stands at home."], ["garage", "Garage", "Tap where it stands inside."], ["charging", "Charging", "Tap where it charges."], ["gate", "Gate", "Tap the middle of the gate."]],
    rows: [["rows", "A to B", "Tap where the first row begins and ends."], ["curve", "Curve", "Tap along the guide line, then Done."], ["recorded", "Recorded row", "Tap along a crop row, then Done."]],
    split: [["split", "Split", "Tap a line across the parcel, then Done."]],
    measure: [["measure", "Measure", "Tap points to measure between them."]],
  };
  const MERGE = "Tap the parcels to merge, then Merge.";
  const ONE_MORE = "1 chosen. Tap what it is merged with.";

  // act: {undoPoint, finish, merge, tool, pen(name), radius(metres) -> was it taken}
  class Hint {
    constructor(act) {
      this.act = act;
      this.words = el("span", { class: "m-hintwords" });
      this.kinds = el("div", { class: "h-seg m-kinds", role: "radiogroup", "aria-label": "What to draw" });
      this.radius = el("input", { class: "h-input", inputmode: "decimal", autocomplete: "off", "aria-label": "Radius in metres", "data-testid": "editor-radius", placeholder: "2.0", onkeydown: (event) => event.key === "Enter" && this.setRadius() });
      this.round = el("span", { class: "h-row m-radius" }, this.radius, "m", el("button", { type: "button", class: "h-btn", "data-testid": "editor-radius-set", onclick: () => this.setRadius() }, "Set radius"));
      this.point = el("button", { type: "button", class: "h-btn", "data-testid": "editor-undo-point", onclick: () => act.undoPoint() }, icon("backspace", "m"), "Last point");
      this.merge = el("button", { type: "button", class: "h-btn pri", "data-testid": "editor-merge", onclick: () => act.merge() }, icon("merge", "m"), "Merge");
      this.done = el("button", { type: "button", class: "h-btn pri", "data-testid": "editor-finish", onclick: () => act.finish() }, icon("check", "m"), "Done");
      this.leave = el("button", { type: "button", class: "h-btn", "data-testid": "editor-leave", onclick: () => act.tool("select") }, "Leave");
      this.node = el("div", { class: "h-card m-hint", hidden: true, "data-testid": "editor-hint" }, this.kinds, this.words, this.round, el("span", { class: "h-row" }, this.point, this.merge, this.done, this.leave));
    }

    // isDrawing: points are set; canFinish: what is drawn is enough to be done
    paint(tool, pen, measured, chosen, { isDrawing = false, canFinish = false }) {
      attr(this.node, "hidden", tool === "select");
      const variants = VARIANTS[tool] ?? [];
      if (this.tool !== tool) this.build(tool, variants);
      for (const button of this.kinds.children) attr(button, "aria-checked", String(button.dataset.pen === pen));
      const waits = (variants.find(([name]) => name === pen) ?? variants[0])?.[2] ?? "";
      const isTold = measured && (tool === "measure" || pen === "circle");
      text(this.words, isTold ? measured : tool === "merge" ? (chosen > 1 ? `${chosen} chosen` : chosen ? ONE_MORE : MERGE) : waits);
      attr(this.round, "hidden", pen !== "circle");
      attr(this.point, "hidden", tool === "merge" || tool === "home" || pen === "circle");
      attr(this.point, "disabled", !isDrawing);
      attr(this.merge, "hidden", tool !== "merge");
      attr(this.merge, "disabled", chosen < 2);
      attr(this.done, "hidden", !canFinish);
    }

    build(tool, variants) {
      this.tool = tool;
      attr(this.kinds, "hidden", variants.length < 2);
      this.kinds.replaceChildren(...variants.map(([pen, word]) => el("button", { type: "button", role: "radio", "data-pen": pen, "data-testid": `editor-pen-${pen}`, onclick: () => this.act.pen(pen) }, word)));
    }

    setRadius() {
      const metres = Number(this.radius.value.replace(",", "."));
      if (!(metres >= 0.05 && metres <= 1000)) return void HL.toast("Radius: 0.05 to 1000 m", "block");
      if (!this.act.radius(metres)) HL.toast("Tap its middle first.", "info");
      return undefined;
    }
  }

  Object.assign(HL.maps, { Hint, penOf: (tool) => VARIANTS[tool]?.[0][0] ?? tool });
})();
