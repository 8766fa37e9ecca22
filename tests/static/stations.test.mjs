// Signs of stations on a map: none lies on another, none leaves what can be seen.

import assert from 'node:assert/strict';
import { test } from 'node:test';

globalThis.window ??= {};
const { apart } = await import('../../static/js/map/stations_view.js');
const WITHIN = [0, 0, 369, 218];
const far = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

test('signs that would lie on another move to the nearest free place', () => {
  const places = [[180, 100], [182, 101], [184, 99], [186, 104], [178, 98], [300, 100]];
  const put = apart(places, 40, WITHIN);
  put.forEach((at, i) => put.slice(0, i).forEach((other) => assert.ok(far(at, other) >= 40, `${i}`)));
  put.forEach((at, i) => assert.ok(far(at, { x: places[i][0], y: places[i][1] }) <= 85, `${i} stays near its place`));
  put.forEach((at, i) => assert.ok(Math.abs(at.x - at.dx - places[i][0]) < 1e-9 && Math.abs(at.y - at.dy - places[i][1]) < 1e-9));
  assert.deepEqual([put[0].dx, put[5].dx], [0, 0]);
});

test('a sign at the edge moves inwards, one whose place is out of sight stays there', () => {
  const put = apart([[365, 210], [366, 211], [400, 300], [402, 300]], 40, WITHIN);
  assert.ok(put[1].x <= 369 && put[1].y <= 218);
  assert.equal(put[2].x, 400);
  assert.ok(put[3].x > 369);
});
