// What should be looked at before a plan is sent, from what the robot says now; what nobody knows is said to be unknown.
(() => {
  "use strict";
  const { el, icon, alarm, LiveElement, define, attr } = HL;
  const OLD_MS = 10000; // a battery does not change faster; an older figure says nothing about now

  const percent = (share) => `${Math.round(100 * share)} %`;
  const good = (words) => ({ state: "good", words });
  const bad = (words) => ({ state: "bad", words });
  const unknown = (words) => ({ state: "unknown", words });

  // statistics: of the plan; robot: entry of the fleet; ageMs: since it was heard
  function battery(statistics, robot, ageMs) {
    const has = robot?.soc;
    const [store, charge, fill] = statistics.is_tank ? ["Tank", "tank", "Refuel"] : ["Battery", "charge", "Charge"];
    if (has === null || has === undefined || ageMs > OLD_MS) return unknown(`${store} is not known now`);
    const needs = statistics.battery_share + (statistics.reserve_share ?? 0.15);
    if (needs <= has) return good(`${store} is enough: ${percent(has)} now`);
    if (needs > 1) return bad(`Not enough: needs ${percent(needs)} with reserve, has ${percent(has)}. One ${charge} does not last.`);
    return bad(`Not enough: needs ${percent(needs)}, has ${percent(has)}. ${fill} ${chargeTime(statistics, needs - has)}first.`);
  }

  // "1 h 10 ", rounded up to five minutes; nothing where the robot does not say how fast it charges
  function chargeTime({ battery_j: full, charge_w: power }, share) {
    if (!full || !power) return "";
    const minutes = 5 * Math.ceil((share * full) / power / 300 - 1e-9);
    const [h, min] = [Math.floor(minutes / 60), minutes % 60];
    return h ? `${h} h ${String(min).padStart(2, "0")} ` : `${min} min `;
  }

  function link(name, robot, ageMs) {
    if (!robot || !Number.isFinite(ageMs)) return unknown(`${name} was not heard yet`);
    return robot.is_online ? good(`${name} is linked`) : bad(`${name} is not heard. It cannot take a mission now.`);
  }

  function state(name, robot) {
    if (robot?.mode === "stopped") return bad(`${name} is stopped. Reset it before it can start.`);
    if (robot?.mode === "fault") return bad(`${name} has a fault: ${robot.text || "look at it"}`);
    if (robot?.mode === "auto" || robot?.mode === "paused") return bad(`${name} has a mission under way`);
    return null;
  }

  function fix(groups) {
    const tile = groups.tiles?.find((one) => one.key === "gnss");
    if (!tile || tile.missing) return unknown("Position is not known yet");
    if (HL.port.age(tile.t) > OLD_MS) return unknown("Position is old");
    return tile.level ? bad(`Position is ${tile.text} ${tile.unit}`.trim()) : good(`Position is ${tile.text} ${tile.unit}`.trim());
  }

  class PlanChecks extends LiveElement {
    build() {
      this.list = el("div", { class: "p-checklist" });
      this.append(el("h3", { class: "h-t16 h-b" }, "Before sending"), this.list);
    }
    leave() {
      this.onLeave?.();
    }
    // model: {robot: id, name, statistics}
    set(model) {
      this.model = model;
      HL.repaint();
    }
    paint() {
      attr(this, "hidden", !this.model);
      if (!this.model) return;
      const { robot: id, name, statistics } = this.model;
      const robot = HL.port.fleet()[id];
      const ageMs = robot ? HL.port.age(robot.t) : Infinity;
      const found = [
        ["battery", battery(statistics, robot, ageMs)], ["link", link(name, robot, ageMs)], ["state", state(name, robot)],
        ["position", fix(HL.port.robot(id))], ["people", unknown("People near the robot cannot be seen from here")],
      ].filter(([, check]) => check);
      const key = JSON.stringify(found);
      if (key === this.drawn) return;
      this.drawn = key;
      const signs = { good: () => icon("check", "m"), bad: () => alarm(3, 22), unknown: () => icon("help", "m") };
      this.list.replaceChildren(...found.map(([hook, check]) => el("div", { class: "h-row h-t14 p-check", "data-testid": `plan-check-${hook}`, "data-state": check.state }, signs[check.state](), el("span", {}, check.words))));
    }
  }

  define("hl-plan-checks", PlanChecks);
})();
