// What is claimed of each press, and that a thousand robots cost no more than one look each.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

function presses() {
  const window = {};
  const crypto = { getRandomValues: (bytes) => bytes.fill(7) };
  vm.runInContext(fs.readFileSync(new URL('../../static/js/stop_press.js', import.meta.url), 'utf8'), vm.createContext({ window, crypto, Date, Map, Set, Uint8Array }));
  return new window.headlandStopParts.Presses();
}

const step = (robot, state, more = {}) => ({ stop_id: 'press-1', robot, state, age_ms: 100, sent_ms: 5, ack_ms: null, standstill_ms: null, by: 'Martha', ...more });

test('each robot has its presses, the worst first', () => {
  const all = presses();
  all.take(step('a', 'standstill', { ack_ms: 20, standstill_ms: 300 }), 'gateway', 1000);
  all.take(step('a', 'sent', { stop_id: 'press-2' }), 'gateway', 1000);
  all.take(step('b', 'acknowledged', { ack_ms: 20 }), 'gateway', 1000);
  const found = all.byRobot(1050, {});
  assert.deepEqual([...found.keys()], ['a', 'b']);
  assert.equal(found.get('a').map((one) => one.state).join(), 'sent,standstill');
});

test('a press that time alone makes worse is another claim, and is told as one', () => {
  const all = presses();
  all.take(step('a', 'sent'), 'gateway', 1000);
  all.byRobot(1000, {});
  const before = all.revision;
  assert.equal(all.byRobot(1500, {}).get('a')[0].state, 'sent');
  assert.equal(all.revision, before);
  assert.equal(all.byRobot(2000, {}).get('a')[0].state, 'not-confirmed');
  assert.equal(all.revision, before + 1);
});

test('the same step told again keeps its claim; a reset takes it away', () => {
  const all = presses();
  all.take(step('a', 'standstill', { ack_ms: 20, standstill_ms: 300 }), 'gateway', 1000);
  const held = all.byRobot(1100, {}).get('a')[0];
  assert.equal(all.byRobot(1200, {}).get('a')[0], held);
  const before = all.revision;
  all.take(step('a', 'standstill', { ack_ms: 20, standstill_ms: 300, age_ms: 400 }), 'gateway', 1300);
  assert.equal(all.byRobot(1300, {}).get('a')[0].heard_at, 1300);
  assert.equal(all.revision, before);
  all.take({ stop_id: 'press-1', robot: 'a', state: 'reset' }, 'gateway', 1400);
  assert.equal(all.byRobot(1400, {}).size, 0);
  assert.equal(all.revision, before + 1);
});

test('a thousand stopped robots are looked at once each', () => {
  const all = presses();
  for (let i = 0; i < 1000; i += 1) all.take(step(`robot-${i}`, 'standstill', { ack_ms: 20, standstill_ms: 300 }), 'gateway', 1000);
  let looks = 0;
  const { stateOf } = all;
  all.stateOf = function counted(...given) { looks += 1; return stateOf.apply(this, given); };
  assert.equal(all.byRobot(1100, {}).size, 1000);
  assert.equal(looks, 1000);
});
