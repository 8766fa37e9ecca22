// What is known of every STOP: from the gateway's steps, and from the robot's own safety controller.
(() => {
  "use strict";
  const RANK = { "not-confirmed": 4, sent: 3, acknowledged: 2, standstill: 1 };
  const steps = new Map(); // "stop_id/robot" -> newest step, with when it was heard

  function take(step) {
    if (!step?.stop_id || !step.robot) return;
    const key = `${step.stop_id}/${step.robot}`;
    if (step.state === "reset") steps.delete(key);
    else steps.set(key, { ...step, heardAt: performance.now() });
  }

  window.addEventListener("headland:stop", ({ detail }) => {
    for (const step of Array.isArray(detail) ? detail : detail?.steps ?? [detail?.step ?? detail]) take(step);
    HL.repaint();
  });

  // the robot latched a press that this page never heard of from the gateway
  function fromRobot(id) {
    const { safety, id: who } = HL.port.robot(id);
    if (!safety?.latched) return null;
    const press = safety.presses.find((one) => !one.is_reset) ?? safety.presses[0];
    return {
      stop_id: press?.stop_id ?? "", robot: id, name: who?.name ?? id, by: press?.by ?? "", device: press?.device ?? "", count: 0, paths: {},
      state: safety.standstill ? "standstill" : "acknowledged", speed_mps: safety.speed_mps, stopping_distance_m: safety.stopping_distance_m,
      sent_ms: null, ack_ms: null, standstill_ms: null, pressedT: press?.t ?? safety.t, heardT: safety.t,
    };
  }

  // the one to show: of this robot, or on screens of all robots of any
  function worst(robot) {
    const open = [...steps.values()].filter((step) => !robot || step.robot === robot);
    open.sort((a, b) => RANK[b.state] - RANK[a.state] || a.heardAt - b.heardAt);
    return open[0] ?? (robot ? fromRobot(robot) : null);
  }

  const sinceHeard = (stop) => performance.now() - stop.heardAt;
  const ageMs = (stop) => (stop.heardAt === undefined ? HL.port.age(stop.pressedT) : (stop.age_ms ?? 0) + sinceHeard(stop));
  const heardMs = (stop) => (stop.heardAt === undefined ? HL.port.age(stop.heardT) : sinceHeard(stop));
  const at = (utc, ms = 0) => (utc ? new Date(Date.parse(utc) + ms) : null);
  const standstillAt = (stop) => (stop.standstill_ms === null || stop.standstill_ms === undefined ? null : at(stop.pressed_utc, stop.standstill_ms));

  function pressedText(stop) {
    const when = at(stop.pressed_utc) ?? new Date(Date.now() - ageMs(stop));
    return `${HL.words.wallSeconds(when)}.${Math.floor(when.getMilliseconds() / 100)}`;
  }

  // every press the robot still holds, the gateway's and those it reports itself
  function openIds(robot) {
    const reported = (HL.port.robot(robot).safety?.presses || []).filter((press) => !press.is_reset).map((press) => press.stop_id);
    return [...new Set(reported.length ? reported : [...steps.values()].filter((step) => step.robot === robot).map((step) => step.stop_id))];
  }

  const name = (stop) => stop.name || HL.port.fleet()[stop.robot]?.name || stop.robot;
  HL.stops = { worst, ageMs, heardMs, standstillAt, pressedText, openIds, name };
})();
