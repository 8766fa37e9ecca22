// What is known of every STOP: from the slab (gateway and console), and from the robot's own safety controller.
(() => {
  "use strict";
  const RANK = { "not-confirmed": 4, sent: 3, acknowledged: 2, standstill: 1 };
  let known = [];

  function take(state) {
    known = (state?.steps ?? []).filter((step) => step.robot && RANK[step.state]);
    HL.repaint();
  }
  window.addEventListener("headland:stop", ({ detail }) => take(detail));
  if (window.headlandStop) take(window.headlandStop.state());

  // the robot latched a press that this page never heard of from the gateway
  function fromRobot(id) {
    const { safety, id: who } = HL.port.robot(id);
    if (!safety?.latched) return null;
    const press = safety.presses.find((one) => !one.is_reset) ?? safety.presses[0];
    return {
      stop_id: press?.stop_id ?? "", robot: id, name: who?.name ?? id, by: press?.by ?? "", device: press?.device ?? "",
      state: safety.standstill ? "standstill" : "acknowledged", stopping_distance_m: safety.stopping_distance_m, pressedT: press?.t ?? safety.t,
    };
  }

  // the one to show: of this robot, or on screens of all robots of any
  function worst(robot) {
    const open = known.filter((step) => !robot || step.robot === robot);
    open.sort((a, b) => RANK[b.state] - RANK[a.state] || a.at - b.at);
    return open[0] ?? (robot ? fromRobot(robot) : null);
  }

  const ageMs = (stop) => (stop.at === undefined ? HL.port.age(stop.pressedT) : performance.now() - stop.at);

  // every press that the robot or the slab knows to be open
  function openIds(robot) {
    const open = [...(HL.port.robot(robot).safety?.presses || []), ...known].filter((one) => !one.is_reset && (one.robot ?? robot) === robot);
    return [...new Set(open.map((one) => one.stop_id))].sort();
  }

  const name = (stop) => stop.name || HL.port.fleet()[stop.robot]?.name || stop.robot;
  HL.stops = { worst, ageMs, openIds, name };
})();
