// Which alarm tone sounds when, on a clock that only the test moves.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const context = vm.createContext({ HL: {} });
for (const name of ['alarm_tones', 'alarm_order']) vm.runInContext(fs.readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), context);
const { Tones, PATTERNS } = context.HL.alarmTones;

class Bell {
  constructor(stop = () => null) {
    this.now = 0;
    this.heard = [];
    this.alarms = {};
    this.isFlood = false;
    this.stop = stop;
    this.tones = new Tones({ play: (pattern) => this.heard.push([this.now, Number(Object.keys(PATTERNS).find((level) => PATTERNS[level] === pattern))]), stop: () => this.stop(this.now) });
  }
  raise(id, priority, more = {}) { this.alarms = { ...this.alarms, [id]: { priority, state: 'unacknowledged', raised: this.now + 1, occurrences: 1, latching: false, ...more } }; }
  set(id, change) { this.alarms = { ...this.alarms, [id]: { ...this.alarms[id], ...change } }; }
  run(ms) { for (const end = this.now + ms; this.now < end; this.now += 100) this.tones.follow(this.alarms, this.now, this.isFlood); }
  take() { const heard = this.heard; this.heard = []; return heard; }
}

const plain = (value) => JSON.parse(JSON.stringify(value)); // arrays of another context
const times = (heard) => heard.map(([at]) => at);

test('the patterns are those of the specification', () => {
  assert.deepEqual(plain(PATTERNS[1].tones.map(([, hz, s]) => [hz, s])), [[988, 0.15], [988, 0.15], [988, 0.15]]);
  assert.deepEqual([PATTERNS[1].everyMs, PATTERNS[2].everyMs, PATTERNS[3].everyMs], [2000, 10000, 0]);
  assert.deepEqual(plain(PATTERNS[2].tones.map(([, hz]) => hz)), [784, 784]);
  assert.deepEqual(plain(PATTERNS[3].tones.map(([, hz]) => hz)), [587]);
  assert.equal(PATTERNS[4], undefined);
  assert.ok(PATTERNS[1].shake.length > 0 && !PATTERNS[2].shake);
});

test('priority 1 sounds every 2 s, 2 every 10 s, 3 once and 4 never', () => {
  for (const [priority, expected] of [[1, [0, 2000, 4000, 6000, 8000, 10000, 12000]], [2, [0, 10000]], [3, [0]], [4, []]]) {
    const bell = new Bell();
    bell.tones.follow({}, -100);
    bell.raise('a', priority);
    bell.run(13000);
    assert.deepEqual(times(bell.take()), expected, `priority ${priority}`);
  }
});

test('only the highest priority that nobody acknowledged sounds', () => {
  const bell = new Bell();
  bell.raise('low', 2);
  bell.raise('high', 1);
  bell.run(5000);
  assert.ok(bell.take().every(([, level]) => level === 1));
  bell.set('high', { state: 'acknowledged' });
  bell.run(11000);
  assert.ok(bell.heard.length >= 1 && bell.take().every(([, level]) => level === 2));
});

test('what is acknowledged, shelved or returned is silent, but one that latches is not', () => {
  const bell = new Bell();
  bell.raise('a', 1);
  bell.run(100);
  bell.take();
  for (const state of ['acknowledged', 'shelved', 'returned', 'latched', 'suppressed', 'out_of_service']) {
    bell.set('a', { state });
    bell.run(5000);
    assert.deepEqual(bell.take(), [], state);
  }
  bell.set('a', { state: 'returned', latching: true });
  bell.run(3000);
  assert.ok(bell.take().length >= 1);
});

test('a page that opens on an old note of priority 3 stays quiet, on an old critical alarm it sounds', () => {
  const note = new Bell();
  note.raise('a', 3);
  note.run(5000);
  assert.deepEqual(note.take(), []);
  const critical = new Bell();
  critical.raise('a', 1);
  critical.run(3000);
  assert.deepEqual(times(critical.take()), [0, 2000]);
});

test('silence mutes for two minutes, and a new critical alarm sounds again', () => {
  const bell = new Bell();
  bell.raise('a', 1);
  bell.run(1000);
  bell.take();
  bell.tones.silence(bell.now, 120000);
  bell.run(60000);
  assert.deepEqual(bell.take(), []);
  bell.raise('b', 2);
  bell.run(10000);
  assert.deepEqual(bell.take(), [], 'a new one of priority 2 stays silent');
  bell.raise('c', 1);
  bell.run(1000);
  assert.equal(bell.take().length, 1);
});

test('after the two minutes it sounds again by itself', () => {
  const bell = new Bell();
  bell.raise('a', 2);
  bell.run(1000);
  bell.take();
  bell.tones.silence(bell.now, 120000);
  bell.run(121000);
  assert.ok(bell.take().length >= 1);
});

test('the same alarm raised anew is a new one', () => {
  const bell = new Bell();
  bell.tones.follow({}, 0);
  bell.raise('a', 3);
  bell.run(3000);
  bell.set('a', { state: 'acknowledged' });
  bell.run(3000);
  bell.set('a', { state: 'unacknowledged', raised: bell.now, occurrences: 2 });
  bell.run(3000);
  assert.equal(bell.take().length, 2);
});

test('many new alarms at once are one sound, not a rattle', () => {
  const bell = new Bell();
  bell.tones.follow({}, 0);
  for (let i = 0; i < 50; i += 1) {
    bell.raise(`a${i}`, 2);
    bell.run(100);
  }
  const heard = times(bell.take());
  heard.slice(1).forEach((at, i) => assert.ok(at - heard[i] >= 2000));
});

test('in a flood priorities 3 and 4 are mute, 1 and 2 are not', () => {
  const bell = new Bell();
  bell.tones.follow({}, 0);
  bell.isFlood = true;
  bell.raise('a', 3);
  bell.run(3000);
  assert.deepEqual(bell.take(), []);
  bell.raise('b', 2);
  bell.run(1000);
  assert.equal(bell.take().length, 1);
});

test('STOP is alone while somebody stops a machine', () => {
  for (const state of ['sent', 'acknowledged', 'not-confirmed', 'standstill']) {
    const bell = new Bell(() => ({ state, inMs: 1500 }));
    bell.raise('a', 1);
    bell.run(5000);
    assert.deepEqual(bell.take(), [], state);
    bell.stop = () => null;
    bell.run(1000);
    assert.equal(bell.take().length, 1, `after ${state}`);
  }
});

test('the lost link of STOP is not doubled, and a critical alarm does not sound into it', () => {
  const high = new Bell(() => ({ state: 'no-link', inMs: 5000 }));
  high.raise('a', 2);
  high.run(20000);
  assert.deepEqual(high.take(), []);
  const critical = new Bell((now) => ({ state: 'no-link', inMs: 10000 - (now % 10000) }));
  critical.raise('a', 1);
  critical.run(30000);
  const heard = times(critical.take());
  assert.ok(heard.length > 8);
  heard.forEach((at) => assert.ok(10000 - (at % 10000) >= 700, `${at}`));
});

test('what nobody answered sounds once more, for 1 and 2 also where the sound was silenced', () => {
  for (const [priority, isHeard] of [[1, true], [2, true], [3, false]]) {
    const bell = new Bell();
    bell.tones.follow({}, -100);
    bell.raise('a', priority, { escalated: null });
    bell.run(3000);
    assert.equal(bell.take().length > 0, true);
    bell.tones.silence(bell.now, 120000);
    bell.run(5000);
    assert.deepEqual(bell.take(), []);
    bell.set('a', { escalated: 1234 });
    bell.run(1000);
    assert.equal(bell.take().length > 0, isHeard, `priority ${priority}`);
  }
  const note = new Bell();
  note.tones.follow({}, -100);
  note.raise('a', 3, { escalated: null });
  note.run(5000);
  note.set('a', { escalated: 1234 });
  note.run(5000);
  assert.equal(note.take().length, 2);
});

test('a page that opens on what was told on long ago does not take it for new', () => {
  const bell = new Bell();
  bell.tones.silence(0, 120000);
  bell.raise('a', 2, { escalated: 1234 });
  bell.run(5000);
  assert.deepEqual(bell.take(), []);
});
