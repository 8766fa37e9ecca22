// What the fleet screen knows beside the lane: groups, saved views, duty, today's figures, the frozen queue; and what is chosen.
(() => {
  "use strict";
  const DAY_MS = 10000; // today's sums grow slowly
  const LOOK_MS = 500; // the list is put in order as often as the lane brings it
  const MANY = 2000; // beyond it every second time: nobody reads so many twice a second
  const EARLY_MS = 60; // a list that came a little before its time is looked at with it
  const QUIET_MS = 1000; // ages run on also while the lane brings nothing
  const FILTER_KEY = "headland.fleet.filter";
  const NO_FILTER = { q: "", sort: "attention", families: [], group: "", mine: false, state: "" };

  const data = {
    groups: [], views: [], duty: {}, freed: {}, people: [], book: [], day: null, freeze: null,
    filter: { ...NO_FILTER, ...HL.keep.read(FILTER_KEY, {}), q: "" },
    stop: window.headlandStop?.state() ?? null, chosen: new Set(), open: new Set(), current: null, items: [], notices: [], listeners: new Set(),
    areGroupsKnown: false, looks: 0, order: 0, marks: 0, // counted up at each look, when the order of the list may differ, when the map's marks do
  };

  const me = () => HL.config.user?.id ?? "";
  const can = (right) => HL.config.rights.includes(right);
  const changed = () => (data.listeners.forEach((listener) => listener()), HL.repaint());

  const asked = {}; // by path: how often it was asked for, and the newest of these answers
  const answered = {};
  async function load(path, take) {
    const number = (asked[path] = (asked[path] ?? 0) + 1);
    const answer = await HL.port.api("GET", path);
    if (answer.ok && number > (answered[path] ?? 0)) { // one that a newer answer overtook says nothing any more
      answered[path] = number;
      take(answer);
      look();
    }
    return answer;
  }
  const loadGroups = () => load("/fleet/groups", (answer) => (Object.assign(data, { groups: answer.groups, areGroupsKnown: true }), isGroupGone() && setFilter({}), HL.emit("hl-groups")));
  const loadViews = () => load("/fleet/views", (answer) => (data.views = answer.views));
  const loadDuty = () => load("/fleet/duty", (answer) => Object.assign(data, { duty: answer.duty, freed: answer.freed ?? {}, people: answer.people, book: answer.book }));
  const loadDay = () => load("/fleet/kpis", (answer) => (data.day = { ...answer, at: performance.now() }));
  const loadFreeze = () => load("/queue", (answer) => (data.freeze = answer.frozen ?? null));

  const known = new Map(); // robot id -> its item, judged anew only when something was told about it
  const worst = { of: null, found: {} };
  let ranked = -1; // the order in which names were compared last

  function worstAlarms() {
    const alarms = window.headland.state("alarms")?.alarms;
    if (worst.of !== alarms) Object.assign(worst, { of: alarms, found: HL.fleetOrder.worstAlarms(alarms) });
    return worst.found;
  }

  // what concerns no robot: looked at anew when an alarm or the number of robots changed
  const told = { of: null, count: -1, found: [] };
  function noticed(robots) {
    const alarms = window.headland.state("fleet") ? window.headland.state("alarms")?.alarms : null;
    if (told.of === alarms && told.count === HL.port.ids.size) return told.found;
    const before = JSON.stringify(told.found);
    Object.assign(told, { of: alarms, count: HL.port.ids.size, found: HL.fleetOrder.notices(alarms, robots) });
    if (JSON.stringify(told.found) !== before) data.order += 1;
    return told.found;
  }

  // Looked at when the lane has brought something, in the same frame in which the map draws it: a frame more costs as much again.
  let lookedAt = -Infinity;
  let due = null;
  function soon() {
    const pause = (data.items.length > MANY ? 2 : 1) * LOOK_MS - EARLY_MS;
    due ??= setTimeout(() => ((due = null), users && look()), Math.max(0, pause - (performance.now() - lookedAt)));
  }

  // one look at everything: what the list, the map and the strip show from now on
  function look() {
    const robots = HL.port.fleet();
    const alarms = worstAlarms();
    data.notices = noticed(robots);
    const stops = stopStates();
    const now = window.headland.now();
    lookedAt = performance.now();
    data.looks += 1;
    data.items = [];
    for (const id of HL.port.ids) if (robots[id]) data.items.push(seen(known.get(id) ?? begun(id, robots[id]), robots[id], now, stops.get(id), alarms[id]));
    if (known.size > data.items.length) gone(robots);
    if (data.order !== ranked) HL.fleetOrder.rank(data.items);
    ranked = data.order;
    changed();
  }

  function begun(id, robot) {
    const one = { id, robot, ageMs: Infinity, verdict: null };
    known.set(id, one);
    data.order += 1;
    return one;
  }

  function gone(robots) {
    for (const id of [...known.keys()]) if (!(id in robots)) known.delete(id);
    for (const id of [...data.chosen]) if (!(id in robots)) data.chosen.delete(id);
    data.order += 1;
  }

  function seen(one, robot, now, stop, alarm) {
    const ageMs = typeof robot.t === "number" && now !== null ? Math.max(0, now - robot.t) : Infinity;
    const duty = data.duty[one.id];
    const responsible = duty?.name ?? "";
    const isHandedOver = responsible !== one.responsible;
    if (duty !== one.duty) Object.assign(one, { duty, responsible });
    one.ageMs = ageMs;
    const before = one.verdict;
    const isLost = ageMs > HL.LOST_MS;
    if (before && !isHandedOver && !isLost && !before.isLost && !stop && one.robot === robot && one.alarm === alarm && !one.stop) return one;
    if (one.robot.field !== robot.field || one.robot.family !== robot.family || one.robot.name !== robot.name) data.order += 1;
    Object.assign(one, { robot, alarm, stop, verdict: HL.fleetOrder.judge(robot, { ageMs, stop, alarm, words: HL.words, responsible }) });
    const verdict = one.verdict;
    if (!before || HL.fleetOrder.isMoved(before, verdict)) data.order += 1;
    if (!before || ((before.level || verdict.level) && (before.level !== verdict.level || before.head !== verdict.head || before.look !== verdict.look))) data.marks += 1;
    return one;
  }

  // what STOP knows is told at each change; asking for it costs a look at every robot
  window.addEventListener("headland:stop", ({ detail }) => (data.stop = detail));

  // the worst press of each robot; `t` as console time, so that it compares with everything else
  function stopStates() {
    const failing = new Map();
    const now = window.headland.now();
    for (const step of data.stop?.steps ?? []) {
      if (step.state === "not-confirmed") failing.set(step.robot, { state: step.state, t: now === null ? null : now - (performance.now() - step.at) });
    }
    return failing;
  }

  // a group that somebody deleted would hide every robot
  const isGroupGone = () => Boolean(data.filter.group) && data.areGroupsKnown && !data.groups.some((one) => one.id === data.filter.group);
  function setFilter(change) {
    data.filter = { ...data.filter, ...change };
    if (isGroupGone()) {
      data.filter.group = "";
      HL.toast("The group of this filter was deleted. The filter by group is off.", "group");
    }
    HL.keep.write(FILTER_KEY, { ...data.filter, q: "" });
    look();
  }
  const isNarrowed = ({ q, families, group, mine, state }) => Boolean(q || families.length || group || mine || state);
  const visible = () => (isNarrowed(data.filter) ? data.items.filter((one) => HL.fleetOrder.passes(one, data.filter, { me: me(), groups: data.groups })) : data.items);

  function choose(id, isChosen = !data.chosen.has(id)) {
    if (isChosen) data.chosen.add(id);
    else data.chosen.delete(id);
    changed();
  }
  function chooseAll(ids) {
    data.chosen = new Set(ids);
    changed();
  }
  function setCurrent(id) {
    data.current = id;
    changed();
  }

  const item = (id) => known.get(id);
  const name = (id) => HL.port.fleet()[id]?.name ?? id;
  const chosen = () => (data.chosen.size ? data.items.filter((one) => data.chosen.has(one.id)) : []);

  let users = 0;
  let timers = [];
  const offs = [];
  function begin() {
    users += 1;
    if (users > 1) return;
    timers = [setInterval(() => performance.now() - lookedAt > QUIET_MS && look(), LOOK_MS), setInterval(loadDay, DAY_MS)];
    offs.push(...["fleet", "alarms"].map((topic) => window.headland.on(topic, soon)), window.headland.on("event", event), window.headland.on("hello", loadAll));
    loadAll();
    look();
  }
  // also when the line is back: what changed meanwhile was told to nobody here
  function loadAll() {
    for (const one of [loadGroups, loadViews, loadDuty, loadDay, loadFreeze]) one();
  }
  function end() {
    users -= 1;
    if (users) return;
    timers.forEach(clearInterval);
    offs.splice(0).forEach((off) => off());
  }
  function event(told) {
    if (told?.kind === "duty") loadDuty();
    if (told?.kind === "fleet" && told.what === "groups") loadGroups();
    if (told?.kind === "queue" && ["frozen", "released"].includes(told.what)) loadFreeze();
  }

  HL.fleet = Object.assign(data, { NO_FILTER, me, can, begin, end, look, setFilter, isNarrowed, visible, choose, chooseAll, setCurrent, item, name, picked: chosen, loadGroups, loadViews, loadDuty, changed });
})();
