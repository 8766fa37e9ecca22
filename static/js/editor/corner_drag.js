// One corner on its way: snapped, told beside the finger, one change when it is let go.

import { ownGuides, snapped, SNAP_PX } from './snap.js';
import { lengthM } from '../map/plane.js';
import { cornerAt, cornerName, inserted, isArea, laid, moved, partsOf, rebuilt } from './shape.js';
import { movedText } from './words.js';

/**
 * core: {draft, surface, isSnapping, show(id, live feature or null), tell(drag or null), choose(address), commit(label, changes)}.
 * `mid` is given when the corner is a new one, pulled out of an edge.
 */
export class CornerDrag {
  constructor(core, id, address, at, { isTouch, mid = null }) {
    this.core = core;
    this.id = id;
    this.isTouch = isTouch;
    this.before = core.draft.get(id);
    this.isNew = Boolean(mid);
    this.base = mid ? laid(this.before, inserted(this.before, address, mid)) : this.before;
    this.address = mid ? { ...address, index: address.index + 1 } : address;
    this.from = cornerAt(this.base, this.address);
    const [x, y] = core.surface.toPx(this.from);
    this.grip = [x - at[0], y - at[1]]; // the corner keeps its distance from the finger
    this.name = cornerName(this.base, this.address);
    const ring = partsOf(this.base)[this.address.part][this.address.ring];
    this.guides = this.isNew ? [] : ownGuides(ring, this.address.index, isArea(this.base));
    core.choose(this.address, this.isNew);
  }

  move(at) {
    const { core } = this;
    const { surface } = core;
    const wanted = surface.toLonLat([at[0] + this.grip[0], at[1] + this.grip[1]]);
    const reachM = SNAP_PX * surface.camera.metresPerPx;
    const found = core.isSnapping
      ? snapped(wanted, { draft: core.draft, skip: new Set([this.id]), guides: this.guides, reachM, from: this.from })
      : { position: wanted, text: '', lines: [] };
    this.parts = moved(this.base, this.address, found.position);
    this.live = laid(this.base, this.parts);
    this.position = cornerAt(this.live, this.address);
    const way = lengthM(this.from, this.position);
    const tip = [this.isNew ? `${this.name}, new` : `${this.name}, moved ${movedText(way)}`];
    if (found.text) tip.push(`snapped ${found.text}`);
    core.show(this.id, this.live);
    core.tell({ from: this.isNew ? null : this.from, at: this.position, guides: found.lines, tip, finger: this.isTouch ? at : null });
  }

  finish() {
    const { core } = this;
    const way = lengthM(this.from, this.position);
    core.tell(null);
    if (!this.isNew && way === 0) {
      core.show(this.id, null);
      return;
    }
    const after = rebuilt(this.base, this.parts);
    const label = this.isNew ? `${this.name} added` : `${this.name} moved ${movedText(way)}`;
    core.commit(label, [{ id: this.id, before: this.before, after }], { ...this.address, position: this.position });
  }

  /** A tap on a corner chooses it; on a mid-handle it adds a corner there. */
  tap() {
    if (!this.isNew) return;
    const after = rebuilt(this.base, partsOf(this.base));
    this.core.commit(`${this.name} added`, [{ id: this.id, before: this.before, after }], { ...this.address, position: this.from });
  }

  cancel() {
    this.core.tell(null);
    this.core.show(this.id, null);
    if (this.isNew) this.core.choose(null);
  }
}
