// Row directions of the parcels that are not in hand: thin lines, for what is in view and large enough to show them.
// Lines are kept by feature and spacing, so that a map of a thousand parcels costs only what came into view.

import { idOf } from './draft.js';
import { hatch } from './hatch.js';
import { isArea } from './shape.js';

const REST_MS = 180; // after the last movement
const LEAST_PX = 9; // between two lines
const LEAST_SIDE_PX = 48; // smaller parcels show no lines
const USUAL_ROW_M = 0.5;
const MOST_LINES = 5000;

export class Strips {
  /** inHand(): ids that the bed draws. */
  constructor(surface, draft, inHand) {
    Object.assign(this, { surface, draft, inHand });
    this.kept = new WeakMap();
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
    const lines = [];
    const key = [];
    for (const feature of this.draft.within(viewOf(camera, this.surface))) {
      if (skip.has(idOf(feature)) || !hasRows(feature) || !this.#isLarge(feature, camera)) continue;
      const found = this.#linesOf(feature, camera.metresPerPx);
      if (lines.length + found.length > MOST_LINES) break;
      lines.push(...found);
      key.push(`${idOf(feature)}:${found.length}:${feature.properties.row_bearing_deg}`);
    }
    const shown = key.join();
    if (shown === this.shown && this.last === this.draft.revision) return;
    [this.shown, this.last] = [shown, this.draft.revision];
    this.surface.showStrips(lines);
  }

  #isLarge(feature, camera) {
    const [west, south, east, north] = this.draft.boxes.get(idOf(feature));
    const [a, b] = [this.surface.toPx([west, south]), this.surface.toPx([east, north])];
    return Math.hypot(b[0] - a[0], b[1] - a[1]) >= LEAST_SIDE_PX * Math.SQRT2 && camera.metresPerPx < 20;
  }

  #linesOf(feature, metresPerPx) {
    const { row_spacing_m: rowM, row_bearing_deg: bearing, headland_m: headlandM } = feature.properties;
    let spacingM = rowM || USUAL_ROW_M;
    while (spacingM < LEAST_PX * metresPerPx) spacingM *= 2;
    const kept = this.kept.get(feature) ?? new Map();
    this.kept.set(feature, kept);
    if (!kept.has(spacingM)) kept.set(spacingM, hatch(feature, { bearing, headlandM: headlandM || 0, rowM: spacingM, leastM: 0 }).lines);
    return kept.get(spacingM);
  }

  destroy() {
    clearTimeout(this.timer);
  }
}

const hasRows = (feature) => feature.properties.kind === 'parcel' && isArea(feature) && Number.isFinite(feature.properties.row_bearing_deg);

/** [west, south, east, north] of what is in view, also of a turned map. */
function viewOf({ width, height }, surface) {
  const corners = [[0, 0], [width, 0], [0, height], [width, height]].map((at) => surface.toLonLat(at));
  const [lons, lats] = [corners.map((p) => p[0]), corners.map((p) => p[1])];
  return [Math.min(...lons), Math.min(...lats), Math.max(...lons), Math.max(...lats)];
}
