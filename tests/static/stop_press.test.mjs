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

// counts presses: ids have to differ
function pressing() {
  const all = presses();
  let n = 0;
  all.hit = (robots, now, more = {}) => all.press(robots, more.known ?? [], now, { id: more.id ?? `press-${(n += 1)}`, ...more });
  return all;
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

// the gateway confirmed, then it is not heard any more; the console is asked on
function confirmed() {
  const all = presses();
  const claim = (now) => all.byRobot(now, {}).get('a')[0].state;
  all.take(step('a', 'standstill', { ack_ms: 20, standstill_ms: 300 }), 'gateway', 1000, true);
  const hear = (source, state, now, { isFresh = false, ...more } = {}) => {
    all.take(step('a', state, { age_ms: now, ack_ms: 20, standstill_ms: state === 'standstill' ? 300 : null, ...more }), source, now, isFresh);
    return claim(now);
  };
  return { all, claim, hear };
}

test('the console takes standstill back while the gateway is silent, and may say it again', () => {
  const { all, hear } = confirmed();
  assert.equal(hear('console', 'standstill', 10000), 'standstill');
  assert.equal(hear('console', 'not-confirmed', 12000, { text: 'It moves although it confirmed standstill.' }), 'not-confirmed');
  assert.equal(all.byRobot(12000, {}).get('a')[0].text, 'It moves although it confirmed standstill.');
  assert.equal(hear('console', 'not-confirmed', 14000), 'not-confirmed');
  assert.equal(hear('console', 'standstill', 16000), 'standstill');
});

test('a console that never confirmed denies what a silent gateway said, and not what a speaking one says', () => {
  const { hear } = confirmed();
  assert.equal(hear('console', 'not-confirmed', 2000, { isFresh: true }), 'standstill');
  assert.equal(hear('console', 'acknowledged', 9000), 'standstill'); // it only began to ask
  assert.equal(hear('console', 'not-confirmed', 10000), 'not-confirmed');
  assert.equal(hear('gateway', 'standstill', 11000, { isFresh: true }), 'standstill');
});

test('a gateway that answers by HTTP alone is not silent', () => {
  const { hear } = confirmed();
  assert.equal(hear('gateway', 'standstill', 10000), 'standstill');
  assert.equal(hear('console', 'not-confirmed', 10100), 'standstill');
});

test('a console that takes its own word back is believed until the gateway says standstill again', () => {
  const { hear } = confirmed();
  hear('console', 'standstill', 2000, { isFresh: true });
  assert.equal(hear('console', 'not-confirmed', 3000, { isFresh: true }), 'not-confirmed');
  assert.equal(hear('gateway', 'standstill', 3100, { isFresh: true }), 'standstill');
  assert.equal(hear('console', 'not-confirmed', 4000, { isFresh: true }), 'standstill');
});

test('what a gateway took back is confirmed by the console only when that gateway is silent', () => {
  const { hear } = confirmed();
  assert.equal(hear('gateway', 'not-confirmed', 2000, { isFresh: true }), 'not-confirmed');
  assert.equal(hear('console', 'standstill', 3000, { isFresh: true }), 'not-confirmed');
  assert.equal(hear('console', 'standstill', 9000), 'standstill');
});

test('a restarted console counts ages anew, and its late confirmation counts at once', () => {
  const all = presses();
  const hear = (state, age_ms, boot, now) => {
    all.take(step('a', state, { age_ms, boot }), 'console', now, false);
    return all.byRobot(now, {}).get('a')[0].state;
  };
  assert.equal(hear('not-confirmed', 60000, 'b1', 61000), 'not-confirmed');
  assert.equal(hear('standstill', 1500, 'b2', 63000), 'standstill');
  assert.equal(hear('not-confirmed', 1400, 'b2', 63010), 'standstill'); // overtaken
});

test('a press that nobody heard is confirmed by the one that covers it', () => {
  const all = pressing();
  all.hit(['a'], 1000, { isHopeless: true });
  assert.equal(all.byRobot(1000, {}).get('a')[0].state, 'not-confirmed');
  all.hit(['a'], 4000);
  assert.equal(all.byRobot(4000, {}).get('a').map((one) => one.state).join(), 'not-confirmed', 'stays so until it is confirmed');
  all.take(step('a', 'standstill', { stop_id: 'press-2', ack_ms: 20, standstill_ms: 300 }), 'gateway', 5000);
  assert.equal(all.byRobot(5000, {}).get('a').map((one) => one.state).join(), 'standstill');
  all.take({ stop_id: 'press-2', robot: 'a', state: 'reset' }, 'gateway', 6000);
  assert.equal(all.byRobot(6000, {}).size, 0);
  assert.equal(all.own.size, 0);
});

test('a press of all that nobody heard is covered robot by robot, also where no robot was known yet', () => {
  const all = pressing();
  all.hit('all', 1000, { isHopeless: true });
  all.hit('all', 4000, { known: ['a', 'b'] });
  const states = () => [...all.byRobot(4000, {}).values()].map((steps) => steps.map((one) => one.state).join()).join(' ');
  assert.equal(states(), 'not-confirmed not-confirmed');
  for (const robot of ['a', 'b']) all.take(step(robot, 'standstill', { stop_id: 'press-2', ack_ms: 20, standstill_ms: 300 }), 'gateway', 5000);
  assert.equal(states(), 'standstill standstill');
});

test('a covered press that somebody answered stands until it is confirmed itself', () => {
  const all = pressing();
  all.hit(['a'], 1000);
  all.take(step('a', 'sent', { stop_id: 'press-1' }), 'console', 1100);
  all.hit(['a'], 4000);
  all.take(step('a', 'standstill', { stop_id: 'press-2', ack_ms: 20, standstill_ms: 300 }), 'gateway', 5000);
  assert.equal(all.byRobot(5000, {}).get('a').map((one) => one.state).join(), 'not-confirmed,standstill');
});

test('a press at one robot that nobody heard stays until a newer one reaches that robot', () => {
  const all = pressing();
  all.hit(['a'], 1000, { isHopeless: true });
  all.hit('all', 4000, { known: [] });
  assert.equal(all.byRobot(4000, {}).get('a')[0].state, 'not-confirmed');
});
