// Which cameras stand on the wall, and in which order. Pure.
(() => {
  "use strict";
  const VIEWS = ["front", "tool", "head", "nadir", "rear", "distance"]; // what tells most comes first
  const MOST = 64; // streams one page may watch
  const id = (one) => `${one.robot}/${one.camera}`;
  const rank = (one) => (VIEWS.indexOf(one.view) + VIEWS.length + 1) % (VIEWS.length + 1); // unknown views last

  // each robot in turn gives its first camera, then each its second
  function inTurn(cameras, robots) {
    const of = new Map();
    for (const one of [...cameras].sort((a, b) => rank(a) - rank(b) || id(a).localeCompare(id(b)))) {
      if (!of.has(one.robot)) of.set(one.robot, []);
      of.get(one.robot).push(one);
    }
    const known = robots.filter((robot) => of.has(robot));
    const rest = [...of.keys()].filter((robot) => !known.includes(robot)).sort();
    const lists = [...known, ...rest].map((robot) => of.get(robot));
    const found = [];
    for (let turn = 0; lists.some((list) => list.length > turn); turn += 1) for (const list of lists) if (list[turn]) found.push(list[turn]);
    return found;
  }

  // cameras: of GET /cameras; items: the fleet's; mode: "attention", "group" or "mine"
  function arrange(cameras, items, { mode, group = "", mine = [], groups = [] }) {
    if (mode === "mine") {
      const by = new Map(cameras.map((one) => [id(one), one]));
      return mine.map((key) => by.get(key)).filter(Boolean).slice(0, MOST);
    }
    const everybody = { has: () => true };
    const robots = HL.fleetOrder.sections(items, { groups, open: everybody }).flatMap((section) => section.items.map((one) => one.id));
    const inside = mode === "group" ? new Set(items.filter((one) => HL.fleetOrder.homeOf(one, groups) === group).map((one) => one.id)) : null;
    return inTurn(inside ? cameras.filter((one) => inside.has(one.robot)) : cameras, robots).slice(0, MOST);
  }

  // names to choose a group by: those of robots that have a camera
  function homes(cameras, items, groups) {
    const seen = new Set(cameras.map((one) => one.robot));
    return [...new Set(items.filter((one) => seen.has(one.id)).map((one) => HL.fleetOrder.homeOf(one, groups)))].sort();
  }

  Object.assign(HL.camera, { order: { arrange, homes, id, MOST } });
})();
