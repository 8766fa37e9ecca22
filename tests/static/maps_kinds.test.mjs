// What can be entered for a shape of the map, and what becomes of it as another kind.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const fleet = { a: { name: 'Weeder 10' }, b: { name: 'Weeder 9' }, c: { name: 'Drone 1' } };
const HL = { port: { fleet: () => fleet } };
vm.runInNewContext(fs.readFileSync(new URL('../../static/js/ui/maps_kinds.js', import.meta.url), 'utf8'), { HL, window: {} });
const M = HL.maps;
const json = (value) => JSON.parse(JSON.stringify(value));
const shape = (kind, type, own = {}) => ({ type: 'Feature', id: 'x', properties: { id: 'x', kind, name: 'X', ...own }, geometry: { type } });
const as = (kind, feature) => json(M.withKind(feature, kind).properties);

test('a point that becomes an obstacle has a radius, one that has its own keeps it', () => {
  assert.deepEqual(as('obstacle', shape('gate', 'Point')), { id: 'x', kind: 'obstacle', name: 'X', radius_m: 1 });
  assert.equal(as('obstacle', shape('tree', 'Point', { radius_m: 3 })).radius_m, 3);
  assert.equal(as('obstacle', shape('parcel', 'Polygon')).radius_m, undefined);
});

test('a type that the new kind does not know is left out, any other one is kept', () => {
  assert.equal(as('home', shape('tree', 'Point', { type: 'oak' })).type, undefined);
  assert.equal(as('rows', shape('road', 'LineString', { type: 'track' })).type, undefined);
  assert.equal(as('road', shape('rows', 'LineString', { type: 'a-b' })).type, undefined);
  assert.equal(as('home', shape('gate', 'Point', { type: 'garage' })).type, 'garage');
  assert.equal(as('water', shape('hedge', 'LineString', { type: 'ditch' })).type, 'ditch');
});

test('robots and fields stand in the order people count in', () => {
  assert.deepEqual(json(M.robots()), [['c', 'Drone 1'], ['b', 'Weeder 9'], ['a', 'Weeder 10']]);
  const robot = M.fieldsOf(shape('home', 'Point')).find((one) => one.key === 'robot');
  assert.deepEqual(json(robot.options()).map(([, name]) => name), ['Any robot', 'Drone 1', 'Weeder 9', 'Weeder 10']);
});

test('rows can be given to any field of the map', () => {
  const field = M.fieldsOf(shape('rows', 'LineString')).find((one) => one.key === 'parcel_id');
  const named = (name) => ({ ...shape('parcel', 'Polygon'), properties: { kind: 'parcel', name } });
  const features = new Map([['p10', named('Parcel 10')], ['r', shape('road', 'LineString')], ['p9', named('Parcel 9')]]);
  assert.deepEqual(json(field.options(features)), [['', 'No field'], ['p9', 'Parcel 9'], ['p10', 'Parcel 10']]);
});

test('what can be flown over has a height, nothing else has', () => {
  const has = (kind, type) => [...M.fieldsOf(shape(kind, type))].some((one) => one.key === 'height_m');
  const polygons = ['parcel', 'farm', 'obstacle', 'no-go', 'slow', 'treatment', 'building', 'road', 'tree', 'hedge', 'water'];
  assert.deepEqual(polygons.filter((kind) => has(kind, 'Polygon')), ['obstacle', 'building', 'tree', 'hedge']);
  assert.deepEqual(['obstacle', 'tree', 'home', 'gate'].filter((kind) => has(kind, 'Point')), ['obstacle', 'tree']);
  assert.deepEqual(['tree', 'hedge', 'water', 'road', 'rows'].filter((kind) => has(kind, 'LineString')), ['tree', 'hedge']);
});

test('a height is typed with point or comma, above 0 and at most 300 m', () => {
  const field = M.fieldsOf(shape('building', 'Polygon')).find((one) => one.key === 'height_m');
  assert.deepEqual(['12,5', '300', '', '0', '-2', '301', 'NaN', 'high'].map((typed) => M.stored(field, typed)), [12.5, 300, null, undefined, undefined, undefined, undefined, undefined]);
  assert.equal(M.changeLabel(field, undefined, 12.5), 'Height above ground set to 12.5 m');
});
