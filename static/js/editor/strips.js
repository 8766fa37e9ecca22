// Row directions of the parcels that are not in hand, see map/row_strips.js.

import { Strips as RowStrips, degreesOf } from '../map/row_strips.js';
import { idOf } from './draft.js';

const REST_MS = 180; // after the last movement

export class Strips {
  #rows = new RowStrips();

  /** inHand(): ids that the bed draws. */
  constructor(surface, draft, inHand) {
    Object.assign(this, { surface, draft, inHand });
    this.shown = '';
  }

  later() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.lay(), REST_MS);
  }

  lay() {
    clearTimeout(this.timer);
    if (!this.surface.isEditable) return;
    const { camera } = this.surface;
    const skip = new Set(this.inHand());
    const { lines, key } = this.#rows.of([...this.draft.within(degreesOf(camera))].filter((feature) => !skip.has(idOf(feature))), camera);
    if (key === this.shown && this.last === this.draft.revision) return;
    [this.shown, this.last] = [key, this.draft.revision];
    this.surface.showStrips(lines);
  }

  destroy() {
    clearTimeout(this.timer);
  }
}
