// Small steps by keys: what is held down moves on the screen at once and becomes one change when it is let go.

import { pushed } from './body_drag.js';
import { STEP_DEG, bearingOf, turnText, withBearing } from './dial.js';
import { shifted } from '../map/plane.js';
import { cornerAt, cornerName, laid, moved, rebuilt } from './shape.js';
import { movedText } from './words.js';

/** A corner by metres east and north. */
class CornerNudge {
  constructor(core, id, address) {
    Object.assign(this, { core, id, address, east: 0, north: 0 });
    this.before = core.draft.get(id);
    this.from = cornerAt(this.before, address);
  }

  push(east, north) {
    this.east += east;
    this.north += north;
    this.parts = moved(this.before, this.address, shifted(this.from, this.east, this.north));
    const live = laid(this.before, this.parts);
    this.position = cornerAt(live, this.address);
    this.core.show(this.id, live);
  }

  finish() {
    const label = `${cornerName(this.before, this.address)} moved ${movedText(Math.hypot(this.east, this.north))}`;
    const changes = [{ id: this.id, before: this.before, after: rebuilt(this.before, this.parts) }];
    this.core.commit(label, changes, { ...this.address, position: this.position });
  }
}

/** Whole shapes by metres east and north. */
class BodyNudge {
  constructor(core, ids) {
    Object.assign(this, { core, east: 0, north: 0 });
    this.before = ids.map((id) => [id, core.draft.get(id)]);
  }

  push(east, north) {
    this.east += east;
    this.north += north;
    this.after = this.before.map(([, feature]) => pushed(feature, this.east, this.north));
    this.before.forEach(([id], i) => this.core.show(id, this.after[i]));
  }

  finish() {
    const changes = this.before.map(([id, before], i) => ({ id, before, after: this.after[i] }));
    this.core.commit(`${this.core.titleOf(changes)} moved ${movedText(Math.hypot(this.east, this.north))}`, changes);
  }
}

/** The row direction by half degrees: right and up turn clockwise. */
class DialNudge {
  constructor(core, id) {
    Object.assign(this, { core, id, turned: 0 });
    this.before = core.draft.get(id);
  }

  push(right, up) {
    this.turned += (Math.sign(right) || Math.sign(up)) * STEP_DEG * (Math.hypot(right, up) > 0.5 ? 10 : 1); // Shift: 5 degrees
    this.live = withBearing(this.before, bearingOf(this.before).bearing + this.turned);
    this.core.show(this.id, this.live);
  }

  finish() {
    this.core.commit(turnText(this.before, this.live), [{ id: this.id, before: this.before, after: this.live }]);
  }
}

/** What arrow keys move: the row direction or corner in hand, or whole shapes while they are unlocked; null: nothing. */
export function nudgeOf(bench, isBodyFree) {
  const { corner, only, ids, isDial } = bench.selection;
  if (only && isDial) return new DialNudge(bench, ids[0]);
  if (only && (corner || only.geometry.type === 'Point')) return new CornerNudge(bench, ids[0], corner ?? { part: 0, ring: 0, index: 0 });
  if (ids.length && isBodyFree) return new BodyNudge(bench, ids);
  if (ids.length) bench.notice('Choose a corner to move it. The whole shape is locked.');
  return null;
}
