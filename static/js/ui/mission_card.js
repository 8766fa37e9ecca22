// The mission on the robot: row n of m with one tick per row, area, done at, left.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement, define, words } = HL;
  const MOST_TICKS = 120; // more rows than this share ticks: a tick below 2 px tells nothing
  const OLD_MS = 2000; // the robot says its state twice a second

  class MissionCard extends LiveElement {
    build() {
      this.name = el("span", { class: "h-ell" });
      this.age = el("span");
      this.row = el("span", { class: "big", "data-testid": "value-row" });
      this.rows = el("span", { class: "h-t22 h-2 h-b" });
      this.share = el("span", { class: "h-t22 h-b share" });
      this.ticks = el("div", { class: "h-ticks", role: "progressbar", "aria-label": "Rows done", "aria-valuemin": "0" });
      this.area = el("b", { "data-testid": "value-area" });
      this.of = el("small");
      this.done = el("b", { "data-testid": "value-eta" });
      this.leftTime = el("b");
      const fact = (label, ...nodes) => el("div", {}, el("div", { class: "h-h" }, label), ...nodes);
      this.figure = el("span");
      this.area.append(this.figure, this.of);
      this.change = el("button", { type: "button", class: "h-btn h-cardbtn", "data-testid": "mission-change", onclick: () => HL.late("rest").then((rest) => rest?.change(HL.port.robot(HL.view.robot).mission)) }, icon("edit_road", "m"), "Change the rest");
      this.pending = el("div", { class: "h-t14 h-b", role: "status", "data-testid": "mission-pending", hidden: true }, "Update sent, not confirmed");
      this.full = el("div", { class: "h-now" },
        el("div", { class: "h-row h-base top" }, el("span", { class: "h-t18 h-b" }, "Row"), this.row, this.rows, el("span", { class: "h-sp" }), this.share),
        this.ticks,
        el("div", { class: "h-facts" }, fact("Area", this.area), fact("Done at", this.done), fact("Left", this.leftTime)), this.pending, this.change);
      this.side = el("div");
      this.full.append(this.side);
      this.empty = el("div", { class: "h-t16 h-2", hidden: true });
      this.append(el("div", { class: "h-h" }, this.name, el("span", { class: "h-age h-end" }, icon("schedule", "s"), this.age)), this.full, this.empty);
    }
    paint() {
      const groups = HL.port.robot(HL.view.robot);
      const { mission } = groups;
      const isAwaited = !groups.mode && this.dataset.awaited !== undefined; // it is on its way: its room is kept
      attr(this.full, "hidden", !mission && !isAwaited);
      this.full.style.visibility = mission ? "" : "hidden";
      attr(this.empty, "hidden", Boolean(mission) || isAwaited);
      text(this.name, mission ? `Mission ${mission.name || mission.id}` : "Mission");
      if (!mission) {
        text(this.age, "");
        toggle(this, "stale", false);
        text(this.empty, groups.mode ? "No mission on this robot. Choose one under Missions." : "Waiting for the first state.");
        return;
      }
      attr(this.change, "hidden", !(groups.actions?.change?.ok && HL.config.rights.includes("send_mission")));
      attr(this.pending, "hidden", !mission.is_pending);
      if (HL.queueHold && !this.hold) this.side.append((this.hold = new HL.queueHold.CardHold()).node);
      this.hold?.follow(HL.view.robot, mission);
      const ageMs = HL.port.age(mission.t);
      const period = mission.period_ms || 500;
      const isOld = ageMs > Math.max(OLD_MS, 3 * period);
      toggle(this, "stale", isOld);
      toggle(this, "late", !isOld && ageMs > Math.max(1000, 1.5 * period));
      text(this.age, words.age(ageMs));
      this.paintRows(mission, ageMs);
      this.paintFacts(mission, groups.mode?.mode, ageMs);
    }
    paintRows(mission, ageMs) {
      text(this.row, mission.row);
      attr(this.row, "data-value", mission.row);
      attr(this.row, "data-age-ms", Math.round(ageMs));
      text(this.rows, `of ${mission.rows}`);
      text(this.share, `${Math.floor((mission.share || 0) * 100)} %`);
      attr(this.ticks, "aria-valuenow", mission.row);
      attr(this.ticks, "aria-valuemax", mission.rows);
      const count = Math.min(mission.rows || 0, MOST_TICKS);
      const isDone = mission.status === "done";
      const now = mission.rows ? Math.ceil((mission.row * count) / mission.rows) : 0;
      const key = `${count}/${now}/${isDone}`;
      if (key === this.drawn) return;
      this.drawn = key;
      if (this.ticks.childElementCount !== count) this.ticks.replaceChildren(...Array.from({ length: count }, () => el("i")));
      [...this.ticks.children].forEach((tick, i) => attr(tick, "class", isDone || i < now - 1 ? "done" : i === now - 1 ? "now" : null));
    }
    paintFacts(mission, mode, ageMs) {
      const done = HL.units.area(mission.area_done_m2 || 0);
      text(this.figure, done.text);
      text(this.of, ` of ${HL.units.area(mission.area_m2 || 0).text} ${done.unit}`);
      attr(this.area, "data-value", mission.area_done_m2 ?? "");
      attr(this.area, "data-age-ms", Math.round(ageMs));
      const seconds = mission.remaining_s;
      const isMoving = mode === "auto";
      attr(this.done, "data-value", seconds ?? "");
      attr(this.done, "data-age-ms", Math.round(ageMs));
      text(this.done, mission.status === "done" ? "Done" : seconds === null || seconds === undefined ? "–" : isMoving ? words.day(new Date(Date.now() - ageMs + seconds * 1000)) : STANDING[mode] || "Paused");
      text(this.leftTime, mission.status === "done" ? "–" : words.left(seconds));
    }
  }
  const STANDING = { idle: "Not yet", stopped: "Stopped", fault: "Fault", unknown: "–" };

  define("hl-mission", MissionCard);
})();
