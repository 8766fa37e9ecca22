// What the Sensors screen knows: stations, gate and forecast as REST told them last, what is chosen, and the series of the chart.
(() => {
  "use strict";
  const R = HL.sensorRules;
  const POLL_MS = 10000; // stations report every minute or less often; ages run in between
  const AGAIN_MS = 3000; // while there is no answer
  const NEWS_MS = 1000;
  const KEY = () => `headland.sensors.${HL.config.user?.id ?? "-"}`;
  const kept = () => HL.keep.read(KEY(), {});

  const data = {
    found: null, // the last answer of GET /sensors
    problem: null, // why the newest one is missing: {status, text}
    begun: 0,
    chosen: null, // id of a station; null shows all
    shown: null, // {station, key} of the chart
    span: "24h",
    series: null, // {found, problem, isLoading, at, of}
    listeners: new Set(),
  };
  let asked = { mono: 0, wall: 0 };
  let timer = null;
  let isOpen = false;
  let turn = 0;
  let drawn = 0;

  // s since the answer was asked for; a tablet that slept counts its sleep
  const passedS = () => (data.found ? Math.max(performance.now() - asked.mono, Date.now() - asked.wall) / 1000 : Infinity);
  const now = () => R.nowMs(data.found?.now_utc, passedS());
  const stations = () => (data.found ? R.aged(data.found.stations ?? [], passedS()) : []);
  const station = (id) => stations().find((one) => one.id === id) ?? null;
  const may = (what) => Boolean(data.found?.can?.[what]);
  const askedAt = () => HL.words.day(new Date(asked.wall));
  const told = () => {
    for (const listener of data.listeners) listener();
    HL.repaint();
  };

  async function load() {
    clearTimeout(timer);
    if (!isOpen || document.hidden) return;
    const mine = ++turn;
    const at = { mono: performance.now(), wall: Date.now() };
    const answer = await HL.port.api("GET", "/sensors");
    if (!isOpen || mine !== turn) return;
    if (answer.ok) {
      asked = at;
      Object.assign(data, { found: answer.data, problem: null });
      HL.keep.write(KEY(), { ...kept(), count: (answer.data.stations ?? []).length });
      settle();
    } else data.problem = { status: answer.status, text: answer.text };
    told();
    if (answer.status === 403) return;
    timer = setTimeout(load, answer.ok ? POLL_MS : AGAIN_MS);
    if (answer.ok) loadSeries(false);
  }

  // what is chosen may be gone; the chart begins with the wind, for it is what treatment waits for
  function settle() {
    const all = stations();
    if (data.chosen && !all.some((one) => one.id === data.chosen)) data.chosen = null;
    const has = ({ station: id, key }) => all.some((one) => one.id === id && one.values.some((value) => value.key === key));
    if (data.shown && has(data.shown) && (!data.chosen || data.shown.station === data.chosen)) return;
    const tiles = R.tiles(all, data.chosen);
    const first = tiles.find(({ value }) => value.quantity === "wind_speed") ?? tiles[0];
    data.shown = first ? { station: first.station.id, key: first.value.key } : null;
  }

  function choose(id) {
    if (data.chosen === id) return;
    data.chosen = id;
    settle();
    told();
    loadSeries(false);
  }

  function show(stationId, key) {
    data.shown = { station: stationId, key };
    told();
    loadSeries(false);
  }

  function setSpan(span) {
    data.span = span;
    HL.keep.write(KEY(), { ...kept(), span });
    told();
    loadSeries(false);
  }

  // what the chart is about: {station, value, key, span}; null without any value
  function subject() {
    const one = data.shown && station(data.shown.station);
    const value = one?.values.find((other) => other.key === data.shown.key);
    return value ? { station: one, value, key: `${one.id}|${value.key}|${data.span}` } : null;
  }

  // asked again when its newest step may be over, at once when it is another one
  async function loadSeries(isAsked) {
    const about = subject();
    if (!about) return void (data.series = null);
    const isOther = data.series?.of !== about.key;
    const isThin = !isOther && (data.series.problem || !data.series.found?.read.some((one) => one.mean !== null));
    const every = isThin ? POLL_MS / 2 : HL.sensorScale.SPANS[data.span].every; // what is missing may be there with the next values
    if (!isOther && !isAsked && (data.series.isLoading || performance.now() - data.series.at < every)) return undefined;
    const mine = ++drawn;
    data.series = { ...(isOther ? {} : data.series), of: about.key, isLoading: true, at: performance.now() };
    HL.repaint();
    const { quantity, depth_m: depth } = about.value;
    const query = new URLSearchParams({ quantity, span: data.span, ...(depth === null || depth === undefined ? {} : { depth_m: String(depth) }) });
    const answer = await HL.port.api("GET", `/sensors/${encodeURIComponent(about.station.id)}/series?${query}`);
    if (!isOpen || mine !== drawn) return undefined;
    data.series = { ...data.series, isLoading: false, problem: answer.ok ? null : answer.text || "No answer.", ...(answer.ok ? { found: { ...answer.data, read: HL.sensorScale.read(answer.data.points) } } : {}) };
    HL.repaint();
    return undefined;
  }

  let newsTimer = null;
  function news(event) {
    if (event?.kind !== "sensors" || !isOpen || newsTimer) return;
    load();
    newsTimer = setTimeout(() => (newsTimer = null), NEWS_MS);
  }
  const seen = () => (document.hidden ? clearTimeout(timer) : load());

  let off = null;
  function begin() {
    isOpen = true;
    Object.assign(data, { begun: performance.now(), problem: null, span: kept().span in HL.sensorScale.SPANS ? kept().span : "24h" });
    off = window.headland.on("event", news);
    document.addEventListener("visibilitychange", seen);
    load();
  }
  function end() {
    isOpen = false;
    clearTimeout(timer);
    off?.();
    document.removeEventListener("visibilitychange", seen);
  }

  // changes by people; afterwards the list is asked for, so that the screen shows what the console kept
  async function send(method, path, body) {
    const answer = await HL.port.api(method, path, body);
    if (answer.ok) load();
    return answer;
  }

  HL.sensors = Object.assign(data, { begin, end, load, loadSeries, choose, show, setSpan, subject, stations, station, passedS, now, askedAt, may, send, count: () => kept().count ?? 0 });
})();
