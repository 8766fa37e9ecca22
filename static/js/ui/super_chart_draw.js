// The drawing of a chart from its layout: made once; afterwards only classes and times change.
(() => {
  "use strict";
  const { svg, text, attr, toggle } = HL;
  const CORNER = 7;

  // straight pieces with round corners
  function wayPath(points) {
    let d = `M${points[0].join(" ")}`;
    for (let i = 1; i < points.length - 1; i += 1) {
      const [a, b, c] = [points[i - 1], points[i], points[i + 1]];
      const r = Math.min(CORNER, reach(a, b) / 2, reach(b, c) / 2);
      const [from, to] = [toward(b, a, r), toward(b, c, r)];
      d += `L${from.join(" ")}Q${b.join(" ")} ${to.join(" ")}`;
    }
    return `${d}L${points.at(-1).join(" ")}`;
  }

  const reach = (a, b) => Math.abs(a[0] - b[0]) + Math.abs(a[1] - b[1]);
  const toward = (from, to, r) => [from[0] + Math.sign(to[0] - from[0]) * r, from[1] + Math.sign(to[1] - from[1]) * r];

  function longest(points) {
    let best = 1;
    for (let i = 2; i < points.length; i += 1) if (reach(points[i - 1], points[i]) > reach(points[best - 1], points[best])) best = i;
    return [(points[best - 1][0] + points[best][0]) / 2, (points[best - 1][1] + points[best][1]) / 2];
  }

  const words = (attributes, content) => {
    const node = svg("text", attributes);
    node.textContent = content;
    return node;
  };

  class ChartDrawing {
    constructor(root, facts, layout) {
      Object.assign(this, { root, facts, layout });
      this.nodes = new Map();
      this.ways = new Map();
      this.places = new Map(layout.places);
      this.marker("s-arrow", 7);
      this.marker("s-arrow-last", 5.2);
      const [frames, boxes] = [svg("g", {}), svg("g", {})];
      this.lines = svg("g", { "aria-hidden": "true" });
      root.append(frames, this.lines, boxes);
      for (const [id, place] of layout.places) this.state(id, place, frames, boxes);
      this.lead(layout.ways);
      this.lastTime = words({ class: "s-lasttime", "text-anchor": "middle" }, "");
      root.append(this.lastTime);
    }

    // the lines of a layout whose states are drawn; false where it is another one
    connect(layout) {
      const isSame = !this.ways.size && layout.w === this.layout.w && layout.h === this.layout.h && layout.places.length === this.places.size;
      if (!isSame) return false;
      this.layout = layout;
      this.lead(layout.ways);
      return true;
    }

    lead(ways) {
      const busy = new Map();
      for (const way of ways) {
        this.lines.append(this.way(way));
        if (way.isMany) busy.set(way.target, (busy.get(way.target) ?? 0) + 1);
      }
      for (const [id, count] of busy) this.any(id, count, this.lines);
    }

    marker(id, size) {
      const mark = svg("marker", { id, viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: size, markerHeight: size, orient: "auto" }, svg("path", { d: "M0 0 8 4 0 8z" }));
      this.root.append(svg("defs", {}, mark));
    }

    state(id, { x, y, w, h, isFrame, isRegion }, frames, boxes) {
      const state = this.facts.byId.get(id);
      if (isRegion) {
        const isFirst = this.facts.kids(state.parent)[0]?.id === id;
        if (!isFirst) frames.append(svg("path", { class: "s-divide", d: `M${x} ${y}H${x + w}` }));
        frames.append(words({ class: "s-region", x, y: y + 17 }, state.label));
        return;
      }
      const kind = isFrame ? "s-frame" : "s-state";
      const group = svg("g", { class: kind, "data-id": id, tabindex: "-1", role: "button", "data-kind": state.kind });
      const rect = svg("rect", { x, y, width: w, height: h, rx: 5 });
      const label = words(isFrame ? { class: "label", x: x + 12, y: y + 25 } : { class: "label", x: x + w / 2, y: y + h / 2 + 5, "text-anchor": "middle" }, state.label);
      const time = words(isFrame ? { class: "time", x: x + w - 12, y: y + 25, "text-anchor": "end" } : { class: "time", x: x + w / 2, y: y + h / 2 + 16, "text-anchor": "middle" }, "");
      group.append(rect, label, time);
      if (state.kind === "final") group.append(svg("rect", { class: "inner", x: x + 4, y: y + 4, width: w - 8, height: h - 8, rx: 3 }));
      if (state.is_initial) group.append(svg("circle", { class: "initial", cx: x, cy: y, r: 5 }));
      (isFrame ? frames : boxes).append(group);
      this.nodes.set(id, { group, label, time, state, isFrame, y, h, x, w });
    }

    way({ source, target, points, isMany }) {
      const line = svg("path", { class: isMany ? "s-way many" : "s-way", d: wayPath(points), "marker-end": "url(#s-arrow)" });
      this.ways.set(`${source}>${target}`, { line, source, target, at: longest(points) });
      return line;
    }

    // a state that nearly every other leads to, such as Stopped: one sign; its lines show when it or the other is chosen
    any(id, count, lines) {
      const node = this.nodes.get(id);
      if (!node || node.isFrame) return;
      const [x, y] = [node.x + 10, node.y];
      const sign = svg("g", {}, svg("circle", { class: "s-anydot", cx: x, cy: y - 15, r: 3 }), svg("path", { class: "s-any", d: `M${x} ${y - 15}V${y - 1}`, "marker-end": "url(#s-arrow)" }));
      const said = svg("title", {});
      said.textContent = `${count} states lead here`;
      sign.append(said);
      lines.append(sign);
    }

    // all lines of the state that is chosen
    near(id) {
      for (const way of this.ways.values()) toggle(way.line, "near", id !== undefined && (way.source === id || way.target === id));
    }

    // which are active, and the last change; called only when the robot says something new
    mark(states, last) {
      const active = new Set(states.map(([id]) => id));
      for (const [id, node] of this.nodes) {
        const isOn = active.has(id);
        toggle(node.group, "on", isOn);
        if (!isOn) this.plain(node);
        attr(node.group, "aria-label", `${node.state.label}${isOn ? ", active" : ""}`);
      }
      const way = last && this.ways.get(`${last.source}>${last.target}`);
      if (way !== this.lastWay) {
        if (this.lastWay) this.emphasise(this.lastWay, false);
        if (way) this.emphasise(way, true);
        this.lastWay = way;
      }
      text(this.lastTime, way ? last.wall : "");
      if (way) (attr(this.lastTime, "x", way.at[0]), attr(this.lastTime, "y", way.at[1] - 6));
    }

    emphasise(way, isLast) {
      toggle(way.line, "last", isLast);
      attr(way.line, "marker-end", `url(#s-arrow${isLast ? "-last" : ""})`);
      if (isLast) way.line.parentNode.append(way.line); // above the others
    }

    plain(node) {
      text(node.time, "");
      toggle(node.group, "over", false);
      if (!node.isFrame) attr(node.label, "y", node.y + node.h / 2 + 5);
    }

    // the time of an active state; seconds, and whether that is more than usual
    time(id, said, isOver) {
      const node = this.nodes.get(id);
      if (!node) return;
      text(node.time, said);
      toggle(node.group, "over", isOver);
      if (!node.isFrame) attr(node.label, "y", said ? node.y + node.h / 2 - 2 : node.y + node.h / 2 + 5);
    }

    // the state next to one in a direction, for the arrow keys
    beside(id, dx, dy) {
      const from = this.nodes.get(id);
      const middle = (n) => [n.x + n.w / 2, n.isFrame ? n.y + 20 : n.y + n.h / 2];
      const [fx, fy] = middle(from);
      let best = null;
      for (const [other, node] of this.nodes) {
        if (other === id) continue;
        const [x, y] = middle(node);
        const along = (x - fx) * dx + (y - fy) * dy;
        const aside = Math.abs((x - fx) * dy) + Math.abs((y - fy) * dx);
        if (along > 4 && (!best || along + aside * 2 < best.far)) best = { id: other, far: along + aside * 2 };
      }
      return best?.id ?? id;
    }
  }

  HL.ChartDrawing = ChartDrawing;
})();
