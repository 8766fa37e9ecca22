// What the fleet screen knows beside the lane: groups, saved views, duty, today's figures, the frozen queue; and what is chosen.
(() => {
  "use strict";
  const DAY_MS = 10000; // today's sums grow slowly
  const LOOK_MS = 500; // the list is put in order as often as the lane brings it
  const MANY = 2000; // beyond it every second time: nobody reads so many twice a second
  const FILTER_KEY = "headland.fleet.filter";
  const NO_FILTER = { q: "", sort: "attention", families: [], group: "", mine: false, state: "" };

  const data = {
    groups: [], views: [], duty: {}, people: [], book: [], day: null, freeze: null,
    filter: { ...NO_FILTER, ...HL.keep.read(FILTER_KEY, {}), q: "" },
    stop: window.headlandStop?.state() ?? null, chosen: new Set(), open: new Set(), current: null, items: [], listeners: new Set(),
  };

  const me = () => HL.config.user?.id ?? "";
  const can = (right) => HL.config.rights.includes(right);
  const changed = () => (data.listeners.forEach((listener) => listener()), HL.repaint());

  async function load(path, take) {
    const answer = await HL.port.api("GET", path);
    if (answer.ok) {
      take(answer);
      look();
    }
    return answer;
  }
  const loadGroups = () => load("/fleet/groups", (answer) => (data.groups = answer.groups));
  const loadViews = () => load("/fleet/views", (answer) => (data.views = answer.views));
  const loadDuty = () => load("/fleet/duty", (answer) => Object.assign(data, { duty: answer.duty, people: answer.people, book: answer.book }));
  const loadDay = () => load("/fleet/kpis", (answer) => (data.day = { ...answer, at: performance.now() }));
  const loadFreeze = () => load("/queue", (answer) => (data.freeze = answer.frozen ?? null));

  // one look at everything: what the list, the map and the strip show from now on
  function look() {
    const alarms = HL.fleetOrder.worstAlarms(window.headland.state("alarms")?.alarms);
    const stops = stopStates();
    data.items = HL.fleetOrder.rank(Object.entries(HL.port.fleet()).map(([id, robot]) => {
      const ageMs = typeof robot.t === "number" ? HL.port.age(robot.t) : Infinity;
      const duty = data.duty[id];
      const verdict = HL.fleetOrder.judge(robot, { ageMs, stop: stops.get(id), alarm: alarms[id], words: HL.words });
      return { id, robot, ageMs, duty, responsible: duty?.name ?? "", verdict };
    }));
    for (const id of [...data.chosen]) if (!(id in HL.port.fleet())) data.chosen.delete(id);
    changed();
  }

  // what STOP knows is told at each change; asking for it costs a look at every robot
  window.addEventListener("headland:stop", ({ detail }) => (data.stop = detail));

  // the worst press of each robot; `t` as console time, so that it compares with everything else
  function stopStates() {
    const worst = new Map();
    const now = window.headland.now();
    for (const step of data.stop?.steps ?? []) {
      if (step.state === "not-confirmed") worst.set(step.robot, { state: step.state, t: now === null ? null : now - (performance.now() - step.at) });
    }
    return worst;
  }

  function setFilter(change) {
    data.filter = { ...data.filter, ...change };
    HL.keep.write(FILTER_KEY, { ...data.filter, q: "" });
    look();
  }
  const isNarrowed = ({ q, families, group, mine, state }) => Boolean(q || families.length || group || mine || state);
  const visible = () => data.items.filter((one) => HL.fleetOrder.passes(one, data.filter, { me: me(), groups: data.groups }));

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

  const item = (id) => data.items.find((one) => one.id === id);
  const name = (id) => HL.port.fleet()[id]?.name ?? id;
  const chosen = () => data.items.filter((one) => data.chosen.has(one.id));

  let users = 0;
  let timers = [];
  const offs = [];
  function begin() {
    users += 1;
    if (users > 1) return;
    let round = 0;
    timers = [setInterval(() => (data.items.length > MANY && (round += 1) % 2) || look(), LOOK_MS), setInterval(loadDay, DAY_MS)];
    offs.push(window.headland.on("alarms", () => {}), window.headland.on("event", event));
    loadGroups();
    loadViews();
    loadDuty();
    loadDay();
    loadFreeze();
    look();
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
