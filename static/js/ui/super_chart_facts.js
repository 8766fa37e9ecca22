// What a chart says about its states, and what the newest report says about them: pure, no page needed.
(() => {
  "use strict";
  const OVER = 1.5; // longer than this many usual times is marked
  const OVER_LEAST_S = 2; // a second more in a state of one second is nothing

  // {byId, children, path(id)} of a chart as REST gives it
  function index(chart) {
    const byId = new Map(chart.states.map((one) => [one.id, one]));
    const children = new Map();
    const parents = new Map();
    for (const one of chart.states) {
      const parent = byId.has(one.parent) && !goesRound(one, byId) ? one.parent : null;
      parents.set(one.id, parent);
      if (!children.has(parent)) children.set(parent, []);
      children.get(parent).push(one);
    }
    // outermost first, the state itself last
    const path = (id) => {
      const found = [];
      for (let one = byId.get(id); one; one = byId.get(parents.get(one.id))) found.unshift(one);
      return found;
    };
    return { byId, children, path, kids: (id) => children.get(id) ?? [] };
  }

  // whether a state is among those that hold it: such a circle is cut open, as in the drawing
  function goesRound(state, byId) {
    for (let at = byId.get(state.parent), steps = 0; at && steps <= byId.size; at = byId.get(at.parent), steps += 1) if (at === state) return true;
    return false;
  }

  const isLeaf = (facts, id) => !facts.kids(id).length;

  // longer in it than is usual
  const isOver = (normalS, seconds) => Boolean(normalS) && seconds > Math.max(normalS * OVER, normalS + OVER_LEAST_S);

  // seconds a state is active; while nothing is heard the time stands still at what was last heard
  function seconds(since, t, ageMs, staleMs) {
    return Math.max(0, (t + Math.min(ageMs, staleMs) - since) / 1000);
  }

  // the words of the breadcrumb: composites, then the inner state of the region that moved last
  function crumbs(facts, states, last) {
    const active = states.map(([id]) => id).filter((id) => facts.byId.has(id));
    const leaves = active.filter((id) => isLeaf(facts, id));
    const leaf = leaves.includes(last?.target) ? last.target : leaves[0] ?? active.at(-1);
    return leaf === undefined ? [] : facts.path(leaf);
  }

  // transitions into and out of a state: {out: [...], into: [...]}
  function moves(chart, id) {
    return { out: chart.transitions.filter((one) => one.source === id), into: chart.transitions.filter((one) => one.target === id) };
  }

  // 12 -> "12 s", 134 -> "2:14", 6720 -> "1 h 52"
  function span(s) {
    if (s < 59.5) return `${Math.max(0, Math.round(s))} s`;
    const whole = Math.round(s);
    return whole < 3600 ? `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}` : `${Math.floor(whole / 3600)} h ${String(Math.floor((whole % 3600) / 60)).padStart(2, "0")}`;
  }

  const home = typeof HL === "undefined" ? (globalThis.HLC ??= {}) : HL;
  home.chartFacts = { index, isLeaf, isOver, seconds, crumbs, moves, span };
})();
