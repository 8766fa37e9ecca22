// Whole shapes on their way. Locked unless asked for: a field must not move because a finger slipped.

import { Plane, lengthM } from '../map/plane.js';
import { carried, laid, rebuilt } from './shape.js';
import { movedText } from './words.js';

/** Features so many metres away. */
export function pushed(feature, east, north) {
  return rebuilt(feature, shiftedParts(feature, east, north));
}

function shiftedParts(feature, east, north) {
  return carried(feature, (position) => new Plane(position).toLonLat([east, north]));
}

export class BodyDrag {
  constructor(core, ids, at, { isTouch }) {
    this.core = core;
    this.before = ids.map((id) => [id, core.draft.get(id)]);
    this.from = core.surface.toLonLat(at);
    this.isTouch = isTouch;
  }

  move(at) {
    const { core } = this;
    const here = core.surface.toLonLat(at);
    this.way = new Plane(this.from).toM(here);
    for (const [id, feature] of this.before) core.show(id, laid(feature, shiftedParts(feature, ...this.way)));
    core.tell({ from: null, at: here, guides: [], tip: [`Moved ${movedText(lengthM(this.from, here))}`], finger: this.isTouch ? at : null });
  }

  finish() {
    const { core } = this;
    core.tell(null);
    const changes = this.before.map(([id, before]) => ({ id, before, after: pushed(before, ...this.way) }));
    core.commit(`${core.titleOf(changes)} moved ${movedText(Math.hypot(...this.way))}`, changes);
  }

  /** Nothing was dragged: the tap means what it would have meant without a lock taken off. */
  tap(at, event) {
    this.core.tap(at, event);
  }

  cancel() {
    this.core.tell(null);
    for (const [id] of this.before) this.core.show(id, null);
  }
}
