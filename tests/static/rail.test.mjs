// Which screens stay in the row of a portrait tablet, and which go behind More.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const context = vm.createContext({ HL: {}, document: { querySelector: () => null } });
vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/rail.js', import.meta.url), 'utf8'), context);
const staying = (names, places) => [...context.HL.rail.staying(names, places)];
const ALL = ['operate', 'fleet', 'cameras', 'twin', 'maps', 'missions', 'alarms', 'supervisor', 'sensors', 'admin'];

test('where all fit nothing goes behind More', () => {
  assert.deepEqual(staying(ALL, ALL.length), ALL);
});

test('More takes a place, and alarms and the robot stay until the last', () => {
  assert.equal(staying(ALL, 7).length, 6);
  assert.deepEqual(staying(ALL, 5), ['operate', 'alarms', 'fleet', 'missions']);
  assert.deepEqual(staying(ALL, 3), ['operate', 'alarms']);
  assert.deepEqual(staying(ALL, 0), ['operate']);
});

test('a role without the first ones keeps what it has, in its order', () => {
  assert.deepEqual(staying(['fleet', 'twin', 'supervisor'], 2), ['fleet']);
  assert.deepEqual(staying(['twin', 'supervisor', 'admin'], 2), ['twin']);
});
