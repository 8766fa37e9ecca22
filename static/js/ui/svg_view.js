// A drawing that is moved and zoomed by fingers, wheel and buttons. One unit is a metre, y to the south.
(() => {
  "use strict";
  const MOST_ZOOM = 60;

  class SvgView {
    // free: pixels at the edges that other things stand on; changed(px): metres a pixel, after every change
    constructor(root, { free = {}, changed = () => {}, isWheelFree = () => true } = {}) {
      Object.assign(this, { root, changed, isWheelFree, free: { left: 0, right: 0, top: 0, bottom: 0, ...free } });
      this.pointers = new Map();
      this.isHeld = false; // while something is drawn one finger draws, two move the map
      this.listen();
      this.sized = new ResizeObserver(() => (this.isWhole ? this.fit() : this.apply()));
      this.sized.observe(root);
    }

    // box: [x0, y0, x1, y1] of everything, metres
    fit(box = this.box) {
      this.box = box;
      const [x0, y0, x1, y1] = box ?? [-50, -50, 50, 50];
      const { left, right, top, bottom } = this.free;
      const { width, height } = this.root.getBoundingClientRect();
      const [wide, high] = [Math.max(80, width - left - right), Math.max(80, height - top - bottom)];
      const px = Math.max((x1 - x0) / wide, (y1 - y0) / high, 0.001);
      this.window = { x: (x0 + x1) / 2 + ((right - left) / 2) * px, y: (y0 + y1) / 2 + ((bottom - top) / 2) * px, w: px * Math.max(width, 1), h: px * Math.max(height, 1) };
      this.whole = { ...this.window };
      this.isWhole = true;
      this.apply();
    }

    // factor below 1 comes nearer; at: metres that stay where they are
    zoom(factor, at) {
      if (!this.window) return;
      this.isWhole = false;
      const wanted = Math.min(Math.max(this.window.w * factor, this.whole.w / MOST_ZOOM), this.whole.w * 2);
      const real = wanted / this.window.w;
      const pin = at ?? [this.window.x, this.window.y];
      this.window.x = pin[0] + (this.window.x - pin[0]) * real;
      this.window.y = pin[1] + (this.window.y - pin[1]) * real;
      this.window.w *= real;
      this.window.h *= real;
      this.apply();
    }

    // come along with what moves: in the middle again when it leaves what is seen of the drawing
    keep([x, y]) {
      if (!this.window || this.isWhole || !this.px) return;
      const { left, right, top, bottom } = this.free;
      const { window: at, px } = this;
      const isSeen = x > at.x - at.w / 2 + left * px && x < at.x + at.w / 2 - right * px && y > at.y - at.h / 2 + top * px && y < at.y + at.h / 2 - bottom * px;
      if (isSeen) return;
      [at.x, at.y] = [x + ((right - left) / 2) * px, y + ((bottom - top) / 2) * px];
      this.apply();
    }

    apply() {
      if (!this.window) return;
      const { x, y, w, h } = this.window;
      HL.attr(this.root, "viewBox", `${(x - w / 2).toFixed(2)} ${(y - h / 2).toFixed(2)} ${w.toFixed(2)} ${h.toFixed(2)}`);
      const { width, height } = this.root.getBoundingClientRect();
      if (!width || !height) return;
      this.px = Math.max(w / width, h / height);
      this.changed(this.px);
    }

    // metres under a point of the screen
    metres({ clientX, clientY }) {
      const box = this.root.getBoundingClientRect();
      return [this.window.x + (clientX - box.left - box.width / 2) * this.px, this.window.y + (clientY - box.top - box.height / 2) * this.px];
    }

    listen() {
      const { root } = this;
      root.addEventListener("wheel", (event) => {
        if (!this.isWheelFree()) return;
        event.preventDefault();
        this.zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, this.metres(event));
      }, { passive: false });
      root.addEventListener("pointerdown", (event) => {
        root.setPointerCapture(event.pointerId);
        this.pointers.set(event.pointerId, event);
      });
      root.addEventListener("pointermove", (event) => this.moved(event));
      for (const name of ["pointerup", "pointercancel"]) root.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
      root.addEventListener("dblclick", (event) => !this.isHeld && this.zoom(0.5, this.metres(event)));
    }

    moved(event) {
      const before = this.pointers.get(event.pointerId);
      if (!before || !this.window) return;
      const others = [...this.pointers.values()].filter((one) => one.pointerId !== event.pointerId);
      if (others.length) {
        const span = (one) => Math.hypot(one.clientX - others[0].clientX, one.clientY - others[0].clientY) || 1;
        this.zoom(span(before) / span(event), this.metres(others[0]));
      }
      if (others.length || !this.isHeld) {
        const share = others.length ? 0.5 : 1; // the middle of two fingers goes half as far
        this.isWhole = false;
        this.window.x -= (event.clientX - before.clientX) * this.px * share;
        this.window.y -= (event.clientY - before.clientY) * this.px * share;
        this.apply();
      }
      this.pointers.set(event.pointerId, event);
    }

    // zoom in, zoom out, whole
    buttons() {
      const { el, icon } = HL;
      const one = (label, sign, run) => el("button", { type: "button", class: "h-btn ico p-zoom", "aria-label": label, onclick: run }, sign);
      return el("div", { class: "p-zooms" }, one("Zoom in", icon("add"), () => this.zoom(0.6)), one("Zoom out", "−", () => this.zoom(1 / 0.6)), one("Whole field", icon("my_location", "m"), () => this.fit()));
    }
  }

  HL.SvgView = SvgView;
})();
