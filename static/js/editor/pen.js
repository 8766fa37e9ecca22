// Drawing: the corners set so far, the one under the finger, and how a shape is finished.

import { penGuides, snapped, SNAP_PX } from './snap.js';
import { REACH_PX } from './handles.js';
import { measureText, pathM, lengthText } from './words.js';

/** What each tool draws. Tools without a kind ask the server for an operation, or only measure. */
export const PENS = {
  parcel: { shape: 'area', kind: 'parcel', word: 'parcel' },
  obstacle: { shape: 'area', kind: 'obstacle', word: 'obstacle' },
  building: { shape: 'area', kind: 'building', word: 'building' },
  circle: { shape: 'circle', kind: 'obstacle', word: 'obstacle' },
  'no-go': { shape: 'area', kind: 'no-go', word: 'keep-out zone' },
  slow: { shape: 'area', kind: 'slow', word: 'slow zone', own: { speed_mps: 0.5 } },
  water: { shape: 'area', kind: 'water', word: 'pond' },
  hole: { shape: 'area', word: 'hole' },
  road: { shape: 'line', kind: 'road', word: 'road', own: { width_m: 4 } },
  hedge: { shape: 'line', kind: 'hedge', word: 'hedge', own: { width_m: 3 } },
  yard: { shape: 'area', kind: 'road', word: 'yard' },
  rows: { shape: 'line', kind: 'rows', word: 'row line', most: 2 },
  curve: { shape: 'line', kind: 'rows', word: 'guide line', own: { type: 'curve' } },
  recorded: { shape: 'line', kind: 'rows', word: 'crop row', own: { type: 'recorded' } },
  split: { shape: 'line', word: 'cut' },
  measure: { shape: 'line', word: 'measure' },
  home: { shape: 'point', kind: 'home', word: 'home', own: { type: 'home' } },
  garage: { shape: 'point', kind: 'home', word: 'garage', own: { type: 'garage' } },
  charging: { shape: 'point', kind: 'home', word: 'charging place', own: { type: 'charging' } },
  gate: { shape: 'point', kind: 'gate', word: 'gate', own: { width_m: 4 } },
};

const LEAST = { area: 3, line: 2, point: 1, circle: 2 };
const DOUBLE_TAP_MS = 350;

export class Pen {
  /** core: {draft, surface, isSnapping, repaint(), notice(text), measured(text), drawn(tool, points)}. */
  constructor(core, tool) {
    this.core = core;
    this.tool = tool;
    Object.assign(this, { shape: PENS[tool].shape, word: PENS[tool].word });
    this.clear();
  }

  clear() {
    this.points = [];
    this.finished = null; // a measure stays to be read until the next one begins
    this.lastTap = null;
    this.lift();
  }

  get isDrawing() {
    return this.points.length > 0;
  }

  /** Whether what is drawn could be finished as it is. */
  get isEnough() {
    return this.points.length >= LEAST[this.shape];
  }

  /** Show where a tap would set the next corner. */
  hover(at, { isTouch = false } = {}) {
    const found = this.#aim(at);
    const tip = this.#tipOf(found);
    this.next = { ...found, tip, finger: isTouch ? at : null };
    if (this.isDrawing) this.core.measured(this.#textOf([...this.points, found.position]));
    this.core.repaint();
  }

  #tipOf(found) {
    if (found.isClosing) return [this.tool === 'measure' ? 'Tap to measure the area' : 'Tap to close'];
    if (!found.text) return [];
    return this.points.length ? [lengthText(pathM([this.points.at(-1), found.position])), `snapped ${found.text}`] : [`snapped ${found.text}`];
  }

  lift() {
    this.next = null;
    this.core.repaint();
  }

  #aim(at) {
    const { surface, draft, isSnapping } = this.core;
    if (this.#isOnFirst(at)) return { position: this.points[0], text: '', lines: [], isClosing: true };
    const position = surface.toLonLat(at);
    if (!isSnapping) return { position, text: '', lines: [] };
    return snapped(position, { draft, skip: new Set(), guides: penGuides(this.points), reachM: SNAP_PX * surface.camera.metresPerPx });
  }

  #isOnFirst(at) {
    const canClose = this.shape === 'area' || this.tool === 'measure';
    return canClose && this.points.length >= 3 && this.#isNear(at, this.points[0]);
  }

  #isNear(at, position) {
    const [x, y] = this.core.surface.toPx(position);
    return Math.hypot(x - at[0], y - at[1]) <= REACH_PX;
  }

  /** Set a corner; the first corner again, or a double tap, finishes. */
  place(at, time) {
    const { lastTap } = this;
    this.lastTap = { at, time };
    const isDouble = lastTap && time - lastTap.time < DOUBLE_TAP_MS && Math.hypot(at[0] - lastTap.at[0], at[1] - lastTap.at[1]) < REACH_PX;
    if (isDouble && this.isEnough) {
      this.finish();
      return;
    }
    const found = this.#aim(at);
    if (found.isClosing) {
      this.finish({ isClosed: true });
      return;
    }
    this.finished = null;
    if (!isDouble) this.points = [...this.points, found.position];
    this.lift();
    this.core.measured(this.#textOf(this.points));
    if (this.shape === 'point' || this.points.length === PENS[this.tool].most) this.finish();
  }

  #textOf(points) {
    return points.length > 1 ? measureText(points, this.shape === 'area') : '';
  }

  /** Take the last corner back; false when there is none. */
  undo() {
    if (!this.isDrawing) return false;
    this.points = this.points.slice(0, -1);
    this.lastTap = null;
    this.lift();
    this.core.measured(this.#textOf(this.points));
    return true;
  }

  /** Give the shape away and be ready for the next one. */
  finish({ isClosed = false } = {}) {
    const { points, shape, word } = this;
    if (!this.isEnough) {
      const more = { area: 'three corners', line: 'two points' }[shape];
      if (points.length) this.core.notice(`A ${word} needs ${more}.`);
      return;
    }
    this.clear();
    if (this.tool === 'measure') {
      this.finished = { points, isClosed };
      this.core.measured(isClosed ? measureText([...points, points[0]], true) : measureText(points, false));
    } else this.core.drawn(this.tool, points);
  }
}

/** A finger on the map while drawing: the corner follows it under the glass and is set when it is lifted. */
export class PenPress {
  constructor(pen) {
    this.pen = pen;
  }

  move(at) {
    this.at = at;
    this.pen.hover(at, { isTouch: true });
  }

  finish() {
    this.pen.place(this.at, -Infinity);
  }

  tap(at, event) {
    this.pen.place(at, event.timeStamp);
  }

  cancel() {
    this.pen.lift();
  }
}
