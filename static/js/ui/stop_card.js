// The stop card: who pressed, each step with its time, the stopping distance, and the reason the reset asks for.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement, define, words } = HL;
  const REASONS = ["Person", "Animal", "Object", "Tool", "Test"];

  const reason = {
    get: (robot) => HL.draft.get(`reset-reason.${robot}`),
    set: (robot, value) => HL.draft.set(`reset-reason.${robot}`, value),
    clear: (robot) => HL.draft.clear(`reset-reason.${robot}`),
  };

  const plus = (ms) => `+${(ms / 1000).toFixed(2)} s`;

  // [sign, name, line, time, isBad] for each step of one press
  function steps(stop, robot) {
    const waited = words.age(HL.stops.ageMs(stop));
    const isFailed = stop.state === "not-confirmed";
    const paths = Object.entries(stop.paths || {}).filter(([, count]) => count).map(([name]) => name.toUpperCase());
    const rows = [
      ["check_circle", "Pressed", [stop.by, stop.device].filter(Boolean).join(", ") || "unknown", HL.stops.pressedText(stop)],
      stop.sent_ms === null || stop.sent_ms === undefined
        ? ["radio_button_unchecked", "SENT", "no path yet", ""]
        : ["check_circle", "SENT", [stop.count > 1 ? `${stop.count} times` : "", paths.join(" and ")].filter(Boolean).join(", "), plus(stop.sent_ms)],
    ];
    if (stop.ack_ms !== null && stop.ack_ms !== undefined) rows.push(["check_circle", "ACKNOWLEDGED BY ROBOT", `${stop.name || HL.view.name()} safety controller`, plus(stop.ack_ms)]);
    else rows.push(isFailed ? ["cancel", "No acknowledgement", stop.text || "expected within 1.0 s", waited, true] : ["radio_button_unchecked", "ACKNOWLEDGED BY ROBOT", "waiting", waited]);
    if (stop.state === "standstill" && stop.standstill_ms !== null) rows.push(["check_circle", "STANDSTILL CONFIRMED", `tracks ${(stop.speed_mps ?? 0).toFixed(2)} m/s, ${robot.safety?.tool_off === false ? "tool on" : "tool off"}`, plus(stop.standstill_ms)]);
    else rows.push(isFailed ? ["help", "Standstill unknown", "look at the machine", waited, true] : ["radio_button_unchecked", "STANDSTILL", typeof stop.speed_mps === "number" ? `braking, ${stop.speed_mps.toFixed(2)} m/s` : "waiting", waited]);
    return rows;
  }

  class StopCard extends LiveElement {
    build() {
      this.rate = el("span", { class: "h-age h-end" });
      this.list = el("div", { "data-testid": "stop-steps", role: "list" });
      this.note = el("div", { class: "h-stopnote" });
      this.card = el("section", { class: "h-card h-stopcard" }, el("div", { class: "h-row h-t16 h-b" }, "Software stop", this.rate), this.list, this.note);
      this.buttons = REASONS.map((name) => el("button", { type: "button", class: "h-btn", "data-testid": `stop-reason-${name.toLowerCase()}`, "aria-pressed": "false", onclick: () => this.choose(name) }, name));
      this.other = el("input", { class: "h-input", "data-testid": "stop-reason-text", "aria-label": "Another reason", placeholder: "Another reason", maxlength: "200" });
      this.other.addEventListener("input", () => (reason.set(HL.view.robot, this.other.value.trim()), HL.repaint()));
      this.ask = el("section", { class: "h-card" }, el("div", { class: "h-h" }, "Why? (for the log, needed for the reset)"), el("div", { class: "h-reasons" }, ...this.buttons), this.other);
      this.append(this.card, this.ask);
    }
    choose(name) {
      reason.set(HL.view.robot, reason.get(HL.view.robot) === name ? "" : name);
      this.other.value = "";
      HL.repaint();
    }
    paint() {
      const stop = HL.stops.worst(HL.view.robot);
      attr(this, "hidden", !stop);
      const side = this.closest(".h-side");
      if (side) attr(side, "data-look", stop ? "stopped" : null);
      if (!stop) return;
      const isFailed = stop.state === "not-confirmed";
      attr(this, "data-state", stop.state);
      toggle(this.card, "p1", isFailed);
      text(this.rate, ["sent", "acknowledged", "not-confirmed"].includes(stop.state) ? (HL.stops.ageMs(stop) < 10000 ? "sending 5 per second" : "sending 1 per second") : words.age(HL.stops.heardMs(stop)));
      for (const [name, value] of [["data-sent-ms", stop.sent_ms], ["data-ack-ms", stop.ack_ms], ["data-standstill-ms", stop.standstill_ms]]) attr(this.list, name, value ?? null);
      this.draw(steps(stop, HL.port.robot(HL.view.robot)));
      this.describe(stop, isFailed);
      attr(this.ask, "hidden", !HL.config.rights.includes("reset"));
      const chosen = reason.get(HL.view.robot);
      this.buttons.forEach((button, i) => (attr(button, "aria-pressed", String(chosen === REASONS[i])), toggle(button, "on", chosen === REASONS[i])));
      if (document.activeElement !== this.other) this.other.value = REASONS.includes(chosen) ? "" : chosen;
    }
    describe(stop, isFailed) {
      const groups = HL.port.robot(HL.view.robot);
      const metres = stop.stopping_distance_m ?? groups.safety?.stopping_distance_m;
      const figure = groups.body?.link_lost_s;
      if (isFailed) return text(this.note, `${figure ? `The robot is built to pause by itself ${figure} s after it loses the link. ` : ""}Headland cannot see whether it did.`);
      const distance = typeof metres === "number" ? `Stopping distance ${metres.toFixed(2)} m. ` : "";
      return text(this.note, `${distance}${groups.mission?.row ? `Row ${groups.mission.row} will continue where it stopped.` : "It stays where it is."}`);
    }
    draw(rows) {
      while (this.list.children.length < rows.length) {
        this.list.append(el("div", { class: "h-step", role: "listitem" }, icon("help", "f"), el("div", {}, el("b"), el("small")), el("time")));
      }
      rows.forEach(([sign, name, line, time, isBad], i) => {
        const [mark, words_, when] = this.list.children[i].children;
        toggle(this.list.children[i], "bad", isBad);
        text(mark, sign);
        text(words_.children[0], name);
        text(words_.children[1], line);
        text(when, time);
      });
    }
  }

  define("hl-stop-card", StopCard);
  Object.assign(HL, { stopReason: reason, stopSteps: steps });
})();
