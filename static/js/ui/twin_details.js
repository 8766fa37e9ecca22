// What was touched in the picture, and sending the robot or its tool to that place: preview first, then a slide.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const SIGNS = { robot: "smart_toy", obstacle: "block", place: "trip_origin", ground: "my_location" };
  const HEIGHTS_M = [0.5, 1.0, 1.6]; // of the tool above the ground; 1.6 m clears what stands there
  const SURE = 1.05; // the reach is found by trying postures; at its edge the robot decides
  const SENDS = [
    { action: "tool_go_to", label: "Slide to move crane here", button: "Crane here", line: "The crane moves. Keep everyone away", brief: "Keep clear", isTool: true },
    { action: "go_to", label: "Slide to drive here", button: "Drive here", line: "It drives there by itself", brief: "By itself" },
  ];

  const FLIES = { action: "go_to", label: "Slide to fly here", button: "Fly here", line: "It flies there by itself", brief: "By itself" };

  class TwinDetails {
    constructor(robot, link, isReplay) {
      Object.assign(this, { robot, link, isReplay, slides: [], height: HEIGHTS_M[1] });
      this.title = el("b", { class: "h-t16 h-b" });
      this.lines = el("div", { class: "h-t13 h-2" });
      this.acts = el("div", { class: "t-acts" });
      this.sign = el("span", {});
      this.node = el("section", { class: "h-card t-details", hidden: "", "data-testid": "twin-details", role: "status" }, el("div", { class: "h-row" }, this.sign, this.title, el("span", { class: "h-sp" }), el("button", { type: "button", class: "h-btn ico", "aria-label": "Close", onclick: () => this.close() }, icon("close"))), this.lines, this.acts);
    }

    show(said) {
      if (said.what === "nothing") return this.close();
      this.node.hidden = false;
      this.node.dataset.what = said.what;
      this.sign.replaceChildren(icon(SIGNS[said.what] ?? "info"));
      text(this.title, said.name);
      this.where = el("div", {});
      this.lines.replaceChildren(...said.lines.map((line) => el("div", {}, line)), this.where);
      this.offer(said);
      return null;
    }

    // how far it is now, twice a second; a place that is not marked any more is not offered any more
    follow(touched) {
      if (this.node.hidden || this.said.x_m === null) return;
      if (touched && this.said.what === "robot") Object.assign(this.said, touched); // its mark goes with it
      else if (touched?.x_m !== this.said.x_m || touched.y_m !== this.said.y_m) this.close();
      else Object.assign(this.said, touched);
    }

    place() {
      const { x_m: east, y_m: north, distance_m: away, id } = this.said;
      return east === null ? "" : `${away === null || id === this.robot ? "" : `${away.toFixed(1)} m from the robot, `}east ${east.toFixed(1)}, north ${north.toFixed(1)}`;
    }

    // what this robot can be sent to a place with; each says why while it is off
    offer(said) {
      this.drop();
      this.said = said;
      const isPlace = said.x_m !== null && said.what !== "robot" && HL.config.rights.includes("drive");
      const hasArm = Boolean(said.reach_m) || (HL.port.inside(this.robot).joints?.joints ?? []).length > 2;
      this.slides = this.sends().filter((send) => isPlace && (send.isTool ? hasArm : said.what !== "obstacle")).map((send) => this.slide(send));
      this.acts.replaceChildren(...this.slides.flatMap(({ slide, send, why, words }) => [send.isTool ? this.heights() : "", words, slide.node, why]));
      if (this.slides.some(({ send }) => send.isTool)) this.lift(this.height);
      this.paint();
    }

    sends() {
      return HL.port.robot(this.robot).id?.family === "uav" ? [FLIES] : SENDS;
    }

    slide(send) {
      const { x_m: x, y_m: y } = this.said;
      const slide = new HL.Slide({
        hook: `twin-${send.action.replaceAll("_", "-")}`, icon: "my_location", label: send.label, line: send.brief, button: { icon: "my_location", label: send.button },
        act: () => HL.port.command(this.robot, send.action, { place: [x, y, send.isTool ? this.height : 0] }), onopen: () => this.paint(),
      });
      // the slide is too narrow for what it does and how far away
      return { slide, send, why: el("p", { class: "h-t13 h-2" }), words: el("p", { class: "h-t14 h-b", role: "status" }) };
    }

    heights() {
      this.steps = HEIGHTS_M.map((height) => el("button", { type: "button", "data-testid": `twin-height-${height}`, onclick: () => this.lift(height) }, `${height.toFixed(1)} m`));
      return el("div", { class: "t-heights" }, el("span", { class: "h-t13 h-2" }, "Tool above ground"), el("div", { class: "h-seg", role: "group", "aria-label": "Height of the tool above the ground" }, ...this.steps));
    }

    lift(height) {
      this.height = height;
      this.steps.forEach((button, i) => attr(button, "aria-pressed", String(HEIGHTS_M[i] === height)));
      this.link.send({ k: "lift", height_m: height });
      HL.repaint();
    }

    line({ line, isTool }) {
      return `${line}: ${this.said.distance_m?.toFixed(1) ?? "––"} m away${isTool ? `, ${this.height.toFixed(1)} m above ground` : ""}`;
    }

    // the same rule as in the dock: what would be refused looks off
    refusal({ action, isTool }) {
      if (this.isReplay()) return "This is a replay. Go back to Live first.";
      if (this.link.unheard()) return `${this.link.unheard()}. How it stands is not known.`;
      if (!this.link.isPoseFresh()) return "The pose is old. How far it is now is not known.";
      if (this.link.judge().state !== "live") return "The picture is old. Wait until it is live again."; // poses come by another way
      const off = HL.superDock.refusal(action);
      if (off) return off;
      const { arm_m: away, reach_m: reach } = this.said;
      return isTool && reach && away > reach * SURE ? `Out of reach: ${away.toFixed(1)} m, it reaches ${reach.toFixed(1)} m.` : "";
    }

    paint() {
      if (this.node.hidden) return;
      text(this.where, this.place());
      for (const { slide, send, why, words } of this.slides) {
        const off = this.refusal(send);
        slide.isQuiet = true; // said once, below
        slide.allow(off);
        text(words, this.line(send));
        attr(words, "hidden", Boolean(off) || !slide.isOpen);
        text(why, off);
        attr(why, "hidden", !off);
      }
    }

    drop() {
      this.slides.forEach(({ slide }) => slide.drop());
      this.slides = [];
    }

    close() {
      this.drop();
      this.node.hidden = true;
      this.link.send({ k: "unmark" });
      return null;
    }
  }

  HL.TwinDetails = TwinDetails;
})();
