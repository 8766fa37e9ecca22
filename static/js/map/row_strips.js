// Row directions of parcels as thin lines: a picture of how a field is worked, coarser the farther one looks from.
// Lines are kept by feature and spacing, so that a map of a thousand parcels costs only what came into view.

import { boxOf, latOf, lonOf, viewBox } from './geometry.js';
import { hatch } from './hatch.js';

const LEAST_PX = 9; // between two lines
const LEAST_SIDE_PX = 48; // smaller parcels show no lines
const FARTHEST_M = 20; // metres per px beyond which nobody sees them
const USUAL_ROW_M = 0.5;
const MOST_LINES = 5000;

export class Strips {
  #kept = new WeakMap();
  #boxes = new WeakMap();

  /** {lines: [[lon, lat], [lon, lat]][], key} of what `camera` sees of `features`; the same `key`: the same lines. */
  of(features, camera) {
    const lines = [];
    const key = [];
    const { metresPerPx } = camera;
    if (!(metresPerPx < FARTHEST_M)) return { lines, key: '' };
    const view = viewBox(camera);
    for (const feature of features) {
      if (!hasRows(feature) || !this.#isSeen(feature, view, camera)) continue;
      const found = this.#linesOf(feature, metresPerPx);
      if (lines.length + found.length > MOST_LINES) break;
      lines.push(...found);
      key.push(`${feature.id ?? feature.properties.id}:${found.length}:${feature.properties.row_bearing_deg}`);
    }
    return { lines, key: key.join() };
  }

  #isSeen(feature, [left, top, right, bottom], camera) {
    if (!this.#boxes.has(feature)) this.#boxes.set(feature, boxOf([feature]));
    const [x0, y0, x1, y1] = this.#boxes.get(feature);
    if (x0 > right || x1 < left || y0 > bottom || y1 < top) return false;
    return Math.hypot(x1 - x0, y1 - y0) * camera.worldPx >= LEAST_SIDE_PX * Math.SQRT2;
  }

  #linesOf(feature, metresPerPx) {
    const { row_spacing_m: rowM, row_bearing_deg: bearing, headland_m: headlandM } = feature.properties;
    let spacingM = rowM || USUAL_ROW_M;
    while (spacingM < LEAST_PX * metresPerPx) spacingM *= 2;
    const kept = this.#kept.get(feature) ?? new Map();
    this.#kept.set(feature, kept);
    if (!kept.has(spacingM)) kept.set(spacingM, hatch(feature, { bearing, headlandM: headlandM || 0, rowM: spacingM, leastM: 0 }).lines);
    return kept.get(spacingM);
  }
}

/** What the strips of a live map are drawn from. */
export const rowsOf = (lines) => ({
  type: 'FeatureCollection',
  features: lines.length ? [{ type: 'Feature', properties: { kind: 'rows' }, geometry: { type: 'MultiLineString', coordinates: lines } }] : [],
});

const hasRows = ({ properties, geometry }) =>
  properties?.kind === 'parcel' && Number.isFinite(properties.row_bearing_deg) && (geometry.type === 'Polygon' || geometry.type === 'MultiPolygon');

/** [west, south, east, north] of what is in view, also of a turned map. */
export function degreesOf(camera) {
  const [x0, y0, x1, y1] = viewBox(camera);
  return [lonOf(x0), latOf(y1), lonOf(x1), latOf(y0)];
}
