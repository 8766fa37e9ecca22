// Web mercator in [0, 1] x [0, 1] (y down), the camera both engines share, and small line geometry.

const EQUATOR_M = 40075016.685578488;
const TILE_PX = 512; // MapLibre's world is 512 px wide at zoom 0
export const DEG = Math.PI / 180;

export const mercX = (lon) => (lon + 180) / 360;
export const mercY = (lat) => 0.5 - Math.log(Math.tan(Math.PI / 4 + (lat * DEG) / 2)) / (2 * Math.PI);
export const lonOf = (mx) => mx * 360 - 180;
export const latOf = (my) => (2 * Math.atan(Math.exp((0.5 - my) * 2 * Math.PI)) - Math.PI / 2) / DEG;

/** Mercator units per metre on the ground at mercator `my`. */
export const mercPerMetre = (my) => 1 / (EQUATOR_M * Math.cos(latOf(my) * DEG));

/** View of a flat map: centre (mercator), zoom, bearing (degrees clockwise), size in CSS px. */
export class Camera {
  constructor() {
    this.mx = 0.5;
    this.my = 0.5;
    this.zoom = 1;
    this.bearing = 0;
    this.width = 1;
    this.height = 1;
  }

  /** CSS px per mercator unit. */
  get worldPx() {
    return TILE_PX * 2 ** this.zoom;
  }

  get metresPerPx() {
    return 1 / (this.worldPx * mercPerMetre(this.my));
  }

  /** Mercator -> CSS px from the top left corner of the map. */
  project(mx, my) {
    const dx = (mx - this.mx) * this.worldPx;
    const dy = (my - this.my) * this.worldPx;
    const cos = Math.cos(this.bearing * DEG);
    const sin = Math.sin(this.bearing * DEG);
    return [this.width / 2 + dx * cos + dy * sin, this.height / 2 - dx * sin + dy * cos];
  }

  /** CSS px -> mercator. */
  unproject(x, y) {
    const px = x - this.width / 2;
    const py = y - this.height / 2;
    const cos = Math.cos(this.bearing * DEG);
    const sin = Math.sin(this.bearing * DEG);
    return [this.mx + (px * cos - py * sin) / this.worldPx, this.my + (px * sin + py * cos) / this.worldPx];
  }

  /** Zoom at which `box` ([west, south, east, north] in mercator terms x0,y0,x1,y1) fits, with a margin in px. */
  zoomFor(box, margin) {
    return this.#zoomIn(box, 2 * margin, 2 * margin);
  }

  /** {mx, my, zoom} at which `box` lies in the middle of what [top, right, bottom, left] px leave free; `most` is the nearest zoom. */
  viewOf(box, [top, right, bottom, left], most) {
    const zoom = Math.min(this.#zoomIn(box, left + right, top + bottom), most);
    const [px, py] = [(right - left) / 2, (bottom - top) / 2].map((away) => away / (TILE_PX * 2 ** zoom));
    const [cos, sin] = [Math.cos(this.bearing * DEG), Math.sin(this.bearing * DEG)];
    return { mx: (box[0] + box[2]) / 2 + px * cos - py * sin, my: (box[1] + box[3]) / 2 + px * sin + py * cos, zoom };
  }

  #zoomIn([x0, y0, x1, y1], across, down) {
    const width = Math.max(this.width - across, 40);
    const height = Math.max(this.height - down, 40);
    const perUnit = Math.min(width / Math.max(x1 - x0, 1e-12), height / Math.max(y1 - y0, 1e-12));
    return Math.log2(perUnit / TILE_PX);
  }
}

/** Mercator box around what the camera sees. */
export function viewBox(camera) {
  const corners = [[0, 0], [camera.width, 0], [0, camera.height], [camera.width, camera.height]].map(([x, y]) => camera.unproject(x, y));
  const xs = corners.map(([x]) => x);
  const ys = corners.map(([, y]) => y);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

/** Every position of a GeoJSON geometry, depth first. */
export function* positions(geometry) {
  if (!geometry) return;
  if (geometry.type === 'GeometryCollection') {
    for (const part of geometry.geometries) yield* positions(part);
    return;
  }
  const walk = function* (node) {
    if (typeof node[0] === 'number') yield node;
    else for (const child of node) yield* walk(child);
  };
  if (geometry.coordinates?.length) yield* walk(geometry.coordinates);
}

/** Mercator box [x0, y0, x1, y1] of features, or null when they are empty. */
export function boxOf(features) {
  let box = null;
  for (const feature of features) {
    for (const [lon, lat] of positions(feature.geometry)) {
      const x = mercX(lon);
      const y = mercY(lat);
      if (!box) box = [x, y, x, y];
      else box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
    }
  }
  return box;
}

/** Rings of a polygon or multipolygon, as lists of rings per part. */
export function polygonParts(geometry) {
  if (geometry?.type === 'Polygon') return [geometry.coordinates];
  if (geometry?.type === 'MultiPolygon') return geometry.coordinates;
  return [];
}

/** Lines of a (multi)line geometry. */
export function lineParts(geometry) {
  if (geometry?.type === 'LineString') return [geometry.coordinates];
  if (geometry?.type === 'MultiLineString') return geometry.coordinates;
  return [];
}

/** Area in m2 of rings of lon/lat, holes subtracted; flat-earth around the first corner, good for fields. */
export function areaM2(rings) {
  const [lon0, lat0] = rings[0][0];
  const bulge = 1 - 0.00669438 * Math.sin(lat0 * DEG) ** 2; // WGS84 is no sphere: 0.4 % of an area
  const kx = ((EQUATOR_M / 360) * Math.cos(lat0 * DEG)) / Math.sqrt(bulge);
  const ky = ((EQUATOR_M / 360) * (1 - 0.00669438)) / bulge ** 1.5;
  const ring = (points) => {
    let sum = 0;
    for (let i = 0; i < points.length; i += 1) {
      const [ax, ay] = points[i];
      const [bx, by] = points[(i + 1) % points.length];
      sum += (ax - lon0) * kx * (by - lat0) * ky - (bx - lon0) * kx * (ay - lat0) * ky;
    }
    return Math.abs(sum / 2);
  };
  return rings.reduce((total, points, i) => (i === 0 ? ring(points) : total - ring(points)), 0);
}

/** A point inside the outer ring, where a label sits well: the widest chord through the middle. */
export function labelPoint(ring) {
  const ys = ring.map((p) => p[1]);
  const low = Math.min(...ys);
  const high = Math.max(...ys);
  let best = null;
  for (const share of [0.5, 0.6, 0.4, 0.7, 0.3]) {
    const y = low + (high - low) * share;
    const xs = [];
    for (let i = 0; i < ring.length; i += 1) {
      const [ax, ay] = ring[i];
      const [bx, by] = ring[(i + 1) % ring.length];
      if (ay > y !== by > y) xs.push(ax + ((y - ay) / (by - ay)) * (bx - ax));
    }
    xs.sort((a, b) => a - b);
    for (let i = 0; i + 1 < xs.length; i += 2) {
      const width = xs[i + 1] - xs[i];
      if (!best || width > best.width * 1.15) best = { width, point: [(xs[i] + xs[i + 1]) / 2, y] };
    }
  }
  return best ? best.point : ring[0];
}

/** How far a ring goes on north and south of a point inside it: [up, down], mercator. */
export function roomAround(ring, [lon, lat]) {
  let [up, down] = [Infinity, Infinity];
  for (let i = 0; i < ring.length; i += 1) {
    const [ax, ay] = ring[i];
    const [bx, by] = ring[(i + 1) % ring.length];
    if (ax > lon === bx > lon) continue;
    const off = mercY(lat) - mercY(ay + ((lon - ax) / (bx - ax)) * (by - ay));
    if (off >= 0) up = Math.min(up, off);
    else down = Math.min(down, -off);
  }
  return [up, down].map((room) => (Number.isFinite(room) ? room : 0));
}

/** Nearest place on a mercator polyline: {along, off} in mercator units. `line` is a flat [x, y, x, y, ...] array. */
export function nearestOn(line, x, y) {
  let walked = 0;
  let best = { along: 0, off: Infinity };
  for (let i = 0; i + 3 < line.length; i += 2) {
    const dx = line[i + 2] - line[i];
    const dy = line[i + 3] - line[i + 1];
    const length = Math.hypot(dx, dy);
    const t = length ? Math.min(1, Math.max(0, ((x - line[i]) * dx + (y - line[i + 1]) * dy) / length ** 2)) : 0;
    const off = Math.hypot(line[i] + t * dx - x, line[i + 1] + t * dy - y);
    if (off < best.off) best = { along: walked + t * length, off };
    walked += length;
  }
  return best;
}

/** Cut a flat mercator polyline at `along` (mercator units): [before, after]. */
export function cutAt(line, along) {
  let walked = 0;
  for (let i = 0; i + 3 < line.length; i += 2) {
    const length = Math.hypot(line[i + 2] - line[i], line[i + 3] - line[i + 1]);
    if (walked + length >= along) {
      const t = length ? (along - walked) / length : 0;
      const x = line[i] + t * (line[i + 2] - line[i]);
      const y = line[i + 1] + t * (line[i + 3] - line[i + 1]);
      return [[...line.slice(0, i + 2), x, y], [x, y, ...line.slice(i + 2)]];
    }
    walked += length;
  }
  return [Array.from(line), []];
}
