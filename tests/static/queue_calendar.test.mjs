// The week of the queue: a job comes again on the days that the console's own rule says.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import vm from 'node:vm';
import { test } from 'node:test';

const HL = { el: () => ({}), icon: () => ({}), queue: {} };
for (const one of ['queue_data', 'queue_calendar']) vm.runInNewContext(fs.readFileSync(new URL(`../../static/js/ui/${one}.js`, import.meta.url), 'utf8'), { HL });
const { comesAgain, calendarDays } = HL.queue;
const week = ['2026-06-15', '2026-06-16', '2026-06-17', '2026-06-18', '2026-06-19', '2026-06-20', '2026-06-21', '2026-06-22']; // from a Monday
const again = (rule, first = '2026-06-15') => week.filter((date) => comesAgain(rule, first, date)).map((date) => Number(date.slice(8)));

test('each rule names its days, never the first one again', () => {
  assert.deepEqual(again({ kind: 'daily', days: [], every_days: 1, until: null }), [16, 17, 18, 19, 20, 21, 22]);
  assert.deepEqual(again({ kind: 'workdays', days: [], every_days: 1, until: null }), [16, 17, 18, 19, 22]);
  assert.deepEqual(again({ kind: 'weekly', days: [0, 5], every_days: 1, until: null }), [20, 22]);
  assert.deepEqual(again({ kind: 'every_n_days', days: [], every_days: 3, until: null }), [18, 21]);
  assert.deepEqual(again(null), []);
});

test('a rule ends with its last day, and nothing comes before its first', () => {
  assert.deepEqual(again({ kind: 'daily', days: [], every_days: 1, until: '2026-06-17' }), [16, 17]);
  assert.deepEqual(again({ kind: 'daily', days: [], every_days: 1, until: null }, '2026-06-20'), [21, 22]);
});

test('days are counted through a change of the clocks', () => {
  const rule = { kind: 'every_n_days', days: [], every_days: 2, until: null };
  assert.equal(comesAgain(rule, '2026-10-24', '2026-10-26'), true);
  assert.equal(comesAgain(rule, '2026-10-24', '2026-10-25'), false);
});

test('a job that runs since yesterday stands in the cell of today', () => {
  const now = Date.parse('2026-06-15T06:00Z');
  const entry = { id: 'a', robot_id: 'r', mission_id: 'm', name: 'Night', state: 'open', status: 'running', started_utc: '2026-06-14T20:00Z', earliest_utc: null, repeat: null };
  const days = calendarDays({ entries: [entry], ended: [], blackouts: [], zone: 'UTC' }, { robot_id: 'r' }, now, Date.parse('2026-06-15'));
  assert.equal(days.map((one) => one.rows.map((row) => `${one.date} ${row.told} ${row.name}`)).flat().join(), '2026-06-15 now Night');
});

const told = (robot, entries = []) => calendarDays({ entries, ended: [], blackouts: [], zone: 'UTC' }, robot, Date.parse('2026-06-15T06:00Z'), Date.parse('2026-06-15'))
  .flatMap((one) => one.rows.map((row) => `${Number(one.date.slice(8))} ${row.told} ${row.name}`)).join(', ');

test('a job of days stands on each of them, one that is paused only where it stands', () => {
  const now = { mission_id: 'm', name: 'Trees', status: 'running', remaining_s: 54 * 3600 };
  assert.equal(told({ robot_id: 'r', now }), '15 now Trees, 16 goes on Trees, 17 to about 12:00 Trees');
  assert.equal(told({ robot_id: 'r', now: { ...now, status: 'paused' } }), '15 now Trees, paused');
  const waits = { id: 'b', robot_id: 'r', mission_id: 'n', name: 'Weeds', state: 'open', status: 'queued', duration_s: 8 * 3600, earliest_utc: '2026-06-18T20:00Z', repeat: null };
  assert.equal(told({ robot_id: 'r' }, [waits]), '18 20:00 Weeds, 19 to about 04:00 Weeds');
});
