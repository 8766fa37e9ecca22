// What was touched in the picture, and sending the robot or its tool to that place: preview first, then a slide.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const SIGNS = { robot: "smart_toy", obstacle: "block", place: "trip_origin", ground: "my_location" };
  const SENDS = [
    { action: "tool_go_to", label: "Slide to move the crane here", button: "Crane here", line: "The crane moves. Keep everyone away." },
    { action: "go_to", label: "Slide to drive here", button: "Drive here", line: "It drives there by itself" },
  ];

  class TwinDetails {
    constructor(robot) {
      this.robot = robot;
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
      const place = said.x_m === null ? [] : [`${said.distance_m === null ? "" : `${said.distance_m.toFixed(1)} m from the robot, `}east ${said.x_m.toFixed(1)}, north ${said.y_m.toFixed(1)}`];
      this.lines.replaceChildren(...[...said.lines, ...place].map((line) => el("div", {}, line)));
      this.offer(said);
      return null;
    }

    // only what the robot says it can be asked now; the others say why not
    offer(said) {
      this.drop();
      const actions = HL.port.robot(this.robot).actions ?? {};
      const isPlace = said.x_m !== null && said.what !== "robot";
      this.slides = SENDS.filter((send) => isPlace && actions[send.action]?.ok).map((send) => new HL.Slide({
        hook: `twin-${send.action.replaceAll("_", "-")}`, icon: "my_location", label: send.label, line: `${send.line}: ${said.distance_m?.toFixed(1) ?? "––"} m away`, button: { icon: "my_location", label: send.button },
        act: () => HL.port.command(this.robot, send.action, { place: [said.x_m, said.y_m] }),
      }));
      const refused = SENDS.filter((send) => isPlace && actions[send.action] && !actions[send.action].ok).map((send) => el("p", { class: "h-t13 h-2" }, `${send.button}: ${actions[send.action].reason}`));
      this.slides.forEach((slide) => slide.allow?.(HL.lease.obstacle(this.robot)));
      this.acts.replaceChildren(...this.slides.map((slide) => slide.node), ...refused);
    }

    drop() {
      this.slides?.forEach((slide) => slide.drop?.());
      this.slides = [];
    }

    close() {
      this.drop();
      this.node.hidden = true;
      return null;
    }
  }

  HL.TwinDetails = TwinDetails;
})();
