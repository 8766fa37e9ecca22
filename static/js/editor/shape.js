// The corners of a feature, without the repeated last one of a ring, and features made of changed corners.
// A corner's address is {part, ring, index}; a line is a ring that is not closed, a point a line of one corner.

import { kept } from '../map/plane.js';

const IS_CLOSED = { Polygon: true, MultiPolygon: true };

export const isArea = (feature) => feature?.geometry?.type in IS_CLOSED;

const opened = (ring) => {
  const [first, last] = [ring[0], ring.at(-1)];
  return ring.length > 1 && first[0] === last[0] && first[1] === last[1] ? ring.slice(0, -1) : ring;
};

/** Parts of rings of corners, whatever the geometry is. */
export function partsOf({ geometry }) {
  const { type, coordinates } = geometry ?? {};
  if (type === 'Polygon') return [coordinates.map(opened)];
  if (type === 'MultiPolygon') return coordinates.map((rings) => rings.map(opened));
  if (type === 'LineString') return [[coordinates]];
  if (type === 'MultiLineString' || type === 'MultiPoint') return coordinates.map((line) => (type === 'MultiPoint' ? [[line]] : [line]));
  return type === 'Point' ? [[[coordinates]]] : [];
}

/** Twice the signed area in square degrees: above 0 is counter-clockwise. */
export function turnOf(ring) {
  const [x0, y0] = ring[0]; // near the corners, so that small rings keep their sign
  return ring.reduce((sum, [ax, ay], i) => {
    const [bx, by] = ring[(i + 1) % ring.length];
    return sum + (ax - x0) * (by - y0) - (bx - x0) * (ay - y0);
  }, 0);
}

/** Outer rings counter-clockwise, holes clockwise. */
export const wound = (rings) => rings.map((ring, i) => ((turnOf(ring) < 0) === (i === 0) && turnOf(ring) !== 0 ? [...ring].reverse() : ring));

const closed = (ring) => [...ring, ring[0]];

/** The feature with other corners, wound as GeoJSON wants it; everything else, also what is unknown here, stays. */
export const rebuilt = (feature, parts) => laid(feature, isArea(feature) ? parts.map(wound) : parts);

/** The same in the order given: while a corner is dragged its address must not change. */
export function laid(feature, parts) {
  const { type } = feature.geometry;
  const coordinates = {
    Polygon: () => parts[0].map(closed),
    MultiPolygon: () => parts.map((rings) => rings.map(closed)),
    LineString: () => parts[0][0],
    MultiLineString: () => parts.map(([line]) => line),
    MultiPoint: () => parts.map(([[position]]) => position),
    Point: () => parts[0][0][0],
  }[type]();
  return { ...feature, geometry: { ...feature.geometry, coordinates } };
}

export const cornerAt = (feature, { part, ring, index }) => partsOf(feature)[part]?.[ring]?.[index] ?? null;

function edited(feature, address, change) {
  const parts = partsOf(feature).map((rings) => rings.map((ring) => ring));
  const { part, ring } = address;
  parts[part] = [...parts[part]];
  parts[part][ring] = change([...parts[part][ring]]);
  return parts;
}

/** Corners of the feature with one of them elsewhere. */
export const moved = (feature, address, position) => edited(feature, address, (ring) => {
  ring[address.index] = kept([position[0], position[1], ...ring[address.index].slice(2)]);
  return ring;
});

/** Corners with a new one after `address`. */
export const inserted = (feature, address, position) => edited(feature, address, (ring) => {
  ring.splice(address.index + 1, 0, kept(position));
  return ring;
});

/** Corners without one of them, or null where too few would be left. */
export function removed(feature, address) {
  const least = isArea(feature) ? 3 : 2;
  if (partsOf(feature)[address.part][address.ring].length <= least) return null;
  return edited(feature, address, (ring) => ring.filter((_, i) => i !== address.index));
}

/** Every corner put through `change([lon, lat])`. */
export const carried = (feature, change) => partsOf(feature)
  .map((rings) => rings.map((ring) => ring.map((position) => kept([...change(position), ...position.slice(2)]))));

/** Address of the corner at a place, after a ring was wound the other way. */
export function findCorner(feature, { part, ring }, position) {
  const index = partsOf(feature)[part]?.[ring]?.findIndex((p) => p[0] === position[0] && p[1] === position[1]) ?? -1;
  return index < 0 ? null : { part, ring, index };
}

/** "Corner 2", "Corner 1 of hole 2". */
export function cornerName(feature, { part, ring, index }) {
  if (feature.geometry.type === 'Point') return feature.properties.name || 'Point';
  const word = `${isArea(feature) ? 'Corner' : 'Point'} ${index + 1}`;
  if (ring > 0) return `${word} of hole ${ring}`;
  return part > 0 ? `${word} of part ${part + 1}` : word;
}

/** [a, b, index] of each edge of a ring. */
export function* edgesOf(ring, isClosed) {
  const count = isClosed ? ring.length : ring.length - 1;
  for (let i = 0; i < count; i += 1) yield [ring[i], ring[(i + 1) % ring.length], i];
}

const ID_BYTES = 4;

/** `parcel-1f09c2ab`; not randomUUID, which plain http does not have. */
export function newId(kind) {
  const bytes = crypto.getRandomValues(new Uint8Array(ID_BYTES));
  return `${kind}-${Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('')}`;
}

/** A feature as the draft wants it. */
export function newFeature(kind, geometry, own = {}) {
  const id = newId(kind);
  const bare = { type: 'Feature', id, properties: { id, kind, name: '', ...own }, geometry };
  return rebuilt(bare, carried(bare, (position) => position));
}
