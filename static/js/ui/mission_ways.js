// In the detail of a mission: the ways on from where it is, each with one line that says what it does.
(() => {
  "use strict";
  const { el, icon } = HL;

  const way = (node, line) => el("div", { class: "h-way" }, node, el("span", { class: "h-t13 h-2" }, line));
  const button = (hook, sign, label, act, isOff) => el("button", { type: "button", class: "h-btn", "data-testid": hook, disabled: isOff, onclick: act }, icon(sign, "m"), label);

  const isBegun = (mission) => Boolean(mission.progress && (mission.progress.row > 0 || mission.progress.area_done_m2 > 0));
  const isInterrupted = (mission) => ["aborted", "failed"].includes(mission.status) && isBegun(mission);

  // missionWays(mission, maySend, done) -> nodes
  function missionWays(mission, maySend, done) {
    const found = [];
    if (mission.is_pending) found.push(el("div", { class: "h-row h-t16 h-b", "data-testid": "mission-pending", role: "status" }, icon("hourglass_top", "m"), "Update sent, not confirmed. The picture shows what the robot has."));
    if (["running", "resuming", "paused"].includes(mission.status)) found.push(way(button("mission-change", "edit_road", "Change the rest", () => HL.rest.change(mission), !maySend), "Rows, order, speed, end. What is done stays done."));
    if (isInterrupted(mission) || (mission.status === "paused" && isBegun(mission))) found.push(way(button("mission-later", "history", "Resume later", () => HL.rest.later(mission), !maySend), mission.status === "paused" ? "After it was moved: drives back and goes on where it stopped." : "Drives back from where it stands and goes on where it stopped."));
    if (isInterrupted(mission) || (mission.status === "paused" && isBegun(mission))) {
      const slide = new HL.Slide({ hook: "mission-fresh", isHold: true, icon: "refresh", goal: "refresh", label: "Hold to start fresh", line: HL.rest.forgets(mission.progress), button: { icon: "refresh", label: "Start fresh" }, act: async () => { const answer = await HL.rest.fresh(mission.id); done(); return answer; } });
      slide.allow(maySend ? "" : "Sending needs the operator role.");
      found.push(way(slide.node, `The whole mission again. ${HL.rest.forgets(mission.progress)}. It does not move yet.`));
    }
    return found.length ? [el("div", { class: "h-ways" }, ...found)] : [];
  }

  Object.assign(HL, { missionWays, isInterrupted });
})();
