// Rows and bars of the durations: what was recorded, carried on by what is active now. Pure.
(() => {
  "use strict";
  const home = typeof HL === "undefined" ? (globalThis.HLC ??= {}) : HL;
  const TONES = [1, 2, 3];
  const SAME_MS = 1500; // the record and the newest report tell of one stay
  const KEPT_MS = 120000; // by then the record has it

  // the row of a state: its region, and outside of regions its subsystem
  function laneOf(facts, id) {
    const path = facts.path(id);
    const region = path.slice(0, -1).reverse().find((one) => one.kind === "region");
    return region ? region.label : path.at(-1)?.subsystem || "Other";
  }

  // in the robot's order: regions as its chart lists them, then what is outside of them
  function laneOrder(facts, intervals) {
    const regions = facts ? [...facts.byId.values()].filter((one) => one.kind === "region").map((one) => one.label) : [];
    const others = [...new Set(intervals.map((one) => one.lane))].filter((lane) => !regions.includes(lane)).sort();
    return [...regions, ...others];
  }

  // What begins and ends between two looks at the record. A report says which states are active since when, in ms of the
  // console's own clock; memory: {on: {id: since}, ended: [{state, start, end}]}
  const memory = () => ({ on: new Map(), ended: [] });
  function follow(kept, { t, states }) {
    const on = new Map(states);
    const begun = states.filter(([id, since]) => kept.on.get(id) !== since).map(([, since]) => since);
    if (!begun.length && on.size === kept.on.size) return;
    const end = Math.min(t, ...begun);
    for (const [state, start] of kept.on) if (on.get(state) !== start) kept.ended.push({ state, start, end: Math.max(end, start) });
    kept.ended = kept.ended.filter((one) => one.end > end - KEPT_MS);
    kept.on = on;
  }

  // The same on the record's clock, which is the console's: this machine's may be minutes apart. now and now_m are one
  // moment by both.
  function onRecord(kept, { now, now_m }) {
    const wall = (t) => now + t - now_m;
    return { active: [...kept.on].map(([id, since]) => [id, wall(since)]), ended: kept.ended.map((one) => ({ ...one, start: wall(one.start), end: wall(one.end) })) };
  }

  // intervals of the record, with what ended since: a record that knows the end is right
  function withEnded(intervals, facts, ended) {
    const left = new Set(ended.filter((one) => isLeaf(facts, one.state)));
    const known = intervals.map((one) => {
      const same = [...left].find((other) => other.state === one.state && Math.abs(other.start - one.start) < SAME_MS);
      left.delete(same);
      return same && one.end === null ? { ...one, end: same.end } : one;
    });
    return [...known, ...[...left].map((one) => ({ ...begun(facts, one.state, one.start), end: one.end }))];
  }

  const isLeaf = (facts, id) => !facts.kids(id).length; // one that its chart does not have is shown by its name

  // intervals of the record, with what began and ended since: active is [[id, start (ms of the record)]]
  function withActive(recorded, facts, active, ended = []) {
    if (!facts || !active) return recorded;
    const intervals = withEnded(recorded, facts, ended);
    const on = new Map(active.filter(([id]) => isLeaf(facts, id)));
    const seen = new Set();
    const carried = intervals.map((one) => {
      if (on.has(one.state) && Math.abs(on.get(one.state) - one.start) < SAME_MS) {
        seen.add(one.state);
        return { ...one, end: null };
      }
      return one.end === null ? { ...one, end: endOf(one, facts, on), is_guessed: true } : one;
    });
    return [...carried, ...[...on].filter(([id]) => !seen.has(id)).map(([id, start]) => begun(facts, id, start))];
  }

  // it is not active any more: what is active in its row says when that began
  function endOf(one, facts, on) {
    const next = [...on].filter(([id, start]) => laneOf(facts, id) === one.lane && start >= one.start).map(([, start]) => start);
    return next.length ? Math.min(...next) : one.start;
  }

  function begun(facts, id, start) {
    const state = facts.byId.get(id) ?? { label: id, subsystem: "", normal_s: null };
    return { state: id, label: state.label, subsystem: state.subsystem, lane: laneOf(facts, id), path: facts.path(id).map((one) => one.label), start, end: null, result: "", normal_s: state.normal_s, is_guessed: false };
  }

  // how dark a state is drawn: resting light, the others of a row in turn by their place in the chart, so that no state
  // changes its tone when an old stay leaves the picture
  function toneOf(resting, facts, intervals) {
    const order = facts ? [...facts.byId.keys()].filter((id) => isLeaf(facts, id)) : [];
    const others = [...new Set(intervals.map((one) => one.state))].filter((id) => !order.includes(id)).sort();
    const lanes = new Map(intervals.map((one) => [one.state, one.lane]));
    const tones = new Map();
    const next = new Map();
    for (const id of [...order, ...others]) {
      if (resting.has(id)) continue;
      const lane = lanes.get(id) ?? laneOf(facts, id);
      const at = next.get(lane) ?? 0;
      next.set(lane, at + 1);
      tones.set(id, TONES[at % TONES.length]);
    }
    return (one) => tones.get(one.state) ?? 0;
  }

  // [{lane, bars: [{key, x, w, tone, label, isOver, isOpen, planned, one}]}] for a span drawn `width` px wide
  function rows(intervals, facts, resting, { start, end, width }) {
    const px = width / Math.max(1, end - start);
    const tone = toneOf(new Set(resting), facts, intervals);
    const lanes = new Map(laneOrder(facts, intervals).map((lane) => [lane, []]));
    for (const one of [...intervals].sort((a, b) => a.start - b.start)) {
      const until = one.end ?? end;
      if (until < start || one.start > end) continue;
      const x = (Math.max(one.start, start) - start) * px;
      const w = Math.max(1.5, (Math.min(until, end) - start) * px - x - 1);
      const isOver = home.chartFacts.isOver(one.normal_s, (until - one.start) / 1000);
      const planned = one.normal_s && until - one.start > one.normal_s * 1000 ? (one.start + one.normal_s * 1000 - start) * px : null;
      lanes.get(one.lane).push({ key: `${one.state}.${one.start}`, x, w, tone: tone(one), label: one.label, isOver, isOpen: one.end === null, planned: planned !== null && planned > x + 1 ? planned : null, one });
    }
    return [...lanes].filter(([, bars]) => bars.length).map(([lane, bars]) => ({ lane, bars: merged(bars) }));
  }

  // a long mission has more stays than pixels: neighbours too thin to see are one bar
  function merged(bars) {
    const kept = [];
    for (const bar of bars) {
      const last = kept.at(-1);
      const isThin = last && last.w < 2.2 && bar.w < 2.2 && bar.x - (last.x + last.w) < 1.2 && !last.isOver && !bar.isOver && !bar.isOpen;
      if (isThin && last.many) last.w = bar.x + bar.w - last.x;
      else if (isThin) kept[kept.length - 1] = { ...last, w: bar.x + bar.w - last.x, many: true, label: "" };
      else kept.push(bar);
    }
    return kept;
  }

  // where the axis has its lines: [[ms, words]] for the last minutes, or by the clock for a mission
  function axis(start, end, isLive, clock) {
    const span = end - start;
    const step = [10, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 43200, 86400].map((s) => s * 1000).find((ms) => span / ms <= 10.5) ?? span / 8;
    const marks = [];
    if (isLive) for (let back = 0; back <= span + 1; back += step) marks.push([end - back, back ? `−${ago(back)}` : "now"]);
    else for (let at = Math.ceil(start / step) * step; at <= end; at += step) marks.push([at, clock(at)]);
    return marks;
  }

  const ago = (ms) => (ms >= 7200000 ? `${Math.round(ms / 3600000)} h` : ms >= 60000 && ms % 60000 === 0 ? `${ms / 60000} min` : `${Math.round(ms / 1000)} s`);

  home.ganttRows = { rows, memory, follow, onRecord, withActive, axis, laneOf };
})();
