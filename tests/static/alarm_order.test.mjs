// Which alarms are listed in which order, and what a flood folds.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const context = vm.createContext({ HL: {} });
vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/alarm_order.js', import.meta.url), 'utf8'), context);
const { rows, sequence, isAside, isNews, worst } = context.HL.alarmOrder;

const one = (change) => ({ title: 'No data link', name: 'Weeder 07', text: '', source: 'weeder-07', priority: 2, state: 'unacknowledged', raised: 1000, place: 1, group: 1, ...change });
const ids = (list) => Array.from(list, (row) => row.id);

test('the most urgent come first, of those what nobody has seen, then the newest', () => {
  const found = rows({ old: one({ raised: 1 }), seen: one({ state: 'acknowledged', raised: 9 }), low: one({ priority: 4, raised: 9 }), critical: one({ priority: 1, state: 'acknowledged', raised: 1 }), gone: one({ state: 'returned', raised: 9 }), young: one({ raised: 5 }) });
  assert.deepEqual(ids(found), ['critical', 'young', 'old', 'gone', 'seen', 'low']);
});

test('what is put aside is not among the active ones', () => {
  const alarms = { a: one(), b: one({ state: 'shelved' }), c: one({ state: 'suppressed' }), d: one({ state: 'out_of_service' }) };
  assert.deepEqual(ids(rows(alarms)), ['a']);
  assert.deepEqual(ids(rows(alarms, { isWanted: isAside })).sort(), ['b', 'c', 'd']);
});

test('robot, priority and words narrow the list', () => {
  const alarms = { a: one(), b: one({ source: 'uav-01', name: 'Kestrel 1' }), c: one({ priority: 3, title: 'Tray slow' }) };
  assert.deepEqual(ids(rows(alarms, { filter: { robot: 'uav-01' } })), ['b']);
  assert.deepEqual(ids(rows(alarms, { filter: { priority: 2 } })).sort(), ['a', 'b']);
  assert.deepEqual(ids(rows(alarms, { filter: { q: 'TRAY' } })), ['c']);
});

test('a flood is listed by what came first, and folds what follows', () => {
  const alarms = { cause: one({ raised: 1, first: 'cause', group: 4 }), k1: one({ raised: 2, first: 'cause', place: 2 }), k2: one({ raised: 3, first: 'cause', place: 3 }), other: one({ source: 'x', raised: 4, first: 'other' }) };
  const found = rows(alarms, { isFlood: true });
  assert.deepEqual(ids(found), ['other', 'cause']);
  assert.deepEqual(Array.from(found[1].folds), ['k1', 'k2']);
  const open = rows(alarms, { isFlood: true, open: new Set(['cause']) });
  assert.deepEqual(ids(open), ['other', 'cause', 'k1', 'k2']);
  assert.ok(open[2].isKid);
});

test('a critical alarm is never folded, and its group comes first', () => {
  const alarms = { cause: one({ priority: 3, raised: 1, first: 'cause' }), bad: one({ priority: 1, raised: 2, first: 'cause', place: 2 }), more: one({ raised: 3, first: 'cause', place: 3 }), other: one({ raised: 9, first: 'other' }) };
  const found = rows(alarms, { isFlood: true });
  assert.deepEqual(ids(found), ['cause', 'bad', 'other']);
  assert.deepEqual(Array.from(found[0].folds), ['more']);
});

test('followers whose cause is no longer listed stand under the earliest of them', () => {
  const alarms = { k2: one({ raised: 3, first: 'gone', place: 3 }), k1: one({ raised: 2, first: 'gone', place: 2 }) };
  const [head] = rows(alarms, { isFlood: true });
  assert.equal(head.id, 'k1');
  assert.deepEqual(Array.from(head.folds), ['k2']);
});

test('five hundred alarms of a flood are a list of causes, quickly', () => {
  const alarms = {};
  for (let robot = 0; robot < 25; robot += 1) for (let n = 0; n < 20; n += 1) alarms[`a${n}.r${robot}`] = one({ source: `r${robot}`, raised: robot * 100 + n, first: `a0.r${robot}`, place: n + 1, group: 20 });
  assert.equal(rows(alarms, { isFlood: true }).length, 25);
  assert.equal(rows(alarms).length, 500);
});

test('the sequence is told in words', () => {
  assert.deepEqual({ ...sequence(one({ group: 3, place: 1 })) }, { isFirst: true, text: 'First out, 1 of 3' });
  assert.equal(sequence(one({ group: 3, place: 2 }), 'No data link').text, '2nd, after no data link');
  assert.equal(sequence(one({ group: 13, place: 12 }), 'RTK float').text, '12th, after RTK float');
  assert.equal(sequence(one()).text, '');
});

test('the worst is the one a person has to see first', () => {
  assert.equal(worst(Object.entries({ a: one({ priority: 3 }), b: one() }))[0], 'b');
  assert.equal(worst([]), null);
});

test('what nobody answered stands first of its priority until somebody does', () => {
  const found = rows({ young: one({ raised: 9 }), told: one({ raised: 1, escalated: 5 }), seen: one({ raised: 2, escalated: 5, state: 'acknowledged' }), high: one({ priority: 1, state: 'acknowledged' }) });
  assert.deepEqual(ids(found), ['high', 'told', 'young', 'seen']);
});

test('what is over stands behind what is so now, also if nobody answered it', () => {
  const found = rows({ over: one({ state: 'returned', raised: 1, escalated: 5 }), gone: one({ state: 'returned', raised: 8 }), now: one({ raised: 9 }) });
  assert.deepEqual(ids(found), ['now', 'over', 'gone']);
});

test('what is put aside is not said when it comes, and is said when it is back and still so', () => {
  for (const state of ['shelved', 'suppressed', 'out_of_service']) assert.equal(isNews({ what: 'raised', state }), false);
  for (const what of ['raised', 'unshelved', 'unsuppressed', 'in_service']) assert.equal(isNews({ what, state: 'unacknowledged' }), true, what);
  assert.equal(isNews({ what: 'unsuppressed', state: 'suppressed' }), false, 'another cause still holds');
  assert.equal(isNews({ what: 'unshelved', state: 'returned' }), false);
  assert.equal(isNews({ what: 'escalated', state: 'returned' }), true);
  assert.equal(isNews({ what: 'acknowledged', state: 'acknowledged' }), false);
});
