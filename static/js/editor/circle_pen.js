// Drawing a round obstacle: its middle, then how far it reaches, by a second tap, by dragging, or by a number typed.

import { lengthM, shifted } from '../map/plane.js';
import { Pen } from './pen.js';
import { lengthText } from './words.js';

const LEAST_M = 0.05;
const MOST_M = 1000;

/** Metres as they are kept: whole centimetres, never nothing. */
export const radiusOf = (centre, edge) => Math.min(MOST_M, Math.max(LEAST_M, Math.round(lengthM(centre, edge) * 100) / 100));

export class CirclePen extends Pen {
  get centre() {
    return this.points[0] ?? null;
  }

  hover(at, options = {}) {
    if (!this.centre) {
      super.hover(at, options);
      return;
    }
    const position = this.core.surface.toLonLat(at);
    const radius = radiusOf(this.centre, position);
    this.next = { position, lines: [], text: '', tip: [`Radius ${lengthText(radius)}`], finger: options.isTouch ? at : null };
    this.core.measured(`Radius ${lengthText(radius)}`);
    this.core.repaint();
  }

  place(at, time) {
    if (this.centre) this.reach(this.core.surface.toLonLat(at));
    else {
      super.place(at, time);
      this.core.measured('');
    }
  }

  /** The circle is as wide as from its middle to `edge`; done. */
  reach(edge) {
    const { centre } = this;
    this.clear();
    this.core.drawn(this.tool, [centre, edge]);
  }

  /** The circle has this radius in metres; false while it has no middle. */
  setRadius(metres) {
    if (!this.centre) return false;
    this.reach(shifted(this.centre, metres, 0));
    return true;
  }

  finish() {
    if (this.points.length) this.core.notice('Drag, tap or type how far it reaches.');
  }
}

/** A finger or the mouse on the map: down is the middle, up is the edge; a tap sets one of them. */
export class CirclePress {
  constructor(pen, at, event) {
    this.pen = pen;
    this.isTouch = event.pointerType === 'touch';
    this.isFirst = !pen.centre;
    if (this.isFirst) pen.place(at, event.timeStamp);
  }

  move(at) {
    this.at = at;
    this.pen.hover(at, { isTouch: this.isTouch });
  }

  finish() {
    this.pen.place(this.at, -Infinity);
  }

  tap(at, event) {
    if (!this.isFirst) this.pen.place(at, event.timeStamp);
  }

  cancel() {
    if (this.isFirst) this.pen.clear();
    else this.pen.lift();
  }
}
