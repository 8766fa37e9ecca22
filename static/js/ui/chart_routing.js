// Ways of the transitions between the boxes of a chart: straight lines on a grid, around what they do not concern,
// apart from one another. Pure. A way crosses the border of a composite only to get in or out of it.
(() => {
  "use strict";
  const home = typeof HL === "undefined" ? (globalThis.HLC ??= {}) : HL;
  const { CELL, HEAD } = home.placing;
  const BEND = 9, SHARED = 26, CROSSED = 4, TAKEN = 24, HUGGED = 1.2, TITLED = 7, OFF_CENTRE = 0.7;
  const MANY = 4;
  const HASTE = 1.5; // the search goes rather straight to its goal: a little longer ways, found in a tenth of the time
  const STEP_X = [1, 0, -1, 0], STEP_Y = [0, 1, 0, -1];

  // the cheapest first; keys and values in two plain columns
  class Heap {
    constructor() {
      this.keys = [];
      this.values = [];
      this.size = 0;
    }
    push(key, value) {
      const { keys, values } = this;
      let i = this.size;
      this.size += 1;
      while (i > 0) {
        const p = (i - 1) >> 1;
        if (keys[p] <= key) break;
        keys[i] = keys[p];
        values[i] = values[p];
        i = p;
      }
      keys[i] = key;
      values[i] = value;
    }
    pop() {
      const { keys, values } = this;
      const top = values[0];
      const n = (this.size -= 1);
      const key = keys[n], value = values[n];
      let i = 0;
      for (;;) {
        let c = 2 * i + 1;
        if (c >= n) break;
        if (c + 1 < n && keys[c + 1] < keys[c]) c += 1;
        if (keys[c] >= key) break;
        keys[i] = keys[c];
        values[i] = values[c];
        i = c;
      }
      keys[i] = key;
      values[i] = value;
      return top;
    }
  }

  class Ground {
    constructor(laid) {
      this.laid = laid;
      this.nx = Math.round(laid.w / CELL) + 1;
      this.ny = Math.round(laid.h / CELL) + 1;
      const n = this.nx * this.ny;
      this.solid = new Int16Array(n); // number of the simple state here
      this.border = new Int16Array(n); // number of the composite whose border is here
      this.extra = new Float32Array(n);
      this.used = [new Uint8Array(n), new Uint8Array(n)]; // ways along x, along y
      this.taken = new Uint8Array(n);
      this.best = new Float32Array(n * 4);
      this.round = new Int32Array(n * 4);
      this.from = new Int32Array(n * 4);
      this.goal = new Int32Array(n);
      this.goalCost = new Float32Array(n);
      this.rounds = 0;
      this.number = new Map([...laid.places.keys()].map((id, i) => [id, i + 1]));
      for (const [id, p] of laid.places) this.mark(id, p);
    }

    mark(id, p) {
      const number = this.number.get(id);
      const [x0, y0, x1, y1] = this.cells(p);
      if (p.isRegion) {
        for (let x = x0; x <= x1; x += 1) this.extra[y0 * this.nx + x] += 5;
        this.title(x0, y0, Math.min(x1, x0 + 12), y0 + 3);
        return;
      }
      if (p.isFrame) {
        for (let x = x0; x <= x1; x += 1) this.border[y0 * this.nx + x] = this.border[y1 * this.nx + x] = number;
        for (let y = y0; y <= y1; y += 1) this.border[y * this.nx + x0] = this.border[y * this.nx + x1] = number;
        this.title(x0 + 1, y0 + 1, Math.min(x1, x0 + 22), y0 + HEAD / CELL - 1);
        this.title(Math.max(x0, x1 - 10), y0 + 1, x1 - 1, y0 + HEAD / CELL - 1);
        return;
      }
      for (let y = y0; y <= y1; y += 1) for (let x = x0; x <= x1; x += 1) this.solid[y * this.nx + x] = number;
      for (let x = x0; x <= x1; x += 1) for (const y of [y0 - 1, y1 + 1]) if (y >= 0 && y < this.ny) this.extra[y * this.nx + x] += HUGGED;
      for (let y = y0; y <= y1; y += 1) for (const x of [x0 - 1, x1 + 1]) if (x >= 0 && x < this.nx) this.extra[y * this.nx + x] += HUGGED;
    }

    title(x0, y0, x1, y1) {
      for (let y = y0; y <= y1; y += 1) for (let x = x0; x <= x1; x += 1) this.extra[y * this.nx + x] += TITLED;
    }

    cells(p) {
      return [Math.round(p.x / CELL), Math.round(p.y / CELL), Math.round((p.x + p.w) / CELL), Math.round((p.y + p.h) / CELL)];
    }

    // places where a way may leave or meet a box: [cell, direction out of it, cost]
    ports(id, isInward) {
      const p = this.laid.places.get(id);
      const [x0, y0, x1, y1] = this.cells(p);
      const found = [];
      const head = p.isFrame && isInward ? HEAD / CELL : 1;
      const add = (x, y, d, off, long) => {
        const cell = y * this.nx + x;
        found.push([cell, isInward ? (d + 2) % 4 : d, off * (long > 12 ? 0.12 : OFF_CENTRE) + (this.taken[cell] ? TAKEN : 0)]);
      };
      const [cx, cy] = [(x0 + x1) / 2, (y0 + y1) / 2];
      for (let x = x0 + 1; x < x1; x += 1) {
        if (!(p.isFrame && isInward)) add(x, y0, 3, Math.abs(x - cx), x1 - x0);
        add(x, y1, 1, Math.abs(x - cx), x1 - x0);
      }
      for (let y = y0 + head; y < y1; y += 1) {
        add(x0, y, 2, Math.abs(y - cy), y1 - y0);
        add(x1, y, 0, Math.abs(y - cy), y1 - y0);
      }
      return found;
    }

    // the way as cells from source to target, null where there is none
    find(source, target) {
      const chain = (id) => {
        const list = [];
        for (let node = this.laid.nodes.get(id)?.parent; node; node = node.parent) list.push(node.id);
        return list;
      };
      const [above, over] = [chain(source), chain(target)];
      const isInto = over.includes(source);
      const isOutOf = above.includes(target);
      const through = new Set([...above.filter((id) => !over.includes(id) && id !== target), ...over.filter((id) => !above.includes(id) && id !== source)].map((id) => this.number.get(id)));
      return this.search(this.ports(source, isInto), this.ports(target, isOutOf), through);
    }

    search(starts, ends, through) {
      const { nx, ny, solid, border, extra, best, round, from, goal, goalCost, used } = this;
      const now = (this.rounds += 1);
      let gx0 = nx, gy0 = ny, gx1 = 0, gy1 = 0;
      for (const [cell, d, off] of ends) {
        goal[cell] = now * 8 + ((d + 2) % 4); // it is met against the direction that leads out of it
        goalCost[cell] = off;
        const x = cell % nx, y = (cell / nx) | 0;
        gx0 = Math.min(gx0, x), gx1 = Math.max(gx1, x), gy0 = Math.min(gy0, y), gy1 = Math.max(gy1, y);
      }
      const open = new Heap();
      const put = (cell, x, y, d, cost, before) => {
        const key = cell * 4 + d;
        if (round[key] === now && best[key] <= cost) return;
        round[key] = now;
        best[key] = cost;
        from[key] = before;
        const dx = x < gx0 ? gx0 - x : x > gx1 ? x - gx1 : 0;
        const dy = y < gy0 ? gy0 - y : y > gy1 ? y - gy1 : 0;
        open.push(cost + (dx + dy + (dx > 0 && dy > 0 ? BEND : 0)) * HASTE, key);
      };
      for (const [cell, d, off] of starts) put(cell, cell % nx, (cell / nx) | 0, d, off, -1);
      while (open.size) {
        const key = open.pop();
        const cost = best[key];
        const cell = key >> 2, d = key & 3;
        const isStart = from[key] === -1;
        if (!isStart && goal[cell] === now * 8 + d) return this.trace(key);
        const isStraight = isStart || border[cell] !== 0;
        const x = cell % nx, y = (cell / nx) | 0;
        for (let turn = 0; turn < 4; turn += 1) {
          if (turn === (d ^ 2) || (isStraight && turn !== d)) continue;
          const X = x + STEP_X[turn], Y = y + STEP_Y[turn];
          if (X < 0 || Y < 0 || X >= nx || Y >= ny) continue;
          const next = Y * nx + X;
          const isGoal = goal[next] === now * 8 + turn;
          if (!isGoal) {
            if (solid[next]) continue;
            const wall = border[next];
            if (wall && (!through.has(wall) || !this.isAcross(next, turn, wall))) continue;
          }
          const along = used[turn & 1], across = used[(turn & 1) ^ 1];
          let step = 1 + extra[next];
          if (along[next]) step += along[cell] ? SHARED : 0;
          else if (across[next]) step += CROSSED;
          if (turn !== d) step += BEND + (along[cell] ? SHARED / 2 : 0);
          put(next, X, Y, turn, cost + step + (isGoal ? goalCost[next] : 0), key);
        }
      }
      return null;
    }

    // across the border, not along it, and not through a corner
    isAcross(cell, turn, wall) {
      const { nx, border } = this;
      const [a, b] = turn & 1 ? [cell - 1, cell + 1] : [cell - nx, cell + nx];
      return border[a] === wall && border[b] === wall;
    }

    trace(key) {
      const cells = [];
      for (let at = key; at !== -1; at = this.from[at]) cells.push(at >> 2);
      cells.reverse();
      this.taken[cells[0]] = this.taken[cells.at(-1)] = 1;
      for (let i = 1; i < cells.length; i += 1) {
        const axis = Math.abs(cells[i] - cells[i - 1]) === 1 ? 0 : 1;
        this.used[axis][cells[i]] = this.used[axis][cells[i - 1]] = 1;
      }
      return cells;
    }

    corners(cells) {
      const { nx } = this;
      const points = cells.map((cell) => [(cell % nx) * CELL, ((cell / nx) | 0) * CELL]);
      return points.filter((p, i) => i === 0 || i === points.length - 1 || (points[i - 1][0] - p[0]) * (p[1] - points[i + 1][1]) !== (points[i - 1][1] - p[1]) * (p[0] - points[i + 1][0]));
    }
  }

  // transitions of the same two states are one line: [{source, target, numbers, points, isMany, isForced}]
  // isMany: so many states lead there that the drawing has one sign for them all
  function route(chart, laid) {
    const ground = new Ground(laid);
    const pairs = new Map();
    chart.transitions.forEach((t, number) => {
      if (!laid.places.has(t.source) || !laid.places.has(t.target) || t.source === t.target) return;
      if (laid.places.get(t.source).isRegion || laid.places.get(t.target).isRegion) return;
      const key = `${t.source}>${t.target}`;
      if (!pairs.has(key)) pairs.set(key, { source: t.source, target: t.target, numbers: [] });
      pairs.get(key).numbers.push(number);
    });
    const middle = (id) => {
      const p = laid.places.get(id);
      return [p.x + p.w / 2, p.y + p.h / 2];
    };
    const length = ({ source, target }) => {
      const [a, b] = [middle(source), middle(target)];
      return Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]);
    };
    const into = new Map();
    for (const { target } of pairs.values()) into.set(target, (into.get(target) ?? 0) + 1);
    for (const way of pairs.values()) way.isMany = into.get(way.target) >= MANY;
    // what is always seen comes first and gets the better ways
    const ways = [...pairs.values()].sort((a, b) => a.isMany - b.isMany || length(a) - length(b));
    for (const way of ways) {
      const cells = ground.find(way.source, way.target);
      way.points = cells ? ground.corners(cells) : [middle(way.source), middle(way.target)];
      way.isForced = !cells;
    }
    return ways;
  }

  // The whole drawing of a chart as plain data: {w, h, places: [[id, place]], ways}. Where the states stand is known in a
  // twentieth of the time that the lines take: placed is called with it, without lines.
  function chartLayout(chart, widths, window, placed) {
    const laid = home.placing.place(chart, new Map(Object.entries(widths)), window);
    const layout = { w: laid.w, h: laid.h, places: [...laid.places], ways: [] };
    placed?.(layout);
    return { ...layout, ways: route(chart, laid) };
  }

  home.chartLayout = chartLayout;
})();
