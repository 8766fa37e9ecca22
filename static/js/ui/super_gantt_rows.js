// Rows and bars of the durations: what was recorded, carried on by what is active now. Pure.
(() => {
  "use strict";
  const home = typeof HL === "undefined" ? (globalThis.HLC ??= {}) : HL;
  const TONES = [1, 2, 3];

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

  // intervals of the record, with what began since: active is [[id, start (wall ms)]]
  function withActive(intervals, facts, active) {
    if (!facts || !active) return intervals;
    const on = new Map(active.filter(([id]) => facts.byId.has(id) && !facts.kids(id).length));
    const seen = new Set();
    const near = (a, b) => Math.abs(a - b) < 1500;
    const carried = intervals.map((one) => {
      const start = on.get(one.state);
      if (one.end !== null) {
        if (start !== undefined && near(start, one.start)) seen.add(one.state), (one = { ...one, end: null });
        return one;
      }
      if (start !== undefined && near(start, one.start)) {
        seen.add(one.state);
        return one;
      }
      // it ended since: another of its row is active now, and says when that began
      const lane = one.lane;
      const next = [...on].filter(([id, begun]) => laneOf(facts, id) === lane && begun >= one.start).map(([, begun]) => begun);
      return { ...one, end: Math.max(one.start, Math.min(...next, Infinity) === Infinity ? one.start : Math.min(...next)), is_guessed: true };
    });
    for (const [id, start] of on) {
      if (seen.has(id)) continue;
      const state = facts.byId.get(id);
      carried.push({ state: id, label: state.label, subsystem: state.subsystem, lane: laneOf(facts, id), path: facts.path(id).map((one) => one.label), start, end: null, result: "", normal_s: state.normal_s, is_guessed: false });
    }
    return carried;
  }

  // how dark a state is drawn: resting light, the others of a row in turn; the same state always alike
  function toneOf(resting) {
    const tones = new Map();
    const next = new Map();
    return (one) => {
      if (resting.has(one.state)) return 0;
      const key = `${one.lane}|${one.state}`;
      if (!tones.has(key)) {
        const at = next.get(one.lane) ?? 0;
        next.set(one.lane, at + 1);
        tones.set(key, TONES[at % TONES.length]);
      }
      return tones.get(key);
    };
  }

  // [{lane, bars: [{key, x, w, tone, label, isOver, isOpen, planned, one}]}] for a span drawn `width` px wide
  function rows(intervals, facts, resting, { start, end, width }) {
    const px = width / Math.max(1, end - start);
    const tone = toneOf(new Set(resting));
    const lanes = new Map(laneOrder(facts, intervals).map((lane) => [lane, []]));
    for (const one of [...intervals].sort((a, b) => a.start - b.start)) {
      const until = one.end ?? end;
      if (until < start || one.start > end) {
        tone(one);
        continue;
      }
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
    const step = [60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 43200, 86400].map((s) => s * 1000).find((ms) => span / ms <= 10.5) ?? span / 8;
    const marks = [];
    if (isLive) for (let back = 0; back <= span + 1; back += step) marks.push([end - back, back ? `−${back >= 7200000 ? `${Math.round(back / 3600000)} h` : `${Math.round(back / 60000)} min`}` : "now"]);
    else for (let at = Math.ceil(start / step) * step; at <= end; at += step) marks.push([at, clock(at)]);
    return marks;
  }

  home.ganttRows = { rows, withActive, axis, laneOf };
})();
