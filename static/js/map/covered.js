// What lies over the map: its own buttons and what the screen puts there. No name may run beneath it.

const EVERY_MS = 1000; // looking costs a layout

export class Covered {
  constructor(host) {
    this.host = host;
    this.lookedAt = -Infinity;
    this.known = [];
  }

  /** Boxes in pixels of the map: [left, top, right, bottom], at most a second old. */
  boxes() {
    const now = performance.now();
    if (now - this.lookedAt < EVERY_MS) return this.known;
    this.lookedAt = now;
    const place = this.host.getBoundingClientRect();
    const over = this.host.parentElement?.querySelectorAll(':scope > .h-card, :scope > .f-over > *') ?? [];
    const nodes = [...this.host.querySelectorAll('.hl-map-buttons > *, .hl-map-foot'), ...over];
    this.known = nodes.map((node) => node.getBoundingClientRect()).filter((box) => box.width)
      .map((box) => [box.left - place.left, box.top - place.top, box.right - place.left, box.bottom - place.top].map(Math.round));
    return this.known;
  }
}
