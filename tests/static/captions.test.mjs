// Names of places on the map: which are readable, and what stands for many that stand close together.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { farmLabels, readableLabels, robotLabels } from '../../static/js/map/captions.js';
import { sideOf, withinSight } from '../../static/js/map/labels.js';

const bay = (number, east) => ({ properties: { kind: 'home', name: `Home, bay ${number}` }, geometry: { type: 'Point', coordinates: [5.7 + east * 1e-4, 52.5] } });
const camera = (pxPerStep) => ({ zoom: 17, worldPx: 1, project: (mx, my) => [((mx - farmLabels([bay(0, 0)])[0].mx) / STEP) * pxPerStep, my] });
const STEP = farmLabels([bay(0, 1)])[0].mx - farmLabels([bay(0, 0)])[0].mx;
const words = (labels) => labels.map((label) => label.lines.map((line) => line.text).join(', '));

test('bays closer than their names are wide carry one name and how many they are', () => {
  const labels = farmLabels([bay(1, 0), bay(2, 1), bay(3, 2), bay(4, 60)]);
  assert.deepEqual(words(readableLabels(labels, camera(20))), ['Home, 3 places', 'Home, bay 4']);
});

test('bays that stand apart keep their own names', () => {
  const labels = farmLabels([bay(1, 0), bay(2, 1)]);
  assert.deepEqual(words(readableLabels(labels, camera(120))), ['Home, bay 1', 'Home, bay 2']);
});

test('homes of different names share none of them', () => {
  const other = { ...bay(9, 1), properties: { kind: 'home', name: 'Yard' } };
  assert.deepEqual(words(readableLabels(farmLabels([bay(1, 0), other]), camera(20))), ['Homes, 2 places']);
});

test('a name at the edge of the map moves in, as far as its own ground lies', () => {
  assert.equal(withinSight(300, 100, 80, 320), 264);
  assert.equal(withinSight(300, 100, 10, 320), 290);
  assert.equal(withinSight(20, 100, 80, 320), 56);
  assert.equal(withinSight(160, 100, 80, 320), 160);
  assert.equal(withinSight(-30, 100, 80, 320), -30); // its place is not in sight
});

test('what stands left of a robot goes to its right where the edge of the map would cut it', () => {
  const label = { align: 'right', dx: -40 };
  assert.equal(sideOf(label, 60, 90), 'left');
  assert.equal(sideOf(label, 160, 90), 'right');
  assert.equal(sideOf({ align: 'left', dx: 18 }, 10, 90), 'left');
});

test('a robot that fell silent in danger keeps its warning beside where it was last seen', () => {
  const robot = { id: 'w', name: 'Weeder 10', isStale: true, level: 1, text: 'Moves although it was stopped', pose: { speed: 0 }, drawn: () => ({ mx: 0, my: 0 }) };
  const look = { isFleet: true, count: 1, now: 0, ageOf: () => 9000, reachOf: () => 4, metresPerPx: 1, palette: { p1: 'red', onP1: 'white' } };
  const texts = (given) => words(robotLabels([{ ...robot, ...given }], look).filter((label) => label.lines.length));
  assert.equal(texts({}).length, 2);
  assert.equal(texts({})[1], 'Weeder 10 Moves although it was stopped');
  assert.equal(texts({ level: 2 }).length, 1);
  assert.equal(texts({ isQuiet: true }).length, 1);
});
