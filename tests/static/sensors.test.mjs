// Field stations without a page: ages that run on, whose word counts, gaps, scales, limits and units.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const chosen = { speed: 'm/s', temperature: '°C' };
const HL = { preferences: { get: (key) => chosen[key] } };
const context = vm.createContext({ HL, Date, Intl });
for (const name of ['sensor_rules', 'sensor_scale', 'sensor_units']) vm.runInContext(fs.readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), context);
const { sensorRules: R, sensorScale: C, sensorUnits: U } = HL;
const plain = (value) => JSON.parse(JSON.stringify(value));

const value = (key, more = {}) => ({ key, quantity: key.split('@')[0], depth_m: key.includes('@') ? Number(key.split('@')[1]) : null, value: 1, unit: '', age_s: 5, state: 'fresh', is_over: false, ...more });
const station = (id, values, more = {}) => ({ id, name: id, kind: 'soil', is_accepted: true, period_s: 60, age_s: 5, state: 'fresh', values, ...more });

test('an age runs on between two answers, never backwards, and what was never heard has none', () => {
  assert.equal(R.ageS(12, 3), 15);
  assert.equal(R.ageS(12, -3), 12);
  assert.equal(R.ageS(null, 3), null);
  assert.equal(R.ageS(NaN, 3), null);
});

test('a state is the older of what the server said and what the age says now', () => {
  assert.equal(R.stateNow('fresh', 89, 60), 'fresh');
  assert.equal(R.stateNow('fresh', 91, 60), 'late');
  assert.equal(R.stateNow('fresh', 179, 60), 'late');
  assert.equal(R.stateNow('fresh', 181, 60), 'silent');
  assert.equal(R.stateNow('fresh', 1801, 3600), 'fresh'); // an hourly camera
  assert.equal(R.stateNow('silent', 3, 60), 'silent'); // the server may know more than an age
  assert.equal(R.stateNow('fresh', null, 60), 'never');
  assert.equal(R.stateNow('late', 5000, undefined), 'late'); // without a period only the server can tell
});

test('now is by the server, whatever the clock of the tablet', () => {
  assert.equal(R.nowMs('2026-05-20T12:00:00Z', 30), Date.parse('2026-05-20T12:00:30Z'));
  assert.equal(R.nowMs('2026-05-20T12:00:00Z', -30), Date.parse('2026-05-20T12:00:00Z'));
  assert.ok(Math.abs(R.nowMs(undefined, 3) - Date.now()) < 1000 && Math.abs(R.nowMs('2026-05-20T12:00:00Z', Infinity) - Date.now()) < 1000);
});

test('a forecast is measured against what treatment waits for, not against limits that only warn', () => {
  const wind = (high, is_treatment, more = {}) => station(`w${high}`, [value('wind_speed', { limit: { low: null, high, is_treatment } })], more);
  assert.deepEqual(plain(R.treatmentLimits([wind(5, true), wind(4, true), wind(2, false), wind(1, true, { is_accepted: false })], ['wind_speed', 'rain_rate'])), { wind_speed: 4 });
});

test('stations and their values age without an answer', () => {
  const [one] = R.aged([station('soil-01', [value('soil_moisture@0.10')])], 200);
  assert.equal(one.age, 205);
  assert.equal(one.state, 'silent');
  assert.equal(one.values[0].state, 'silent');
  const [never] = R.aged([station('soil-02', [], { age_s: null, state: 'never' })], 200);
  assert.deepEqual([never.age, never.state], [null, 'never']);
});

test('one tile for each quantity and depth, in the order people look for them', () => {
  const weather = station('weather', [value('radiation'), value('wind_gust'), value('wind_speed'), value('wind_bearing'), value('air_temperature')], { kind: 'weather' });
  const soil = station('soil', [value('soil_moisture@0.60'), value('soil_moisture@0.10'), value('soil_temperature@0.10')]);
  const all = R.aged([soil, weather], 0);
  assert.deepEqual(plain(R.tiles(all, null).map((one) => one.value.key)), ['air_temperature', 'wind_speed', 'radiation', 'soil_moisture@0.10', 'soil_moisture@0.60']);
  assert.deepEqual(plain(R.tiles(all, 'weather').map((one) => one.value.key)), ['air_temperature', 'wind_speed', 'wind_gust', 'radiation']);
  assert.deepEqual(plain(R.tiles(all, 'soil').map((one) => one.value.key)), ['soil_moisture@0.10', 'soil_moisture@0.60', 'soil_temperature@0.10']);
});

test('of several stations the one that reports counts, first the one over its limit; a new one never speaks for the farm', () => {
  const key = 'soil_moisture@0.10';
  const all = R.aged([
    station('a-silent', [value(key, { age_s: 9000, is_over: true })], { age_s: 9000 }),
    station('b-fresh', [value(key)]),
    station('c-over', [value(key, { is_over: true })]),
    station('0-new', [value(key, { is_over: true })], { is_accepted: false }),
  ], 0);
  const [tile] = R.tiles(all, null);
  assert.equal(tile.station.id, 'c-over');
  assert.equal(tile.all.length, 3);
  assert.equal(R.tiles(all.slice(0, 2), null)[0].station.id, 'b-fresh');
  assert.equal(R.tiles(all, '0-new')[0].station.id, '0-new');
});

test('the bar shows where a value stands within its limit, and nothing without a number', () => {
  assert.deepEqual(plain(R.bar(value('wind_speed', { value: 3, limit: { low: null, high: 6 } }))), { ptr: 20, ok: [0, 40], limits: [40] });
  assert.equal(R.bar(value('wind_speed', { value: 300 })).ptr, 100);
  assert.equal(R.bar(value('wind_speed', { value: null })), null);
  assert.equal(R.bar(value('something_else', { value: 3 })), null);
});

test('no weather is said with the time of the last word, only when no accepted weather station reports', () => {
  const heard = (state, utc, more) => ({ kind: 'weather', is_accepted: true, state, heard_utc: utc, ...more });
  const at = (date) => date.toISOString().slice(11, 16);
  assert.equal(R.weatherProblem([heard('silent', '2026-05-20T13:10:00Z'), heard('silent', '2026-05-20T12:00:00Z')], at), 'No weather since 13:10. Rain stop may be late.');
  assert.equal(R.weatherProblem([heard('silent', '2026-05-20T13:10:00Z'), heard('late', '2026-05-20T13:30:00Z')], at), null);
  assert.equal(R.weatherProblem([heard('silent', '2026-05-20T13:10:00Z'), heard('fresh', '2026-05-20T13:30:00Z', { is_accepted: false })], at), 'No weather since 13:10. Rain stop may be late.');
  assert.equal(R.weatherProblem([heard('never', null)], at), 'No weather was heard yet. Rain stop may be late.');
  assert.equal(R.weatherProblem([{ kind: 'soil', is_accepted: true, state: 'silent' }], at), null);
});

test('a gate of an old answer is not known, whatever it said', () => {
  const gate = { state: 'open', sentence: 'Good', facts: [{ label: 'Wind', text: '3.4 m/s', ok: true }] };
  assert.equal(R.gateNow(gate, 29, '13:10').state, 'open');
  const old = R.gateNow(gate, 31, '13:10');
  assert.deepEqual([old.state, old.facts[0].ok], ['unknown', null]);
  assert.match(old.sentence, /since 13:10/);
  assert.equal(R.gateNow(null, 1, '13:10').state, 'unknown');
});

test('a notice that is not confirmed is never worded as known', () => {
  const text = 'Treatment on Polder 17';
  assert.equal(R.noticeWords({ state: 'acknowledged', text }), `Knows: ${text}`);
  for (const state of ['sent', 'refused', 'unconfirmed']) assert.doesNotMatch(R.noticeWords({ state, text }), /^Knows/);
  assert.equal(R.noticeWords({ state: 'none', text }), '');
  assert.equal(R.noticeWords(null), '');
});

test('typed numbers: a comma is a point, nothing is null, everything else is wrong', () => {
  assert.equal(R.number(' 5,2 '), 5.2);
  assert.equal(R.number('-0.3'), -0.3);
  assert.equal(R.number(''), null);
  for (const wrong of ['5.2.1', 'abc', '1e9', 'Infinity', '5 m/s', '.']) assert.ok(Number.isNaN(R.number(wrong)), wrong);
});

test('the compass says where the wind comes from', () => {
  assert.deepEqual([0, 44, 46, 225, 359, -90, 720].map(R.compass), ['N', 'NE', 'NE', 'SW', 'N', 'W', 'N']);
});

test('the summary counts what does not report and what waits to be accepted', () => {
  const of = (state, is_accepted = true) => ({ state, is_accepted });
  assert.equal(R.summary([of('fresh')]), '1 station');
  assert.equal(R.summary([of('fresh'), of('silent'), of('never'), of('late'), of('fresh', false)]), '4 stations, 1 late, 1 silent, 1 never heard, 1 new');
});

const T0 = Date.parse('2026-05-20T12:00:00Z');
const point = (minutes, mean, low = mean, high = mean) => [new Date(T0 + minutes * 60000).toISOString(), mean, low, high];

test('nothing is joined over a gap, said or only missing; a lone point stays alone', () => {
  const points = C.read([point(0, 1), point(10, 2), point(20, null), point(30, 3), point(60, 4), point(70, 5)]);
  assert.deepEqual(plain(C.runs(points, 600).map((run) => run.map((one) => one.mean))), [[1, 2], [3], [4, 5]]);
  assert.deepEqual(plain(C.runs(C.read([point(0, 1), point(12, 2)]), 600).map((run) => run.length)), [2]); // a little late is no gap
  assert.deepEqual(plain(C.runs([], 600)), []);
});

test('points come in order, and what has no time is left out', () => {
  assert.deepEqual(plain(C.read([point(10, 2), ['nonsense', 5, 5, 5], point(0, 0)]).map((one) => one.mean)), [0, 2]);
});

test('a scale has round numbers, holds the limits that are near, and leaves far ones at its edge', () => {
  const points = C.read([point(0, 3, 2.2, 3.8), point(10, 4, 3, 4.6)]);
  const near = C.scale(points, { low: null, high: 5 }, { isFloored: true });
  assert.ok(near.low === 0 && near.high >= 5);
  assert.deepEqual(plain(C.limitLines({ low: null, high: 5 }, near, (one) => `${one} m/s`)), [{ value: 5, at: 5, beyond: '', text: 'Limit 5 m/s' }]);
  const far = C.scale(points, { low: null, high: 90 }, { isFloored: true });
  assert.ok(far.high < 10);
  const [line] = C.limitLines({ low: null, high: 90 }, far, (one) => `${one} m/s`);
  assert.deepEqual([line.at, line.beyond, line.text], [far.high, 'above', 'Limit 90 m/s, above this scale']);
  assert.equal(C.limitLines({ low: -4, high: null }, near, String)[0].beyond, 'below');
});

test('marks that stand apart read apart', () => {
  assert.deepEqual([2.5, 10, 0.5, 0.25, 25, 0.002, 0.1 + 0.2].map(C.digits), [1, 0, 1, 2, 0, 3, 1]);
});

test('a scale of equal values, of none, and below zero is one that can be drawn', () => {
  for (const [points, how] of [[C.read([point(0, 0), point(10, 0)]), { isFloored: true }], [[], {}], [C.read([point(0, -7.5), point(10, -7.5)]), {}], [C.read([point(0, 1e-4)]), {}]]) {
    const { low, high, ticks } = C.scale(points, {}, how);
    assert.ok(high > low && ticks.length >= 2 && ticks.length < 20, JSON.stringify([low, high, ticks]));
    for (const one of points) assert.ok(one.low >= low && one.high <= high);
  }
});

test('the times along the foot are whole hours or days and do not crowd', () => {
  for (const [hours, wide] of [[24, 300], [24, 1200], [168, 600], [24 * 120, 700]]) {
    const marks = C.times(T0, T0 + hours * 3600000, wide);
    assert.ok(marks.length >= 2 && marks.length <= wide / 64 + 1, `${hours} h: ${marks.length}`);
    for (const { t } of marks) assert.equal(new Date(t).getMinutes(), 0);
  }
});

test('treatments are cut at the edges, and one that goes on lasts until now', () => {
  const utc = (minutes) => new Date(T0 + minutes * 60000).toISOString();
  const found = C.bands([{ from_utc: utc(-60), to_utc: utc(10), text: 'a' }, { from_utc: utc(50), to_utc: null, text: 'b' }, { from_utc: utc(-90), to_utc: utc(-70), text: 'c' }], T0, T0 + 3600000);
  assert.deepEqual(plain(found.map((one) => [one.text, (one.from - T0) / 60000, (one.to - T0) / 60000, one.isOpen])), [['a', 0, 10, false], ['b', 50, 60, true]]);
});

test('under a finger lies the nearest value, and in a gap nothing', () => {
  const points = C.read([point(0, 1), point(10, 2), point(60, 3)]);
  assert.equal(C.under(points, T0 + 7 * 60000, 600).point.mean, 2);
  assert.equal(C.under(points, T0 + 35 * 60000, 600).gap, true);
  assert.equal(C.under([], T0, 600), null);
  assert.equal(C.beyond(points, T0 + 600000, 1).mean, 3); // keys step over a gap
  assert.equal(C.beyond(points, T0, -1), null);
});

test('units follow the person, in sentences too, where a limit is in the unit of its value', () => {
  assert.equal(U.words(6.1, 'm/s'), '6.1 m/s');
  assert.equal(U.sentence('Wind 6.1 m/s, limit 5.0: waits'), 'Wind 6.1 m/s, limit 5.0: waits');
  Object.assign(chosen, { speed: 'km/h', temperature: '°F' });
  assert.equal(U.words(5, 'm/s'), '18.0 km/h');
  assert.equal(U.words(20, '°C', 0), '68 °F');
  assert.equal(U.sentence('Wind 6.1 m/s, limit 5.0: waits'), 'Wind 22.0 km/h, limit 18.0: waits');
  assert.equal(U.sentence('Air 10 °C.'), 'Air 50.0 °F.');
  assert.equal(U.words(3, 'mm/h'), '3.0 mm/h');
  assert.equal(U.words(null, 'm/s'), '––');
  Object.assign(chosen, { speed: 'm/s', temperature: '°C' });
});

test('the name of a limit stands where it covers the fewest values, at the right end if that is free', () => {
  const room = { feet: [60, 90], left: 0, right: 400, wide: 100, high: 20 };
  const along = (from, to, y = 50) => Array.from({ length: (to - from) / 10 }, (_, i) => ({ x: from + i * 10, y }));
  const at = (dots) => plain(C.freest(dots, room));
  assert.deepEqual(at([]), { x: 300, foot: 60 });
  assert.deepEqual(at(along(300, 400)), { x: 0, foot: 60 }); // the newest values stay in sight
  assert.deepEqual(at([...along(290, 400), ...along(0, 60)]), { x: 75, foot: 60 });
  assert.deepEqual(at(along(0, 400)), { x: 300, foot: 90 }); // on the other side of the line
  assert.deepEqual(at(along(0, 400, 110)), { x: 300, foot: 60 }); // far below
});
