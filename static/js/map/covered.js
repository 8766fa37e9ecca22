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
    this.known = this.#nodes().map((node) => node.getBoundingClientRect()).filter((box) => box.width)
      .map((box) => [box.left - place.left, box.top - place.top, box.right - place.left, box.bottom - place.top].map(Math.round));
    return this.known;
  }

  /** By way of children: asking for selectors looks at every robot in the list that is read aloud. */
  #nodes() {
    this.controls ??= this.host.querySelector('.hl-map-buttons')?.parentElement;
    const own = [...(this.controls?.children ?? [])].flatMap((node) => (node.matches('.hl-map-buttons') ? [...node.children] : node.matches('.hl-map-foot') ? [node] : []));
    const beside = [...(this.host.parentElement?.children ?? [])].flatMap((node) => (node.matches('.h-card') ? [node] : node.matches('.f-over') ? [...node.children] : []));
    return [...own, ...beside];
  }
}
