// The features of the draft by id; a feature is never changed, only replaced.

import { areaM2 } from '../map/geometry.js';
import { lengthM } from '../map/plane.js';
import { edgesOf, isArea, partsOf } from './shape.js';

export const idOf = (feature) => feature.id ?? feature.properties?.id;

export class Draft {
  constructor() {
    this.byId = new Map();
    this.boxes = new Map();
    this.revision = 0;
  }

  set(features) {
    this.revision += 1;
    this.byId.clear();
    this.boxes.clear();
    for (const feature of features) this.#put(idOf(feature), feature);
  }

  /** Apply [{id, after}]; `after` null removes. */
  apply(changes) {
    this.revision += 1;
    for (const { id, after } of changes) {
      if (after) this.#put(id, after);
      else {
        this.byId.delete(id);
        this.boxes.delete(id);
      }
    }
  }

  #put(id, feature) {
    this.byId.set(id, feature);
    let box = null;
    for (const [lon, lat] of partsOf(feature).flat(2)) {
      if (!box) box = [lon, lat, lon, lat];
      else box = [Math.min(box[0], lon), Math.min(box[1], lat), Math.max(box[2], lon), Math.max(box[3], lat)];
    }
    this.boxes.set(id, box);
  }

  get(id) {
    return this.byId.get(id) ?? null;
  }

  get features() {
    return [...this.byId.values()];
  }

  /** Features whose box touches the box [west, south, east, north]. */
  * within([west, south, east, north]) {
    for (const [id, box] of this.boxes) {
      if (box && box[0] <= east && box[2] >= west && box[1] <= north && box[3] >= south) yield this.byId.get(id);
    }
  }

  /** Ids under a finger, smallest first; `reachM` is how far beside a line or point still counts. */
  under(position, reachM) {
    const found = [];
    for (const feature of this.within(boxAround(position, reachM))) {
      const size = sizeUnder(feature, position, reachM);
      if (size !== null) found.push([size, idOf(feature)]);
    }
    return found.sort((a, b) => a[0] - b[0]).map(([, id]) => id);
  }
}

const METRES_PER_DEGREE = 111_000; // a little short: the box must not come out too small

/** [west, south, east, north] around a position. */
export function boxAround([lon, lat], metres) {
  const high = metres / METRES_PER_DEGREE;
  const wide = high / Math.max(Math.cos((lat * Math.PI) / 180), 0.01);
  return [lon - wide, lat - high, lon + wide, lat + high];
}

/** m2 of what is hit, lines and points below any area; null when it is not under the finger. */
function sizeUnder(feature, position, reachM) {
  if (isArea(feature)) {
    const rings = partsOf(feature).find((part) => contains(part, position));
    return rings ? areaM2(rings) : null;
  }
  const { width_m: widthM = 0, radius_m: radiusM = 0 } = feature.properties ?? {};
  const far = Math.max(reachM, widthM / 2, radiusM);
  const lines = partsOf(feature).flat();
  const off = Math.min(...lines.map((line) => offM(line, position)));
  if (off > far) return null;
  return (lines[0].length > 1 ? -1 : -2) + off / (far + 1);
}

/** Whether a position lies in rings: in the outer one and in no hole. */
export function contains(rings, position) {
  return rings.length > 0 && isIn(rings[0], position) && !rings.slice(1).some((hole) => isIn(hole, position));
}

function isIn(ring, [x, y]) {
  let isInside = false;
  for (const [[ax, ay], [bx, by]] of edgesOf(ring, true)) {
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) isInside = !isInside;
  }
  return isInside;
}

function offM(line, position) {
  if (line.length === 1) return lengthM(line[0], position);
  let least = Infinity;
  for (const [a, b] of edgesOf(line, false)) least = Math.min(least, lengthM(nearestOnEdge(a, b, position), position));
  return least;
}

/** The position of an edge that is nearest to another position. */
export function nearestOnEdge(a, b, [x, y]) {
  const squeeze = Math.cos((y * Math.PI) / 180) ** 2; // a degree of longitude is shorter
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const length = dx * dx * squeeze + dy * dy;
  const t = length ? Math.min(1, Math.max(0, ((x - a[0]) * dx * squeeze + (y - a[1]) * dy) / length)) : 0;
  return [a[0] + t * dx, a[1] + t * dy];
}
