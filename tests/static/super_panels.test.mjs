// Two columns of functions, the words of a reason, and what is said above a log, without a page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const HL = {
  el: () => ({}), icon: () => ({}), alarm: () => ({}), text: () => {}, attr: () => {}, toggle: () => {}, LiveElement: class {}, superDefine: () => {},
  words: { since: (ms) => `${Math.floor(ms / 1000)} s`, wallSeconds: () => '12:00:00' }, port: { age: (t) => 100000 - t },
};
for (const name of ['super_functions', 'super_logs']) vm.runInContext(readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), vm.createContext({ HL, URLSearchParams, Date }));
const { columns, reason } = HL.superFunctions;
const { said } = HL.superLogs;
const fn = (name, depth = 0, state = 'on') => ({ name, depth, state });
const names = (list) => Array.from(list, (one) => one.name);

test('whole trees stand side by side, in their order, neither column much longer', () => {
  const [left, right] = columns([fn('a'), fn('a1', 1), fn('a2', 1), fn('b'), fn('c'), fn('c1', 1)]);
  assert.deepEqual(names(left), ['a', 'a1', 'a2']);
  assert.deepEqual(names(right), ['b', 'c', 'c1']);
});

test('what is off is taller; a large tree goes on in the second column, but never below a second level', () => {
  const [left, right] = columns([fn('a', 0, 'off'), fn('b', 0, 'off'), fn('c'), fn('d'), fn('e')]);
  assert.deepEqual([names(left), names(right)], [['a', 'b'], ['c', 'd', 'e']]);
  const [one, rest] = columns([fn('a'), fn('a1', 1), fn('a2', 2), fn('a3', 1), fn('a4', 1), fn('a5', 1), fn('a6', 1), fn('b')]);
  assert.deepEqual([names(one), names(rest)], [['a', 'a1', 'a2', 'a3', 'a4'], ['a5', 'a6', 'b']]);
  const [deep, none] = columns([fn('a'), fn('a1', 1), fn('a2', 2)]);
  assert.deepEqual([names(deep).length, names(none).length], [3, 0]);
  assert.deepEqual(Array.from(columns([]), (list) => list.length), [0, 0]);
});

test('a reason carries its age where the age is known, before what else is missing', () => {
  assert.equal(reason({ why: 'Rear camera lost', since: 59000 }), 'Rear camera lost for 41 s');
  assert.equal(reason({ why: 'Rear camera lost, and 2 more', since: 59000 }), 'Rear camera lost for 41 s, and 2 more');
  assert.equal(reason({ why: 'Oil at 78 °C, limit 75 °C', since: null }), 'Oil at 78 °C, limit 75 °C');
  assert.equal(reason({ why: '', since: null }), '');
});

test('above a log stands how much of it is shown, and when it was read', () => {
  assert.equal(said({ lines: [], found: 0, read: 0 }, false, 'at 12:00'), 'Its log is empty. Read at 12:00.');
  assert.equal(said({ lines: ['a', 'b'], found: 2, read: 2 }, false, 'at 12:00'), 'The last 2 lines, read at 12:00.');
  assert.equal(said({ lines: [], found: 0, read: 900 }, true, 'at 12:00'), 'Nothing found in its last 900 lines. Read at 12:00.');
  assert.equal(said({ lines: ['a'], found: 7, read: 900 }, true, 'at 12:00'), 'The last 1 of 7 found in its last 900 lines. Read at 12:00.');
});

// a screen's part without a page: its class, and what it writes
function part(name, more) {
  const made = { timers: [], said: '' };
  const world = {
    ...HL, text: (_node, said) => (made.said = said), superDefine: (_tag, type) => (made.type = type), repaint() {}, ...more,
  };
  const setTimeout = (call, ms) => made.timers.push([call, ms]);
  vm.runInContext(readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), vm.createContext({ HL: world, setTimeout, clearTimeout() {} }));
  return Object.assign(made, { one: Object.create(made.type.prototype) });
}

test('durations without their short stays say so, and where the others are', () => {
  const gantt = part('super_gantt', { superTimes: { word: () => 'this mission', isLive: () => false }, view: { robot: 'planter-01' }, port: { inside: () => ({}) } });
  gantt.one.sub = {};
  const data = { per_state: [], intervals: Array(4000).fill({}), stays: 5210, is_thinned: true };
  gantt.one.words(data);
  assert.equal(gantt.said, 'this mission, the 4,000 longest of 5,210 stays; the table has all');
  gantt.one.words({ ...data, is_thinned: false });
  assert.equal(gantt.said, 'this mission');
});

test('a chart whose layout failed is tried again, and its problem is gone when it stands', async () => {
  const answers = [Promise.reject(new Error('the layout did not load')), Promise.resolve({})];
  let asked = 0;
  const chart = part('super_chart', { chartLayouts: { of: () => ({ key: 'a', layout: answers[Math.min(asked++, 1)] }) } });
  Object.assign(chart.one, { chart: {}, stage: { getBoundingClientRect: () => ({ width: 800, height: 600 }) }, drawing: { connect: () => true } });
  chart.one.lay();
  await new Promise((done) => setImmediate(done));
  assert.equal(chart.one.problem, 'The chart could not be laid out: the layout did not load');
  const [[again, ms]] = chart.timers;
  assert.equal(ms, 5000);
  again();
  await new Promise((done) => setImmediate(done));
  assert.deepEqual([asked, chart.one.problem, chart.timers.length], [2, '', 1]);
});
