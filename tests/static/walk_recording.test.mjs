// A walk without a page: what was not seen, what goes on after a reload, and what is missing at the end.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const M_PER_DEG_LAT = 111229; // at 51.7 degrees
const M_PER_DEG_LON = 69130;
const place = (x, y, at_s, accuracy_m = 0.02) => ({ lon: 4.2 + x / M_PER_DEG_LON, lat: 51.7 + y / M_PER_DEG_LAT, accuracy_m, at_s });

// a page of its own over a store that outlives pages; its clock is moved by hand
function page(store, clock) {
  const HL = {
    maps: {},
    draft: { get: (key) => JSON.parse(store.get(key) ?? '""'), set: (key, value) => store.set(key, JSON.stringify(value)), clear: (key) => store.delete(key) },
  };
  const later = [];
  const told = {};
  const hear = (name, run) => (told[name] = run);
  const context = vm.createContext({ HL, Date: { now: () => clock.ms }, window: { addEventListener: hear }, document: { addEventListener: hear, hidden: false }, setInterval: (run) => later.push(run), clearInterval: () => (later.length = 0) });
  for (const name of ['maps_measure', 'maps_recording']) vm.runInContext(fs.readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), context);
  const { recording } = HL.maps;
  recording.farm = 'Farm';
  const source = { pose: null, isFresh: true, start() {}, stop() {} };
  const hears = (pose) => {
    source.pose = pose;
    later.forEach((run) => run());
  };
  return { HL, recording, source, hears, ends: () => told.pagehide() };
}

// walked at one position a second and metre from one place to another; the clock goes with it
function walk({ hears }, clock, [x1, y1], [x2, y2], from_s) {
  const steps = Math.round(Math.hypot(x2 - x1, y2 - y1));
  for (let i = 0; i <= steps; i += 1) {
    clock.ms += 1000;
    hears(place(x1 + ((x2 - x1) * i) / steps, y1 + ((y2 - y1) * i) / steps, from_s + i));
  }
  return from_s + steps;
}

function begun(store = new Map(), clock = { ms: 1e12 }) {
  const one = page(store, clock);
  one.recording.listen(one.source);
  one.source.isFresh = false;
  one.recording.begin({ kind: 'parcel', robot: 'weeder-07', name: 'Weeder 07' });
  one.source.isFresh = true;
  return { ...one, store, clock };
}

test('positions are taken without a picture being painted, each once', () => {
  const one = begun();
  walk(one, one.clock, [0, 0], [30, 0], 100);
  one.hears(one.source.pose);
  assert.equal(one.recording.heard.length, 31);
  assert.equal(one.recording.gaps.length, 0);
  assert.equal(one.HL.isWalking, true);
});

test('a stretch without positions is told and the picture breaks there', () => {
  const one = begun();
  walk(one, one.clock, [0, 0], [30, 0], 100);
  one.clock.ms += 115000;
  walk(one, one.clock, [50, 0], [80, 0], 245);
  const [gap] = one.recording.gaps;
  assert.equal(one.recording.gaps.length, 1);
  assert.equal(gap.seconds, 115);
  assert.ok(Math.abs(gap.metres - 20) < 0.1);
  assert.equal(one.recording.breaks.size, 1);
  assert.deepEqual([...one.recording.points[[...one.recording.breaks][0]]], [...gap.end]);
});

test('one missed second is no gap, some metres in a few seconds are', () => {
  const { gapBetween } = begun().HL.maps;
  assert.equal(gapBetween(place(0, 0, 0), place(6, 0, 2)), null);
  assert.ok(gapBetween(place(0, 0, 0), place(6, 0, 3)));
  assert.ok(gapBetween(place(0, 0, 0), place(0, 0, 6)));
  assert.equal(gapBetween(place(0, 0, 0), place(2, 0, 4)), null);
});

test('what was heard outlives the page, and goes on there on a clock that begins anew', () => {
  const first = begun();
  walk(first, first.clock, [0, 0], [30, 0], 5000);
  first.ends();
  first.clock.ms += 40000;
  const one = page(first.store, first.clock);
  assert.equal(one.recording.recall(), true);
  assert.deepEqual([one.recording.isOn, one.recording.isPaused, one.recording.robot, one.recording.kind], [false, true, 'weeder-07', 'parcel']);
  assert.equal(one.recording.heard.length, 31);
  assert.equal(one.recording.gaps.length, 0);
  one.recording.listen(one.source);
  one.source.isFresh = false;
  one.recording.goOn();
  one.source.isFresh = true;
  walk(one, first.clock, [50, 0], [60, 0], 3); // counts from another start
  assert.equal(one.recording.gaps.length, 1);
  assert.ok(Math.abs(one.recording.gaps[0].seconds - 41) < 0.5);
  const times = [...one.recording.heard].map((position) => position.at_s);
  assert.deepEqual(times, [...times].sort((a, b) => a - b));
});

test('what was finished, thrown away or is of yesterday is not offered', () => {
  const done = begun();
  walk(done, done.clock, [0, 0], [30, 0], 0);
  done.ends();
  assert.ok(done.store.size);
  done.recording.end();
  assert.equal(done.store.size, 0);
  assert.equal(done.HL.isWalking, false);
  assert.equal(page(done.store, done.clock).recording.recall(), false);
  const old = begun();
  walk(old, old.clock, [0, 0], [30, 0], 0);
  old.ends();
  old.clock.ms += 13 * 3600000;
  assert.equal(page(old.store, old.clock).recording.recall(), false);
  assert.equal(old.store.size, 0);
});

test('a walk that stands still or goes on for hours stays small in the store', () => {
  const one = begun();
  for (let i = 0; i < 1000; i += 1) one.hears(place(0, 0, i * 0.25));
  assert.ok(one.recording.kept.length <= 126);
  for (let i = 0; i < 40000; i += 1) one.recording.take(place(i, 0, 250 + i));
  assert.equal(one.recording.heard.length, 41000);
  assert.equal(one.recording.kept.length, 30000);
});

test('a receiver that fell silent before the end is told', () => {
  const one = begun();
  walk(one, one.clock, [0, 0], [30, 0], 0);
  assert.equal(one.recording.ending(true).length, 0);
  one.clock.ms += 60000;
  const [line] = one.recording.ending(false);
  assert.deepEqual([line.end, line.seconds], [null, 60]);
  const [ring] = one.recording.ending(true);
  assert.ok(Math.abs(ring.metres - 30) < 0.1);
});
