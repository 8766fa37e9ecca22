// Rows of a parcel as thin lines inside its headland: a picture of the row direction, not the planner's rows.

import { DEG, polygonParts } from './geometry.js';
import { Plane } from './plane.js';

const MOST_LINES = 400;
const MOST_CORNERS = 600;
const LEAST_M = 0.5; // shorter pieces are noise

/** {lines: [[lon, lat], [lon, lat]][], spacingM} for a parcel; `leastM` is how close two lines may stand. */
export function hatch(feature, { bearing, headlandM, rowM, leastM }) {
  const rings = polygonParts(feature.geometry).flat();
  const corners = rings.flat();
  if (corners.length < 3 || corners.length > MOST_CORNERS) return { lines: [], spacingM: 0 };
  const plane = new Plane(corners[0]);
  const [sin, cos] = [Math.sin(bearing * DEG), Math.cos(bearing * DEG)];
  const turned = (position) => {
    const [east, north] = plane.toM(position);
    return [east * cos - north * sin, east * sin + north * cos]; // across and along the rows
  };
  const back = ([u, v]) => plane.toLonLat([u * cos + v * sin, v * cos - u * sin]);
  const edges = rings.flatMap((ring) => {
    const places = ring.map(turned);
    return places.map((place, i) => [place, places[(i + 1) % places.length]]);
  });
  const across = edges.map(([a]) => a[0]);
  const [low, high] = [Math.min(...across), Math.max(...across)];
  let spacingM = rowM;
  while (spacingM < leastM || (high - low) / spacingM > MOST_LINES) spacingM *= 2;
  const lines = [];
  const first = Math.ceil(low / spacingM - 0.5);
  for (let u = (first + 0.5) * spacingM; u < high; u += spacingM) {
    for (const [from, to] of rowsAt(u, edges, headlandM)) {
      if (to - from > LEAST_M) lines.push([back([u, from]), back([u, to])]);
    }
  }
  return { lines, spacingM };
}

/** Stretches of the line across = u that lie inside and at least `headlandM` from every edge. */
function rowsAt(u, edges, headlandM) {
  const crossings = [];
  const bands = [];
  for (const [a, b] of edges) {
    if (a[0] > u !== b[0] > u) crossings.push(a[1] + ((u - a[0]) / (b[0] - a[0])) * (b[1] - a[1]));
    if (headlandM > 0 && Math.min(a[0], b[0]) - headlandM < u && Math.max(a[0], b[0]) + headlandM > u) bands.push(bandAt(u, a, b, headlandM));
  }
  crossings.sort((p, q) => p - q);
  let free = [];
  for (let i = 0; i + 1 < crossings.length; i += 2) free.push([crossings[i], crossings[i + 1]]);
  for (const [from, to] of bands) {
    free = free.flatMap(([start, end]) => [[start, Math.min(end, from)], [Math.max(start, to), end]]).filter(([start, end]) => end > start);
  }
  return free;
}

/** Stretch of the line within `reach` of an edge: the edge with round ends is convex, so it is one piece. */
function bandAt(u, a, b, reach) {
  const found = [];
  for (const [x, y] of [a, b]) {
    const half = reach ** 2 - (u - x) ** 2;
    if (half > 0) found.push(y - Math.sqrt(half), y + Math.sqrt(half));
  }
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
  const [nx, ny] = [((a[1] - b[1]) / length) * reach, ((b[0] - a[0]) / length) * reach];
  for (const sign of [1, -1]) {
    const [ax, bx] = [a[0] + sign * nx, b[0] + sign * nx];
    if (ax > u !== bx > u) found.push(a[1] + sign * ny + ((u - ax) / (bx - ax)) * (b[1] - a[1]));
  }
  return [Math.min(...found), Math.max(...found)];
}
