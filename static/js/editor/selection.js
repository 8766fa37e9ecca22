// Which features are in hand, and which corner or dial of a single one.

import { cornerAt, findCorner } from './shape.js';

const SAME_PLACE_PX = 16;
const DOUBLE_TAP_MS = 350; // a double tap zooms, it does not change what is selected

export class Selection {
  constructor(draft) {
    this.draft = draft;
    this.isSeveral = false; // or true, or which features a tap may add
    this.set([]);
  }

  set(ids) {
    this.ids = [...new Set(ids)].filter((id) => this.draft.get(id));
    this.corner = null;
    this.isDial = false;
    this.last = null;
  }

  /** The only selected feature, or null. */
  get only() {
    return this.ids.length === 1 ? this.draft.get(this.ids[0]) : null;
  }

  /** Let go of what the draft no longer has. */
  prune() {
    const left = this.ids.filter((id) => this.draft.get(id));
    if (left.length !== this.ids.length) this.set(left);
    if (this.corner && !(this.only && cornerAt(this.only, this.corner))) this.corner = null;
  }

  /** After a change: hold the corner at its new address. `corner`: {part, ring, index, position} or null. */
  follow(corner) {
    if (!corner || !this.only) this.corner = null;
    else if (corner.position) this.corner = findCorner(this.only, corner, corner.position);
  }

  /** A tap on features, smallest first: take the first, and with a second tap at the same place the next. */
  tap(found, at, { shiftKey, timeStamp }) {
    if (this.isSeveral || shiftKey) {
      const { isSeveral } = this;
      const [id] = typeof isSeveral === 'function' ? found.filter((one) => this.ids.includes(one) || isSeveral(this.draft.get(one))) : found;
      if (id) this.set(this.ids.includes(id) ? this.ids.filter((other) => other !== id) : [...this.ids, id]);
      return;
    }
    const { last } = this;
    const isAgain = last && Math.hypot(at[0] - last.at[0], at[1] - last.at[1]) <= SAME_PLACE_PX;
    const isDouble = isAgain && timeStamp - last.timeStamp < DOUBLE_TAP_MS;
    const held = found.indexOf(this.ids[0]);
    if (!isDouble) this.set(isAgain && held >= 0 ? [found[(held + 1) % found.length]] : found.slice(0, 1));
    this.last = { at, timeStamp };
  }
}
