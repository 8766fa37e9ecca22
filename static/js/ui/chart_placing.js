// Where the states of a chart stand: nested boxes, parallel regions above one another, chosen to fill a window best.
// Pure: the same chart and window give the same places. Lengths are px of the drawing, multiples of CELL.
(() => {
  "use strict";
  const CELL = 8; // lanes of transitions are this far apart
  const BOX_H = 48;
  const BOX_W = 104;
  const GAP_X = 5 * CELL;
  const GAP_Y = 4 * CELL;
  const PAD = 3 * CELL;
  const HEAD = 5 * CELL; // name and time of a composite
  const TITLE = 3 * CELL; // name of a region
  const MOST_OPTIONS = 10; // of each composite, the ones of different shape
  const MOST_SWEEPS = 6;
  const MOST_LENGTHS = 400000; // looked at for one shape of a group: a tenth of a second

  const up = (px) => Math.ceil(px / CELL) * CELL;
  const sum = (list) => list.reduce((a, b) => a + b, 0);

  // {id: {state, parent, children, depth, index}} and the roots; a parent that is not there counts as none
  function treeOf(states) {
    const nodes = new Map(states.map((state, index) => [state.id, { id: state.id, state, index, children: [], parent: null }]));
    const roots = [];
    for (const node of nodes.values()) {
      const parent = nodes.get(node.state.parent);
      if (parent && !isBelow(parent, node, nodes)) {
        node.parent = parent;
        parent.children.push(node);
      } else roots.push(node);
    }
    return { nodes, roots };
  }

  // a chart whose parents go round in a circle is cut open
  function isBelow(node, other, nodes) {
    for (let at = node, steps = 0; at && steps <= nodes.size; at = nodes.get(at.state.parent), steps += 1) if (at === other) return true;
    return false;
  }

  // an option is {w, h, lay(x, y, w, h, out)}: a shape, and how to fill a place of at least that size
  function box(node, width) {
    return { w: up(Math.max(BOX_W, width)), h: BOX_H, lay: (x, y, w, h, out) => out.set(node.id, { x, y, w, h }) };
  }

  function fewest(options) {
    const sorted = [...options].sort((a, b) => a.w - b.w || a.h - b.h);
    const kept = [];
    for (const one of sorted) if (!kept.length || one.h < kept.at(-1).h) kept.push(one);
    while (kept.length > MOST_OPTIONS) {
      // the two most alike: the one that takes more room goes
      let worst = 1;
      for (let i = 1; i < kept.length - 1; i += 1) if (kept[i + 1].w / kept[i - 1].w < kept[worst + 1].w / kept[worst - 1].w) worst = i;
      kept.splice(worst, 1);
    }
    return kept;
  }

  // which of the given nodes the transitions connect, with both ends lifted to them
  function linksAmong(nodes, chart) {
    const holder = new Map();
    const claim = (node, owner) => (holder.set(node.id, owner), node.children.forEach((child) => claim(child, owner)));
    nodes.forEach((node, i) => claim(node, i));
    return chart.transitions.map((t) => [holder.get(t.source), holder.get(t.target)]).filter(([a, b]) => a !== undefined && b !== undefined && a !== b);
  }

  // slots of a grid, row by row, every other row backwards, so that a chain turns the corner
  function snake(count, columns) {
    return Array.from({ length: count }, (_, i) => {
      const row = Math.floor(i / columns);
      const column = i % columns;
      return [row % 2 ? columns - 1 - column : column, row];
    });
  }

  // first the initial state, then along the transitions; what nothing leads to comes in the robot's order
  function flowOrder(nodes, links) {
    const first = Math.max(0, nodes.findIndex((node) => node.state.is_initial));
    const order = [];
    const seen = new Set();
    const walk = (i) => {
      if (seen.has(i)) return;
      seen.add(i);
      order.push(i);
      for (const [a, b] of links) if (a === i) walk(b);
    };
    walk(first);
    nodes.forEach((_, i) => walk(i));
    return order;
  }

  // how far and how crooked a transition runs between slots
  function length([a, b], slots) {
    const dx = Math.abs(slots[a][0] - slots[b][0]);
    const dy = Math.abs(slots[a][1] - slots[b][1]);
    return dx + dy * 1.1 + (dx && dy ? 0.7 : 0) + (dx + dy > 1 && !(dx && dy) ? 1.4 : 0);
  }

  // states change places as long as that shortens the transitions; of a huge chart as long as nobody waits for it
  function improve(slots, links, free) {
    const own = slots.map((_, i) => links.filter(([a, b]) => a === i || b === i));
    const others = (i, j) => (j < slots.length ? own[j].filter(([a, b]) => a !== i && b !== i) : []);
    const cost = (lines) => lines.reduce((total, one) => total + length(one, slots), 0);
    let left = MOST_LENGTHS;
    for (let sweep = 0, better = true; better && sweep < MOST_SWEEPS; sweep += 1) {
      better = false;
      for (let i = 0; i < slots.length && left > 0; i += 1) {
        for (let j = 0; j < slots.length + free.length; j += 1) {
          const swap = () => {
            if (j < slots.length) [slots[i], slots[j]] = [slots[j], slots[i]];
            else [slots[i], free[j - slots.length]] = [free[j - slots.length], slots[i]];
          };
          const moved = [...own[i], ...others(i, j)];
          const before = cost(moved);
          swap();
          left -= moved.length;
          if (cost(moved) < before - 1e-9) better = true;
          else swap();
        }
      }
    }
  }

  function grid(nodes, options, links, columns) {
    const rows = Math.ceil(nodes.length / columns);
    const all = snake(rows * columns, columns);
    const order = flowOrder(nodes, links);
    const slots = [];
    order.forEach((i, at) => (slots[i] = all[at]));
    improve(slots, links, all.slice(nodes.length));
    const widths = Array.from({ length: columns }, (_, c) => Math.max(0, ...options.filter((_, i) => slots[i][0] === c).map((one) => one.w)));
    const used = widths.filter((w) => w > 0).length;
    const w = sum(widths) + Math.max(0, used - 1) * GAP_X;
    const h = rows * BOX_H + (rows - 1) * GAP_Y;
    const lay = (x, y, wide, high, out) => {
      const spare = used > 1 ? Math.min(Math.floor((wide - w) / (used - 1) / CELL) * CELL, 7 * CELL) : 0;
      const tall = rows > 1 ? Math.min(Math.floor((high - h) / (rows - 1) / CELL) * CELL, 3 * CELL) : 0;
      const lefts = [];
      widths.reduce((at, width, c) => ((lefts[c] = at), width ? at + width + GAP_X + Math.max(0, spare) : at), x);
      options.forEach((one, i) => one.lay(lefts[slots[i][0]], y + slots[i][1] * (BOX_H + GAP_Y + Math.max(0, tall)), widths[slots[i][0]], BOX_H, out));
    };
    return { w, h, lay };
  }

  function grids(nodes, options, chart) {
    const links = linksAmong(nodes, chart);
    const found = [];
    let rows = 0;
    for (let columns = nodes.length; columns >= 1; columns -= 1) {
      const now = Math.ceil(nodes.length / columns);
      if (now === rows && nodes.length > 3) continue;
      rows = now;
      found.push(grid(nodes, options, links, Math.ceil(nodes.length / now)));
    }
    return fewest(found);
  }

  // several parts side by side or above one another, each in one of its shapes
  function row(parts, gap) {
    return { w: sum(parts.map((p) => p.w)) + gap * (parts.length - 1), h: Math.max(...parts.map((p) => p.h)), lay: (x, y, w, h, out) => {
      const spare = w - sum(parts.map((p) => p.w)) - gap * (parts.length - 1);
      parts.reduce((at, p, i) => {
        const wide = p.w + (i === parts.length - 1 ? Math.max(0, spare) : 0);
        p.lay(at, y, wide, h, out);
        return at + wide + gap;
      }, x);
    } };
  }

  function column(parts, gap) {
    return { w: Math.max(...parts.map((p) => p.w)), h: sum(parts.map((p) => p.h)) + gap * (parts.length - 1), lay: (x, y, w, h, out) => {
      const spare = Math.max(0, h - sum(parts.map((p) => p.h)) - gap * (parts.length - 1));
      const more = Math.floor(spare / parts.length / CELL) * CELL;
      parts.reduce((at, p) => (p.lay(x, at, w, p.h + more, out), at + p.h + more + gap), y);
    } };
  }

  // above one another for each width that one of them asks for: every other takes its flattest shape that fits
  function stacks(groups, gap) {
    const widths = [...new Set(groups.flat().map((one) => one.w))].sort((a, b) => a - b);
    const least = Math.max(...groups.map((options) => Math.min(...options.map((one) => one.w))));
    return widths.filter((w) => w >= least).map((w) => column(groups.map((options) => options.filter((one) => one.w <= w).reduce((a, b) => (b.h < a.h ? b : a))), gap));
  }

  function rows(groups, gap) {
    const heights = [...new Set(groups.flat().map((one) => one.h))].sort((a, b) => a - b);
    const least = Math.max(...groups.map((options) => Math.min(...options.map((one) => one.h))));
    return heights.filter((h) => h >= least).map((h) => row(groups.map((options) => options.filter((one) => one.h <= h).reduce((a, b) => (b.w < a.w ? b : a))), gap));
  }

  // a column of simple states, spread over the height it is given
  function side(nodes, options, links, columns) {
    const inner = grid(nodes, options, links, columns);
    const perColumn = Math.ceil(nodes.length / columns);
    const lay = (x, y, w, h, out) => {
      const spare = perColumn > 1 ? Math.floor(Math.min((h - inner.h) / (perColumn - 1), 5 * CELL) / CELL) * CELL : 0;
      const found = new Map();
      inner.lay(x, 0, inner.w, inner.h, found);
      for (const [id, place] of found) out.set(id, { ...place, y: y + place.y + Math.max(0, spare) * Math.round(place.y / (BOX_H + GAP_Y)) });
    };
    return { ...inner, lay };
  }

  function mixed(simple, simpleOptions, nested, chart) {
    const links = linksAmong(simple, chart);
    const both = fewest([...stacks(nested, GAP_Y + CELL), ...rows(nested, GAP_X)]);
    const found = [];
    for (let columns = 1; columns <= Math.min(3, simple.length); columns += 1) {
      const left = side(simple, simpleOptions, links, columns);
      for (const right of both) found.push(row([left, right], GAP_X + 2 * CELL));
    }
    for (const top of grids(simple, simpleOptions, chart)) for (const below of both) if (top.w <= below.w * 1.1) found.push(column([fixed(top), below], GAP_Y + 2 * CELL));
    return found;
  }

  const fixed = (one) => ({ ...one, lay: (x, y, w, h, out) => one.lay(x, y, w, one.h, out) });

  function inside(nodes, widths, chart) {
    const simple = nodes.filter((node) => !node.children.length);
    const nested = nodes.filter((node) => node.children.length);
    const flat = simple.map((node) => box(node, widths.get(node.id) ?? BOX_W));
    if (!nested.length) return grids(simple, flat, chart);
    const groups = nested.map((node) => frame(node, widths, chart));
    if (!simple.length) return fewest([...stacks(groups, GAP_Y), ...rows(groups, GAP_X)]);
    return fewest(mixed(simple, flat, groups, chart));
  }

  // a composite around what is in it; regions have a title and no box
  function frame(node, widths, chart) {
    const isParallel = node.state.kind === "parallel" || node.children.some((child) => child.state.kind === "region");
    const isRegion = node.state.kind === "region";
    const options = isParallel ? fewest(stacks(node.children.map((child) => (child.children.length ? frame(child, widths, chart) : [box(child, widths.get(child.id) ?? BOX_W)])), CELL)) : inside(node.children, widths, chart);
    const [left, top, bottom] = isRegion ? [0, TITLE, 2 * CELL] : [isParallel ? 2 * CELL : PAD, HEAD, isParallel ? 0 : PAD];
    const least = up((widths.get(node.id) ?? 0) + 2 * PAD);
    return options.map((one) => ({ w: Math.max(one.w + 2 * left, least), h: one.h + top + bottom, lay: (x, y, w, h, out) => {
      out.set(node.id, { x, y, w, h, isFrame: !isRegion, isRegion });
      one.lay(x + left, y + top, w - 2 * left, h - top - bottom, out);
    } }));
  }

  // {w, h, places: {id: {x, y, w, h, isFrame, isRegion}}}; window: the px it shall fill
  function place(chart, widths, window) {
    const { nodes, roots } = treeOf(chart.states);
    const options = inside(roots, widths, chart).map((one) => ({ ...one, w: one.w + 2 * PAD, h: one.h + 2 * PAD, inner: one }));
    const scale = (one) => Math.min(window.w / one.w, window.h / one.h);
    const best = options.reduce((a, b) => (scale(b) > scale(a) * 1.001 ? b : a));
    // what is left of the window in one direction is given to the boxes in it
    const room = scale(best);
    const w = Math.min(Math.floor(window.w / room / CELL) * CELL, Math.floor((best.w * 1.5) / CELL) * CELL);
    const h = Math.min(Math.floor(window.h / room / CELL) * CELL, Math.floor((best.h * 1.4) / CELL) * CELL);
    const places = new Map();
    best.inner.lay(PAD, PAD, Math.max(best.w, w) - 2 * PAD, Math.max(best.h, h) - 2 * PAD, places);
    return { w: Math.max(best.w, w), h: Math.max(best.h, h), places, nodes, roots };
  }

  const home = typeof HL === "undefined" ? (globalThis.HLC ??= {}) : HL;
  home.placing = { place, treeOf, CELL, HEAD, TITLE };
})();
