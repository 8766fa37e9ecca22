// Drawing an area on a picture of a field: around it with a finger, corner by corner, or with the arrow keys.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const NS = "http://www.w3.org/2000/svg";
  const TAP_PX = 12; // a finger that moved less has tapped
  const NEAR_PX = 28; // so near to the first corner closes the area
  const LEAST_PX = 5; // a finger's line is no more exact
  const LEAST_AREA_PX = 150;
  const STEP_PX = 12;
  const HOW = "Draw around it with a finger, or tap its corners. Two fingers move the map.";
  const MOST_CORNERS = 400;

  const svg = (tag, props) => {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(props)) node.setAttribute(key, value);
    return node;
  };
  const line = (points, isClosed) => (points.length ? `M${points.map(([x, y]) => `${x.toFixed(3)} ${y.toFixed(3)}`).join("L")}${isClosed ? "Z" : ""}` : "");

  class AreaPen {
    // view: an SvgView; done(ring): corners in its metres
    constructor(view, done) {
      Object.assign(this, { view, done, corners: [], trace: null, isOn: false });
      this.ink = svg("g", { class: "a-ink" });
      this.said = el("span", { class: "h-t14 h-b h-sp", role: "status", "data-testid": "area-said" });
      this.back = el("button", { type: "button", class: "h-btn", "data-testid": "area-undo", onclick: () => this.undo() }, icon("undo", "m"), "Corner back");
      this.finish = el("button", { type: "button", class: "h-btn pri", "data-testid": "area-done", onclick: () => this.close() }, icon("check", "m"), "Done");
      this.bar = el("div", { class: "a-bar", role: "toolbar", "aria-label": "Drawing", hidden: true }, this.said, this.back, this.finish, el("button", { type: "button", class: "h-btn", "data-testid": "area-cancel", onclick: () => this.stop() }, "Cancel"));
      const { root } = view;
      const on = (name, act) => root.addEventListener(name, (event) => this.isOn && act(event));
      on("pointerdown", (event) => this.down(event));
      on("pointermove", (event) => this.moved(event));
      on("pointerup", (event) => this.up(event));
      on("pointercancel", () => (this.trace = null, this.draw()));
      on("keydown", (event) => this.key(event));
    }

    start() {
      Object.assign(this, { corners: [], trace: null, cross: null, isOn: true });
      this.view.isHeld = true;
      this.view.root.append(this.ink);
      attr(this.view.root, "tabindex", "0");
      attr(this.view.root, "data-state", "drawing");
      this.bar.hidden = false;
      this.view.root.focus({ preventScroll: true });
      this.say(HOW);
      this.draw();
    }

    stop() {
      Object.assign(this, { corners: [], trace: null, isOn: false });
      this.view.isHeld = false;
      this.bar.hidden = true;
      attr(this.view.root, "tabindex", null);
      attr(this.view.root, "data-state", null);
      this.ink.replaceChildren();
      this.ended?.();
    }

    down(event) {
      if (this.view.pointers.size > 1) return (this.trace = null); // two fingers move the map
      this.from = event;
      this.trace = [this.view.metres(event)];
    }

    moved(event) {
      if (!this.trace || event.pointerId !== this.from.pointerId) return;
      if (this.view.pointers.size > 1) this.trace = null;
      else this.trace.push(this.view.metres(event));
      this.draw();
    }

    up(event) {
      const trace = this.trace;
      this.trace = null;
      if (!trace || event.pointerId !== this.from.pointerId) return this.draw();
      const far = Math.max(...trace.map(([x, y]) => Math.hypot(x - trace[0][0], y - trace[0][1]))) / this.view.px;
      if (far < TAP_PX) return this.corner(trace[0]);
      this.corners = [];
      return this.take(HL.areaShape.closed(trace, LEAST_PX * this.view.px));
    }

    corner(point) {
      const [first] = this.corners;
      if (this.corners.length >= 3 && Math.hypot(point[0] - first[0], point[1] - first[1]) < NEAR_PX * this.view.px) return this.close();
      if (this.corners.length < MOST_CORNERS) this.corners.push(point);
      this.say(this.corners.length < 3 ? HOW : "Tap the first corner, or Done, to close it.");
      return this.draw();
    }

    undo() {
      this.corners.pop();
      this.say(HOW);
      this.draw();
    }

    close() {
      this.take(this.corners);
    }

    take(ring) {
      const problem = HL.areaShape.problem(ring, LEAST_AREA_PX * this.view.px ** 2);
      if (problem) {
        this.say(problem);
        return this.draw();
      }
      this.stop();
      return this.done(ring);
    }

    // the keyboard moves a cross and sets corners with it
    key(event) {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      const px = this.view.px * (event.shiftKey ? 1 : STEP_PX);
      this.cross ??= [this.view.window.x, this.view.window.y];
      if (step) this.cross = [this.cross[0] + step[0] * px, this.cross[1] + step[1] * px];
      else if (event.key === "Enter" || event.key === " ") this.corner(this.cross);
      else if (event.key === "Backspace") this.undo();
      else if (event.key === "Escape") this.stop();
      else return;
      event.preventDefault();
      event.stopPropagation();
      if (this.isOn) this.draw();
    }

    draw() {
      const { px } = this.view;
      const points = this.trace ?? this.corners;
      const dots = this.trace ? [] : this.corners.map(([x, y], k) => svg("circle", { cx: x, cy: y, r: (k ? 5 : 8) * px }));
      const [x, y] = this.cross ?? [0, 0];
      const cross = this.cross ? [svg("path", { class: "cross", d: `M${x - 10 * px} ${y}h${20 * px}M${x} ${y - 10 * px}v${20 * px}` })] : [];
      this.ink.replaceChildren(svg("path", { d: line(points, points.length > 2) }), ...dots, ...cross);
      this.back.disabled = !this.corners.length;
      this.finish.disabled = this.corners.length < 3;
    }

    say(words) {
      text(this.said, words);
    }
  }

  // drawn ground as shapes: an obstacle with its clearance as a band
  function areaShapes(areas) {
    return areas.flatMap(({ look, ring, clearance_m: wide = 0 }) => [
      ...(wide ? [svg("path", { class: "a-clear", d: line(ring, true), style: `stroke-width: ${(2 * wide).toFixed(2)}px` })] : []),
      svg("path", { class: `a-area ${look}`, d: line(ring, true) }),
    ]);
  }

  Object.assign(HL, { AreaPen, areaShapes });
})();
