// What a finished drawing belongs to: where it is drawn decides, not what was chosen before.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Draft } from '../../static/js/editor/draft.js';
import { drawnOf } from '../../static/js/editor/drawn.js';

const at = ([x, y]) => [4.26 + x / 69000, 51.78 + y / 111000];
const made = (id, kind, type, coordinates, name = id) => ({ type: 'Feature', id, properties: { id, kind, name }, geometry: { type, coordinates } });
const box = (id, x0, x1) => made(id, 'parcel', 'Polygon', [[[x0, 0], [x1, 0], [x1, 100], [x0, 100], [x0, 0]].map(at)]);
const west = box('west', 0, 100);
const east = box('east', 100, 200);
const horseshoe = made('horseshoe', 'parcel', 'Polygon', [[[0, 200], [90, 200], [90, 300], [60, 300], [60, 220], [30, 220], [30, 300], [0, 300], [0, 200]].map(at)]);
const inner = box('inner', 35, 55);
const road = made('road', 'road', 'LineString', [[0, 50], [200, 50]].map(at));
const draft = new Draft();
draft.set([west, east, horseshoe, { ...inner, geometry: { type: 'Polygon', coordinates: [[[32, 230], [58, 230], [58, 290], [32, 290], [32, 230]].map(at)] } }, road]);
const drawn = (tool, places, only) => drawnOf(tool, places.map(at), { only }, draft);
const hole = [[140, 40], [160, 40], [150, 45]];

test('rows belong to the field they lie in, whatever was chosen before', () => {
  for (const only of [null, west, east, road]) assert.equal(drawn('rows', [[120, 10], [120, 90]], only).feature.properties.parcel_id, 'east');
});

test('rows that begin on the edge to the chosen field belong to the field they run through', () => {
  assert.equal(drawn('rows', [[100, 10], [190, 10]], west).feature.properties.parcel_id, 'east');
  assert.equal(drawn('rows', [[99, 10], [190, 10]], west).feature.properties.parcel_id, 'east');
});

test('rows beside every field belong to the chosen one, and to none where none is chosen', () => {
  assert.equal(drawn('rows', [[300, 10], [300, 90]], west).feature.properties.parcel_id, 'west');
  assert.equal(drawn('rows', [[300, 10], [300, 90]], null).feature.properties.parcel_id, undefined);
});

test('a hole is cut out of the field it is drawn in', () => {
  for (const only of [null, west, east]) assert.equal(drawn('hole', hole, only).operation.target, 'east');
});

test('a cut divides what it is drawn across', () => {
  for (const only of [null, west, east]) assert.equal(drawn('split', [[150, -10], [150, 130]], only).operation.target, 'east');
  assert.equal(drawn('split', [[95, 20], [210, 20]], west).operation.target, 'east', 'it only begins in the chosen one');
});

test('a cut right across the chosen shape is meant for it, though another lies under its middle', () => {
  assert.equal(drawn('split', [[-10, 260], [100, 260]], horseshoe).operation.target, 'horseshoe');
  assert.equal(drawn('split', [[20, 20], [20, 60]], road).operation.target, 'road');
});

test('a field that is drawn gets the first name that is free', () => {
  const corners = [[0, 400], [50, 400], [50, 450]];
  assert.equal(drawn('parcel', corners, null).feature.properties.name, 'Parcel 1');
  draft.apply([{ id: 'p', after: made('p', 'parcel', 'Polygon', west.geometry.coordinates, 'Parcel 1') }]);
  assert.equal(drawn('parcel', corners, null).feature.properties.name, 'Parcel 2');
  assert.equal(drawn('obstacle', corners, null).feature.properties.name, '');
});
