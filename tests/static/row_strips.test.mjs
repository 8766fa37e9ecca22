// Row directions of parcels on the map.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Camera, mercX, mercY } from '../../static/js/map/geometry.js';
import { Strips, degreesOf } from '../../static/js/map/row_strips.js';

const [LON, LAT] = [4.26, 51.78];
const square = (id, lon, properties = {}) => ({
  type: 'Feature',
  id,
  properties: { kind: 'parcel', row_bearing_deg: 0, ...properties },
  geometry: { type: 'Polygon', coordinates: [[[lon, LAT], [lon + 0.002, LAT], [lon + 0.002, LAT + 0.001], [lon, LAT + 0.001], [lon, LAT]]] },
});
const seen = (zoom, bearing = 0) => Object.assign(new Camera(), { mx: mercX(LON + 0.001), my: mercY(LAT + 0.0005), zoom, bearing, width: 1280, height: 800 });

test('rows that run north are lines of one longitude, inside the parcel', () => {
  const { lines } = new Strips().of([square('a', LON)], seen(17));
  assert.ok(lines.length > 10);
  for (const [[x0, y0], [x1, y1]] of lines) {
    assert.ok(Math.abs(x0 - x1) < 1e-9);
    assert.ok(x0 > LON && x0 < LON + 0.002);
    assert.ok(Math.min(y0, y1) >= LAT - 1e-9 && Math.max(y0, y1) <= LAT + 0.001 + 1e-9);
  }
});

test('lines keep their distance on the glass: twice as far away, half as many', () => {
  const strips = new Strips();
  const count = (zoom) => strips.of([square('a', LON)], seen(zoom)).lines.length;
  for (const zoom of [15.5, 16.5, 17.5]) assert.ok(Math.abs(count(zoom) - 2 * count(zoom - 1)) <= 2, `${count(zoom)} and ${count(zoom - 1)}`);
});

test('a headland has no rows', () => {
  const [[[, y0], [, y1]]] = new Strips().of([square('a', LON, { headland_m: 10 })], seen(17)).lines;
  assert.ok(Math.min(y0, y1) > LAT + 8e-5 && Math.max(y0, y1) < LAT + 0.001 - 8e-5);
});

test('nothing for what is out of sight, too small, of unknown direction, or no parcel', () => {
  const none = (feature, zoom = 17) => assert.deepEqual(new Strips().of([feature], seen(zoom)).lines, []);
  none(square('a', LON + 0.1));
  none(square('a', LON), 12);
  none(square('a', LON, { row_bearing_deg: null }));
  none(square('a', LON, { kind: 'building' }));
});

test('the key tells whether anything changed', () => {
  const strips = new Strips();
  const feature = square('a', LON);
  assert.equal(strips.of([feature], seen(17)).key, strips.of([feature], seen(17.01)).key);
  assert.notEqual(strips.of([feature], seen(17)).key, strips.of([feature], seen(18)).key);
  assert.notEqual(strips.of([feature], seen(17)).key, strips.of([square('a', LON, { row_bearing_deg: 90 })], seen(17)).key);
});

test('what is in view in degrees', () => {
  const [west, south, east, north] = degreesOf(seen(17, 30));
  assert.ok(west < LON && east > LON + 0.002 && south < LAT && north > LAT + 0.001);
});
