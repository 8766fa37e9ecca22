// The stop card: the slab draws the steps with their times; below it the reason that the reset asks for.
(() => {
  "use strict";
  const { el, text, attr, toggle, LiveElement, define, words } = HL;
  const REASONS = ["Person", "Animal", "Object", "Tool", "Test"];

  const reason = {
    get: (robot) => HL.draft.get(`reset-reason.${robot}`),
    set: (robot, value) => HL.draft.set(`reset-reason.${robot}`, value),
    clear: (robot) => HL.draft.clear(`reset-reason.${robot}`),
  };

  class StopCard extends LiveElement {
    build() {
      this.steps = el("div", { class: "h-steps" });
      this.said = el("div");
      this.latch = el("section", { class: "h-card h-stopcard" }, el("div", { class: "h-row h-t16 h-b" }, "Software stop"), this.said);
      this.buttons = REASONS.map((name) => el("button", { type: "button", class: "h-btn", "data-testid": `stop-reason-${name.toLowerCase()}`, "aria-pressed": "false", onclick: () => this.choose(name) }, name));
      this.other = el("button", { type: "button", class: "h-btn q h-otherreason", "data-testid": "stop-reason-other", onclick: () => this.write() }, "Other");
      this.ask = el("section", { class: "h-card h-ask" }, el("div", { class: "h-h" }, "Why? (for the log)", this.other), el("div", { class: "h-reasons" }, ...this.buttons));
      this.append(this.steps, this.latch, this.ask);
    }
    choose(name) {
      reason.set(HL.view.robot, reason.get(HL.view.robot) === name ? "" : name);
      HL.repaint();
    }
    write() {
      const robot = HL.view.robot;
      const input = el("input", { class: "h-input", "data-testid": "stop-reason-text", "aria-label": "Reason", maxlength: "200", autofocus: true });
      input.value = REASONS.includes(reason.get(robot)) ? "" : reason.get(robot);
      input.addEventListener("input", () => (reason.set(robot, input.value.trim()), HL.repaint()));
      HL.sheet({ title: "Why was it stopped?", body: [input], buttons: [["Done", (close) => close(), true]] });
    }
    enter() {
      window.headlandStop?.renderSteps(this.steps, { robot: HL.view.robot ?? this.closest("[data-robot]")?.dataset.robot });
    }
    paint() {
      const stop = HL.stops.worst(HL.view.robot);
      attr(this, "hidden", !stop);
      const side = this.closest(".h-side");
      if (side) {
        attr(side, "data-look", stop ? "stopped" : null);
        attr(side, "data-stop", stop?.state ?? null);
      }
      if (!stop) {
        // a reason belongs to one stop: it must not wait for the next one
        if (HL.port.robot(HL.view.robot).safety?.latched === false && reason.get(HL.view.robot)) reason.clear(HL.view.robot);
        return;
      }
      attr(this, "data-state", stop.state);
      const isOnlyRobot = stop.at === undefined; // the slab draws the steps of the presses it knows
      attr(this.latch, "hidden", !isOnlyRobot);
      if (isOnlyRobot) text(this.said, `${stop.by || "Somebody"} pressed STOP${stop.device ? ` on ${stop.device}` : ""}, ${words.since(HL.stops.ageMs(stop))} ago. ${stop.state === "standstill" ? "The robot says it stands." : "The robot is braking."}`);
      attr(this.ask, "hidden", stop.state === "not-confirmed" || !HL.config.rights.includes("reset"));
      const chosen = reason.get(HL.view.robot);
      this.buttons.forEach((button, i) => (attr(button, "aria-pressed", String(chosen === REASONS[i])), toggle(button, "on", chosen === REASONS[i])));
      text(this.other, chosen && !REASONS.includes(chosen) ? chosen : "Other");
      toggle(this.other, "on", Boolean(chosen) && !REASONS.includes(chosen));
    }
  }

  define("hl-stop-card", StopCard);
  Object.assign(HL, { stopReason: reason });
})();
