// The ground of the parcels in hand: lighter than its neighbours, with rows inside the headland.

import { isArea } from './shape.js';
import { hatch } from '../map/hatch.js';
import { rowBearing } from './dial.js';

const LEAST_ROW_PX = 7;
const LEAST_BED_PX = 2; // strips that make up the ground between the headlands: finer than an eye sees steps
const USUAL_ROW_M = 0.5;
const BED_MS = 150; // while a corner is dragged the outline leads, the ground follows
const ZOOM_STEP = 0.6; // rows are thinned out or filled in from here on

export class Bed {
  constructor(surface) {
    this.surface = surface;
    this.shown = [];
  }

  /** Show `features` now, or soon while they change with each movement. */
  show(features, { isHurried = false } = {}) {
    this.wanted = features;
    if (!isHurried) this.#lay();
    else this.later ??= setTimeout(() => this.#lay(), BED_MS);
  }

  /** After a zoom. */
  refresh() {
    if (this.wanted?.length && Math.abs(this.surface.camera.zoom - this.zoom) > ZOOM_STEP) this.show(this.wanted, { isHurried: true });
  }

  #lay() {
    clearTimeout(this.later);
    this.later = null;
    const parcels = this.wanted.filter((feature) => feature.properties.kind === 'parcel' && isArea(feature));
    if (!parcels.length && !this.shown.length) return;
    const { camera } = this.surface;
    this.zoom = camera.zoom;
    this.shown = parcels.map((feature) => ({ feature, rows: rowsOf(feature, camera) }));
    this.surface.showBed(this.shown);
  }

  destroy() {
    clearTimeout(this.later);
  }
}

function rowsOf(feature, camera) {
  const { row_spacing_m: spacingM, headland_m: headlandM } = feature.properties;
  const { bearing, isSet } = rowBearing(feature);
  if (!isSet) return null;
  const how = { bearing, headlandM: headlandM || 0, rowM: spacingM || USUAL_ROW_M };
  const px = camera.metresPerPx;
  return {
    ground: hatch(feature, { ...how, rowM: LEAST_BED_PX * px, leastM: 0 }),
    lines: hatch(feature, { ...how, leastM: LEAST_ROW_PX * px }).lines,
  };
}
