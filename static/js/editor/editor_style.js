// What the builder adds to the look of the farm: the parcel in hand with its rows, and kinds that robots never see.

import { mercPerMetre, mercY } from '../map/geometry.js';

const ZOOMS = [12, 24]; // between which MapLibre doubles widths given in metres
const EMPTY = { type: 'FeatureCollection', features: [] };
const ofKind = (...kinds) => ['in', ['get', 'kind'], ['literal', kinds]];
const isShape = (...types) => ['in', ['geometry-type'], ['literal', types]];
const AREAS = isShape('Polygon', 'MultiPolygon');
const LINES = isShape('LineString', 'MultiLineString');
const POINTS = isShape('Point', 'MultiPoint');
const isLook = (look) => ['==', ['get', 'look'], look];

/** [layer, id of the layer above it or null]; paint values starting with '@' are palette names. */
const LAYERS = [
  [{ id: 'edit-farm', source: 'farm', type: 'line', filter: ['all', ofKind('farm'), AREAS], paint: { 'line-color': '@edge', 'line-width': 1.4, 'line-dasharray': [8, 4] } }, 'parcel'],
  [{ id: 'edit-treatment', source: 'farm', type: 'line', filter: ['all', ofKind('treatment'), AREAS], paint: { 'line-color': '@plan', 'line-width': 1.6, 'line-dasharray': [4, 3] } }, null],
  [{ id: 'edit-slow', source: 'farm', type: 'line', filter: ['all', ofKind('slow'), AREAS], paint: { 'line-color': '@plan', 'line-width': 1.6, 'line-dasharray': [2, 3] } }, null],
  [{ id: 'edit-rows-kept', source: 'farm', type: 'line', filter: ['all', ofKind('rows'), LINES], paint: { 'line-color': '@plan', 'line-width': 2 } }, null],
  [{ id: 'edit-place', source: 'farm', type: 'circle', filter: ['all', ofKind('home', 'gate'), POINTS], paint: { 'circle-color': '@raised', 'circle-radius': 8, 'circle-stroke-color': '@ink', 'circle-stroke-width': 2 } }, null],
  [{ id: 'edit-strips', source: 'strips', type: 'line', paint: { 'line-color': '@row', 'line-width': 1, 'line-opacity': 0.55 } }, 'no-go'],
  [{ id: 'edit-headland', source: 'edit', type: 'fill', filter: isLook('headland'), paint: { 'fill-color': '@headland' } }, 'no-go'],
  [{ id: 'edit-plain', source: 'edit', type: 'fill', filter: isLook('plain'), paint: { 'fill-color': '@parcelOn' } }, 'no-go'],
  [{ id: 'edit-bed', source: 'edit', type: 'line', filter: isLook('ground'), paint: { 'line-color': '@parcelOn', 'line-width': 1 } }, 'no-go'],
  [{ id: 'edit-rows', source: 'edit', type: 'line', filter: isLook('rows'), paint: { 'line-color': '@row', 'line-width': 1.2 } }, 'no-go'],
];

const colour = (value, palette) => (typeof value === 'string' && value[0] === '@' ? palette[value.slice(1)] : value);

/** Add the builder's source and layers to a running map. */
export function addEditorStyle(map, palette) {
  map.addSource('edit', { type: 'geojson', data: EMPTY, tolerance: 0, maxzoom: 18 });
  map.addSource('strips', { type: 'geojson', data: EMPTY, tolerance: 0, maxzoom: 18 });
  for (const [layer, above] of LAYERS) {
    const paint = Object.fromEntries(Object.entries(layer.paint).map(([key, value]) => [key, colour(value, palette)]));
    map.addLayer({ ...layer, paint }, above && map.getLayer(above) ? above : undefined);
  }
}

export function paintEditorStyle(map, palette) {
  for (const [layer] of LAYERS) {
    for (const [key, value] of Object.entries(layer.paint)) {
      if (colour(value, palette) !== value) map.setPaintProperty(layer.id, key, colour(value, palette));
    }
  }
}

/** Show row directions of all others: [[lon, lat], [lon, lat]] each. */
export function showStrips(map, lines) {
  const features = lines.length ? [{ type: 'Feature', properties: {}, geometry: { type: 'MultiLineString', coordinates: lines } }] : [];
  map.getSource('strips')?.setData({ type: 'FeatureCollection', features });
}

/** Show parcels in hand: [{feature, rows: {ground: {lines, spacingM}, lines} or null}]. */
export function showBed(map, beds, lat) {
  const features = [];
  let widest = 0;
  for (const { feature, rows } of beds) {
    const hasRows = Boolean(rows?.ground.lines.length);
    features.push({ type: 'Feature', properties: { look: hasRows ? 'headland' : 'plain' }, geometry: feature.geometry });
    if (!hasRows) continue;
    widest = Math.max(widest, rows.ground.spacingM);
    const lines = (look, coordinates) => ({ type: 'Feature', properties: { look }, geometry: { type: 'MultiLineString', coordinates } });
    features.push(lines('ground', rows.ground.lines), lines('rows', rows.lines));
  }
  map.getSource('edit')?.setData({ type: 'FeatureCollection', features });
  if (!widest) return;
  const at = (zoom) => Math.max(1, 1.15 * widest * 512 * 2 ** zoom * mercPerMetre(mercY(lat)));
  const width = ['interpolate', ['exponential', 2], ['zoom'], ...ZOOMS.flatMap((zoom) => [zoom, at(zoom)])];
  const key = JSON.stringify(width);
  if (map.bedWidth === key) return;
  map.bedWidth = key;
  map.setPaintProperty('edit-bed', 'line-width', width);
}
