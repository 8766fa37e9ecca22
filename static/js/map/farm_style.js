// How the farm looks, once for both engines: colours by palette name, widths in metres or px.

import { mercPerMetre, mercY } from './geometry.js';

const METRES_AT = [12, 24]; // zooms between which MapLibre interpolates widths given in metres

/** Bottom to top. `source` is the farm's features, the row directions of its parcels, or the parcel of the running mission. */
export const FARM_LAYERS = [
  { id: 'water-area', source: 'farm', kinds: ['water'], shape: 'polygon', fill: 'water' },
  { id: 'water-line', source: 'farm', kinds: ['water'], shape: 'line', line: 'water', widthM: 4, leastPx: 2 },
  { id: 'tree-area', source: 'farm', kinds: ['tree', 'hedge', 'forest'], shape: 'polygon', fill: 'tree' },
  { id: 'tree-line', source: 'farm', kinds: ['tree', 'hedge'], shape: 'line', line: 'tree', widthM: 5, leastPx: 2 },
  { id: 'tree-point', source: 'farm', kinds: ['tree'], shape: 'point', fill: 'tree', radiusM: 3, leastPx: 2 },
  { id: 'road-area', source: 'farm', kinds: ['road'], shape: 'polygon', fill: 'road', line: 'roadEdge', leastPx: 1 },
  { id: 'road-casing', source: 'farm', kinds: ['road'], shape: 'line', line: 'roadEdge', widthM: 4, leastPx: 2, plusPx: 2.4 },
  { id: 'road-line', source: 'farm', kinds: ['road'], shape: 'line', line: 'road', widthM: 4, leastPx: 2 },
  { id: 'parcel', source: 'farm', kinds: ['parcel'], shape: 'polygon', fill: 'parcel', line: 'edge', leastPx: 1.2 },
  { id: 'rows', source: 'rows', kinds: ['rows'], shape: 'line', line: 'row', leastPx: 0.8 },
  { id: 'no-go', source: 'farm', kinds: ['no-go', 'no_go', 'hole'], shape: 'polygon', fill: 'ground', line: 'edge', leastPx: 1.4, dash: [6, 4] },
  { id: 'building', source: 'farm', kinds: ['building'], shape: 'polygon', fill: 'building', line: 'obstacle', leastPx: 0.8 },
  { id: 'mission-parcel', source: 'mission', kinds: ['parcel'], shape: 'polygon', fill: 'headland', line: 'edge', leastPx: 2.2 },
  { id: 'obstacle', source: 'farm', kinds: ['obstacle'], shape: 'polygon', fill: 'ground', line: 'obstacle', leastPx: 1.6, dash: [4, 3] },
  { id: 'obstacle-line', source: 'farm', kinds: ['obstacle'], shape: 'line', line: 'obstacle', leastPx: 2, dash: [4, 3] },
  { id: 'obstacle-point', source: 'farm', kinds: ['obstacle'], shape: 'point', fill: 'ground', line: 'obstacle', radiusM: 1, leastPx: 5 },
  { id: 'home-area', source: 'farm', kinds: ['home'], shape: 'polygon', fill: 'building', line: 'edge', leastPx: 1.2 },
];

/** Layers a person can hide, and what belongs to them. */
export const SURROUNDINGS = new Set(
  FARM_LAYERS.filter((l) => /^(water|tree|building|road)/.test(l.id)).map((l) => l.id),
);

const TYPES = { polygon: ['Polygon', 'MultiPolygon'], line: ['LineString', 'MultiLineString'], point: ['Point', 'MultiPoint'] };
export const isOf = (layer, feature) =>
  layer.kinds.includes(feature.properties?.kind) && TYPES[layer.shape].includes(feature.geometry?.type);

/** Width expression: metres on the ground, never under `least` px. */
function metres(value, lat, least, plus = 0) {
  const perM = (zoom) => 512 * 2 ** zoom * mercPerMetre(mercY(lat));
  const at = (zoom) => ['+', plus, ['max', least, ['*', value, perM(zoom)]]];
  return ['interpolate', ['exponential', 2], ['zoom'], ...METRES_AT.flatMap((zoom) => [zoom, at(zoom)])];
}

const own = (name, usual) => ['coalesce', ['get', name], usual];

/** MapLibre layers of one entry; paint values starting with '@' are palette names. */
function compile(layer, lat) {
  const filter = ['all', ['in', ['get', 'kind'], ['literal', layer.kinds]],
    ['in', ['geometry-type'], ['literal', TYPES[layer.shape]]]];
  const base = { source: layer.source, filter };
  const layers = [];
  if (layer.shape === 'point') {
    const paint = { 'circle-color': `@${layer.fill}`, 'circle-radius': metres(own('radius_m', layer.radiusM), lat, layer.leastPx) };
    if (layer.line) Object.assign(paint, { 'circle-stroke-color': `@${layer.line}`, 'circle-stroke-width': 1.6 });
    return [{ ...base, id: layer.id, type: 'circle', paint }];
  }
  if (layer.fill) layers.push({ ...base, id: layer.id, type: 'fill', paint: { 'fill-color': `@${layer.fill}`, 'fill-antialias': true } });
  if (layer.line) {
    const width = layer.widthM
      ? metres(own('width_m', layer.widthM), lat, layer.leastPx, layer.plusPx ?? 0)
      : layer.leastPx;
    const paint = { 'line-color': `@${layer.line}`, 'line-width': width };
    if (layer.dash) paint['line-dasharray'] = layer.dash.map((px) => px / layer.leastPx);
    const layout = { 'line-join': 'round', 'line-cap': layer.dash ? 'butt' : 'round' };
    layers.push({ ...base, id: layer.fill ? `${layer.id}-edge` : layer.id, type: 'line', layout, paint });
  }
  return layers;
}

const COMPILED = (lat) => [
  { id: 'ground', type: 'background', paint: { 'background-color': '@ground' } },
  ...FARM_LAYERS.flatMap((layer) => compile(layer, lat)),
];

const EMPTY = { type: 'FeatureCollection', features: [] };

/** Offline MapLibre style: no glyphs, sprites or tiles. `lat` sets the scale of widths in metres. */
export function farmStyle(palette, lat, data = {}) {
  const colour = (value) => (typeof value === 'string' && value[0] === '@' ? palette[value.slice(1)] : value);
  const layers = COMPILED(lat).map((layer) => ({
    ...layer,
    paint: Object.fromEntries(Object.entries(layer.paint).map(([key, value]) => [key, colour(value)])),
  }));
  // 0 keeps every corner: a parcel edge must not move with the zoom. 18 tiles resolve one centimetre.
  const source = (name) => ({ type: 'geojson', data: data[name] ?? EMPTY, tolerance: 0, maxzoom: 18 });
  return { version: 8, transition: { duration: 0, delay: 0 }, sources: { farm: source('farm'), rows: source('rows'), mission: source('mission') }, layers };
}

/** [layer id, paint property, value] of everything given in metres, for a latitude. */
export function farmWidths(lat) {
  return COMPILED(lat).flatMap((layer) => ['circle-radius', 'line-width']
    .filter((key) => Array.isArray(layer.paint[key])).map((key) => [layer.id, key, layer.paint[key]]));
}

/** [layer id, paint property, palette name] of everything that changes with the theme. */
export function themedPaints() {
  return COMPILED(0).flatMap((layer) => Object.entries(layer.paint)
    .filter(([, value]) => typeof value === 'string' && value[0] === '@')
    .map(([key, value]) => [layer.id, key, value.slice(1)]));
}
