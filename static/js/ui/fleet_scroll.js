// A list of any length with the nodes of one screenful: lines have known heights, those out of sight are not there.
(() => {
  "use strict";
  const { el, style } = HL;
  const SPARE_PX = 300; // drawn beyond both edges, so that a flick shows no gap

  class Scroll {
    // make(line) -> {node, paint(line)}; a line is {key, kind, height, ...}
    constructor(node, make, resized = () => {}) {
      this.node = node;
      this.make = make;
      this.lines = [];
      this.tops = [];
      this.shown = new Map();
      this.space = el("div", { class: "f-space" });
      // asked of the page when they change alone: asking in the middle of writing lays out the whole page
      [this.top, this.width, this.height] = [0, 0, 0];
      node.append(this.space);
      node.addEventListener("scroll", () => ((this.top = node.scrollTop), this.draw()), { passive: true });
      this.watch = new ResizeObserver(() => {
        [this.width, this.height, this.top] = [node.clientWidth, node.clientHeight, node.scrollTop];
        this.draw();
        resized();
      });
      this.watch.observe(node);
    }
    set(lines) {
      this.lines = lines;
      this.tops = new Array(lines.length);
      let top = 0;
      lines.forEach((line, i) => {
        this.tops[i] = top;
        top += line.height;
      });
      this.total = top;
      style(this.space, "height", `${top}px`);
      this.draw();
    }
    // first line whose end lies below `y`
    at(y) {
      let low = 0;
      let high = this.lines.length;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (this.tops[middle] + this.lines[middle].height <= y) low = middle + 1;
        else high = middle;
      }
      return low;
    }
    draw() {
      const { top, height } = this;
      const wanted = new Set();
      for (let i = this.at(top - SPARE_PX); i < this.lines.length && this.tops[i] < top + height + SPARE_PX; i += 1) {
        const line = this.lines[i];
        wanted.add(line.key);
        let held = this.shown.get(line.key);
        if (!held || held.kind !== line.kind) {
          held?.view.node.remove();
          held = { kind: line.kind, view: this.make(line) };
          this.shown.set(line.key, held);
          this.space.append(held.view.node);
        }
        style(held.view.node, "transform", `translateY(${this.tops[i]}px)`);
        style(held.view.node, "height", `${line.height - (line.gap ?? 0)}px`);
        held.view.paint(line);
      }
      for (const [key, held] of this.shown) {
        if (wanted.has(key)) continue;
        held.view.node.remove();
        this.shown.delete(key);
      }
    }
    // bring a line into sight, by as little as needed
    reveal(key) {
      const i = this.lines.findIndex((line) => line.key === key || line.keys?.includes(key));
      if (i < 0) return;
      const { scrollTop, clientHeight } = this.node;
      if (this.tops[i] < scrollTop + 40) this.node.scrollTop = this.tops[i] - 40;
      else if (this.tops[i] + this.lines[i].height > scrollTop + clientHeight) this.node.scrollTop = this.tops[i] + this.lines[i].height - clientHeight;
    }
    destroy() {
      this.watch.disconnect();
    }
  }

  HL.FleetScroll = Scroll;
})();
