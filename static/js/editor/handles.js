// Where the corners and mid-handles of the selected feature are on the screen, and which one a finger means.
// Not terra-draw (1.35): it refuses polygons with holes, multi-part shapes and ids of the map.

import { edgesOf, isArea, partsOf } from './shape.js';

export const LOOK_PX = 24;
export const REACH_PX = 24; // 48 across
const SMALL_PX = 12;
const TIGHT_PX = 44; // corners closer than this get small handles
const SINGLE_MID_PX = 60;
const DOUBLE_MID_PX = 190; // room for the length between two mid-handles
const LABEL_PX = 120;
const MOST_CORNERS = 3000; // beyond, only corners in view and never mid-handles

/**
 * toPx projects [lon, lat]; returns {corners: [{x, y, part, ring, index, size}], mids: [{x, y, ..., share}],
 * edges: [{ax, ay, bx, by, a, b, isLabelled}]}, all in px.
 */
export function handlesOf(feature, toPx, view) {
  const found = { corners: [], mids: [], edges: [] };
  const isClosed = isArea(feature);
  partsOf(feature).forEach((rings, part) => rings.forEach((ring, ringNumber) => {
    const places = ring.map(toPx);
    const isCrowded = ring.length > MOST_CORNERS;
    const reach = places.map(() => Infinity);
    for (const [a, b, i] of edgesOf(places, isClosed)) {
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      const next = (i + 1) % places.length;
      reach[i] = Math.min(reach[i], length);
      reach[next] = Math.min(reach[next], length);
      if (isCrowded || !touches(a, b, view)) continue;
      const isLabelled = length >= DOUBLE_MID_PX || (length >= LABEL_PX && ringNumber === 0);
      found.edges.push({ ax: a[0], ay: a[1], bx: b[0], by: b[1], a: ring[i], b: ring[next], part, ring: ringNumber, index: i, isLabelled, hasRoom: length >= DOUBLE_MID_PX });
      const shares = length >= DOUBLE_MID_PX ? [0.25, 0.75] : length >= SINGLE_MID_PX ? [0.5] : [];
      for (const share of shares) {
        const place = { x: a[0] + (b[0] - a[0]) * share, y: a[1] + (b[1] - a[1]) * share };
        found.mids.push({ ...place, part, ring: ringNumber, index: i, share });
      }
    }
    places.forEach(([x, y], index) => {
      if (!isInView(x, y, view)) return;
      found.corners.push({ x, y, part, ring: ringNumber, index, size: reach[index] < TIGHT_PX ? SMALL_PX : LOOK_PX });
    });
  }));
  return found;
}

const isInView = (x, y, { width, height }) => x > -40 && y > -40 && x < width + 40 && y < height + 40;
const touches = (a, b, { width, height }) => Math.max(a[0], b[0]) > -40 && Math.min(a[0], b[0]) < width + 40
  && Math.max(a[1], b[1]) > -40 && Math.min(a[1], b[1]) < height + 40;

/** The corner under a finger, else the mid-handle, else null. */
export function handleAt({ corners, mids }, [x, y]) {
  const nearest = (handles) => {
    let best = null;
    let off = REACH_PX;
    for (const handle of handles) {
      const far = Math.hypot(handle.x - x, handle.y - y);
      if (far <= off) [best, off] = [handle, far];
    }
    return [best, off];
  };
  const [corner, cornerOff] = nearest(corners);
  const [mid, midOff] = nearest(mids);
  if (corner && (!mid || cornerOff <= midOff + REACH_PX / 3)) return { kind: 'corner', handle: corner };
  return mid ? { kind: 'mid', handle: mid } : null;
}

export const isSame = (a, b) => Boolean(a && b) && a.part === b.part && a.ring === b.ring && a.index === b.index;
