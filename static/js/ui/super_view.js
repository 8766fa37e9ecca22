// A drawing that is moved and zoomed by fingers, wheel, buttons and keys; a tap that did not move goes to what lies there.
(() => {
  "use strict";
  const { el, icon } = HL;
  const TAP_PX = 10;
  const NEARER = 0.98; // of the whole drawing
  const MOST_ZOOM = 6;
  const LARGEST = 1.6; // a small chart is not blown up beyond this

  class SuperView {
    constructor(root, tapped) {
      Object.assign(this, { root, tapped, size: [1, 1], isWhole: true });
      this.pointers = new Map();
      this.box = { x: 0, y: 0, w: 1, h: 1 };
      root.addEventListener("wheel", (event) => {
        if (!event.ctrlKey && !this.isFull?.()) return; // the page scrolls; with Ctrl, or in the whole window, it zooms
        event.preventDefault();
        this.zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, event);
      }, { passive: false });
      root.addEventListener("pointerdown", (event) => this.down(event));
      root.addEventListener("pointermove", (event) => this.moved(event));
      for (const name of ["pointerup", "pointercancel"]) root.addEventListener(name, (event) => this.up(event, name === "pointerup"));
      new ResizeObserver(() => (this.isWhole ? this.fit() : this.apply())).observe(root);
    }

    // everything, as large as it goes
    fit(size = this.size) {
      this.size = size;
      this.isWhole = true;
      const { width, height } = this.root.getBoundingClientRect();
      if (!width || !height) return;
      const px = Math.max(size[0] / width, size[1] / height, 1 / LARGEST);
      this.least = px;
      this.box = { x: (size[0] - width * px) / 2, y: (size[1] - height * px) / 2, w: width * px, h: height * px };
      this.apply();
    }

    // factor below 1 comes nearer; the place under at stays
    zoom(factor, at) {
      const frame = this.root.getBoundingClientRect();
      const [fx, fy] = at ? [(at.clientX - frame.left) / frame.width, (at.clientY - frame.top) / frame.height] : [0.5, 0.5];
      const { x, y, w, h } = this.box;
      const wide = Math.min(Math.max(w * factor, (frame.width * this.least) / MOST_ZOOM), frame.width * this.least * 1.5);
      const real = wide / w;
      this.isWhole = false;
      this.box = { x: x + w * fx * (1 - real), y: y + h * fy * (1 - real), w: wide, h: h * real };
      this.apply();
    }

    // so that a place of the drawing is in sight
    show({ x, y, w, h }) {
      const box = this.box;
      const dx = x < box.x ? x - box.x - 20 : x + w > box.x + box.w ? x + w - box.x - box.w + 20 : 0;
      const dy = y < box.y ? y - box.y - 20 : y + h > box.y + box.h ? y + h - box.y - box.h + 20 : 0;
      if (!dx && !dy) return;
      this.box = { ...box, x: box.x + dx, y: box.y + dy };
      this.apply();
    }

    // there is more of the drawing than is in sight
    isNear() {
      return this.box.w < this.size[0] * NEARER || this.box.h < this.size[1] * NEARER;
    }

    // by so many units of the drawing; its middle, or its edge, stays in sight
    pan(dx, dy) {
      const { x, y, w, h } = this.box;
      const within = (at, wide, size) => Math.min(Math.max(at, -wide / 2), size - wide / 2);
      this.isWhole = false;
      this.box = { x: within(x + dx, w, this.size[0]), y: within(y + dy, h, this.size[1]), w, h };
      this.apply();
    }

    apply() {
      const { x, y, w, h } = this.box;
      HL.attr(this.root, "data-near", this.isNear());
      HL.attr(this.root, "viewBox", `${x.toFixed(1)} ${y.toFixed(1)} ${w.toFixed(1)} ${h.toFixed(1)}`);
    }

    down(event) {
      this.pointers.set(event.pointerId, { at: event, from: event, hasMoved: false });
      this.root.setPointerCapture(event.pointerId);
    }

    moved(event) {
      const one = this.pointers.get(event.pointerId);
      if (!one) return;
      if (Math.hypot(event.clientX - one.from.clientX, event.clientY - one.from.clientY) > TAP_PX) one.hasMoved = true;
      const others = [...this.pointers.values()].filter((other) => other !== one);
      if (others.length) {
        const span = (p) => Math.hypot(p.clientX - others[0].at.clientX, p.clientY - others[0].at.clientY) || 1;
        this.zoom(span(one.at) / span(event), others[0].at);
        one.hasMoved = others[0].hasMoved = true;
      } else if (one.hasMoved) {
        const px = this.box.w / this.root.getBoundingClientRect().width;
        if (this.isNear()) this.pan((one.at.clientX - event.clientX) * px, (one.at.clientY - event.clientY) * px);
      }
      one.at = event;
    }

    up(event, isTap) {
      const one = this.pointers.get(event.pointerId);
      this.pointers.delete(event.pointerId);
      if (one && isTap && !one.hasMoved && !this.pointers.size) this.tapped(document.elementFromPoint(event.clientX, event.clientY));
    }

    buttons() {
      const one = (label, sign, hook, act) => el("button", { type: "button", class: "h-btn ico", "aria-label": label, title: label, "data-testid": hook, onclick: act }, sign);
      return el("div", { class: "s-zooms" }, one("Zoom in", icon("add"), "chart-zoom-in", () => this.zoom(0.66)), one("Zoom out", icon("remove"), "chart-zoom-out", () => this.zoom(1.5)), one("Whole chart", icon("fit_screen"), "chart-fit", () => this.fit()));
    }
  }

  HL.SuperView = SuperView;
})();
