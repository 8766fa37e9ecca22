// Rules of the screens for missions, queue and supervisor that need no page.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

// a script of the bundle on a bare HL; gives HL back
function load(names, HL) {
  const world = vm.createContext({ HL, Intl, Date, window: {}, ResizeObserver: class { observe() {} }, Event });
  for (const name of names) vm.runInContext(readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), world);
  return HL;
}

const bare = () => ({ el: () => ({}), icon: () => ({}), attr: () => {}, text: () => {}, planner: { NAMES: {} } });

test('the first offer of a working width is what the tool takes, in whole rows of the field', () => {
  const { usualWidth } = load(['plan_inputs'], bare()).planner;
  assert.equal(usualWidth(1.5, 0.5), 1.5);
  assert.equal(usualWidth(4, 0.45), 3.6);
  assert.equal(usualWidth(1.5, 0.7), 1.4);
  assert.equal(usualWidth(1.5, 2.5), 1.5);
  assert.equal(usualWidth(1.5, undefined), 1.5);
  assert.equal(usualWidth(null, 0.2), 0.5);
  assert.equal(usualWidth(null, undefined), null);
});

test('the first offer of headland laps is what the headland on the map takes', () => {
  const { Inputs, usualLaps } = load(['plan_inputs'], bare()).planner;
  assert.deepEqual([usualLaps(9, 3), usualLaps(10, 3), usualLaps(1, 3), usualLaps(100, 0.5)], ['3', '3', '1', '50']);
  assert.deepEqual([usualLaps(undefined, 3), usualLaps(0, 3), usualLaps(9, NaN)], ['', '', '']);
  const inputs = Object.assign(Object.create(Inputs.prototype), {
    places: { fields: [{ id: 'a', properties: { headland_m: 12 } }, { id: 'b', properties: {} }] },
    all: { field_id: { value: 'a' }, width_m: { value: '3' }, headland_passes: { value: '' } },
  });
  const offered = (field, width) => {
    Object.assign(inputs.all, { field_id: { value: field }, width_m: { value: width } });
    inputs.offerLaps();
    return inputs.all.headland_passes.value;
  };
  assert.deepEqual([offered('a', '3'), offered('a', '6'), offered('b', '6'), offered('a', '4')], ['4', '2', '', '3']);
  inputs.all.headland_passes.value = '1';
  assert.deepEqual([offered('a', '3'), offered('b', '3')], ['1', '1']);
});

test('a UAV is offered no headland laps, and flies home', () => {
  let family = 'weeder';
  const word = {};
  const hl = { ...bare(), text: (node, value) => (node.word = value), port: { fleet: () => ({ r: { family } }) } };
  const { Inputs } = load(['plan_inputs'], hl).planner;
  const inputs = Object.assign(Object.create(Inputs.prototype), {
    places: { fields: [{ id: 'a', properties: { headland_m: 12 } }], robots: [] },
    all: { robot_id: { value: 'r' }, field_id: { value: 'a' }, width_m: { value: '3' }, headland_passes: { value: '' } },
    spacing: {}, wayBack: word,
  });
  const offered = (kind) => {
    family = kind;
    inputs.offerSpacing();
    inputs.offerLaps();
    return [inputs.all.headland_passes.value, word.word];
  };
  assert.deepEqual(offered('weeder'), ['4', 'Drive home at the end']);
  assert.deepEqual(offered('uav'), ['', 'Fly home at the end']);
  assert.deepEqual(offered('planter'), ['4', 'Drive home at the end']);
});

test('headland laps that were offered follow the field after a reload too, entered ones stay', () => {
  const kept = {};
  const draft = { get: (key) => kept[key], set: (key, value) => (kept[key] = JSON.parse(JSON.stringify(value))) };
  const { Inputs } = load(['plan_inputs'], { ...bare(), draft }).planner;
  const opened = () => {
    const inputs = Object.assign(Object.create(Inputs.prototype), {
      places: { fields: [{ id: 'a', properties: { headland_m: 12 } }, { id: 'b', properties: {} }] },
      all: { field_id: { value: 'a' }, width_m: { value: '3' }, headland_passes: { value: '' } },
      fill: (values) => Object.entries(values).forEach(([key, value]) => key in inputs.all && (inputs.all[key].value = value)),
    });
    inputs.recall();
    return inputs;
  };
  const first = opened();
  first.offerLaps();
  first.keep();
  const again = opened();
  assert.equal(again.all.headland_passes.value, '4');
  again.all.field_id.value = 'b';
  again.offerLaps();
  assert.equal(again.all.headland_passes.value, '');
  again.all.headland_passes.value = '2';
  again.keep();
  const last = opened();
  last.all.field_id.value = 'a';
  last.offerLaps();
  assert.equal(last.all.headland_passes.value, '2');
});

test('robots with nothing to show come after the others and in their own list', () => {
  const { split } = load(['queue_data'], { port: {} }).queue;
  const robot = (robot_id, more = {}) => ({ robot_id, ...more });
  const queue = {
    robots: [robot('a'), robot('b'), robot('c', { now: { name: 'x' } }), robot('d', { arming: {} }), robot('e'), robot('f', { holds: {} })],
    entries: [{ robot_id: 'b' }],
    ended: [{ robot_id: 'e', started_utc: '2026-01-01T00:00:00Z', state: 'removed' }],
  };
  assert.deepEqual(Array.from(split(queue), (list) => Array.from(list, (one) => one.robot_id)), [['b', 'd', 'f', 'c'], ['a', 'e']]);
});

test('a name that does not fit stands beside its bar only where the row is free behind it', () => {
  const { isSlim } = load(['queue_timeline'], { ...bare(), queue: {} }).queue;
  const bar = { from: 100, to: 220 };
  assert.equal(isSlim(bar, 160, 500), true);
  assert.equal(isSlim(bar, 160, 390), false); // another bar is too near
  assert.equal(isSlim(bar, 100, 500), false); // it fits
});

test('the clock of the farm is named as people write it', () => {
  const { zoneName } = load(['queue_data'], { port: {} }).queue;
  assert.deepEqual(['Etc/UTC', 'UTC', 'Europe/Amsterdam'].map(zoneName), ['UTC', 'UTC', 'Europe/Amsterdam']);
});

test('one finger moves the chart only when there is more of it than is in sight, and never out of sight', () => {
  const attrs = {};
  const HL = load(['super_view'], { ...bare(), attr: (_, name, value) => (attrs[name] = value) });
  const root = { addEventListener: () => {}, getBoundingClientRect: () => ({ width: 100, height: 100, left: 0, top: 0 }), setPointerCapture: () => {} };
  const view = new HL.SuperView(root, () => {});
  view.fit([200, 200]);
  assert.equal(attrs['data-near'], false);
  view.zoom(0.5);
  assert.equal(attrs['data-near'], true);
  view.pan(10000, -10000);
  assert.deepEqual([view.box.x + view.box.w / 2, view.box.y + view.box.h / 2], [200, 0]);
});

test('who waits for a plan sees how long, how far, and how to end it', () => {
  const { planningWords } = load(['plan_numbers'], { ...bare(), planner: { NAMES: { shortest: 'Shortest', spiral: 'Spiral' } }, words: {} }).planner;
  assert.equal(planningWords('shortest', 0, 1), 'Planning shortest');
  assert.equal(planningWords('shortest', 1, 4), 'Planning shortest, 4 s. 1 of 2 row orders are done.');
  assert.match(planningWords('shortest', 1, 12), /12 s.*up to a minute each; Cancel planning ends it at once/);
});

test('a time just below an hour is told as that hour', () => {
  const { hours } = load(['plan_numbers'], { ...bare(), planner: { NAMES: {} }, words: {} }).planner;
  assert.deepEqual([3575, 7175, 3600, 3540, 0].map(hours), ['1:00', '2:00', '1:00', '0:59', '0:00']);
});

test('a kept view of the fleet says what it keeps', () => {
  const HL = load(['fleet_filter'], { ...bare(), toggle: () => {}, fleet: { groups: [{ id: 7, name: 'North' }] }, fleetOrder: { FAMILIES: { weeder: 'Weeders' } } });
  assert.equal(HL.fleetFilterWords({ q: '', sort: 'attention', families: [], group: '', mine: false, state: '' }), 'all robots');
  assert.equal(HL.fleetFilterWords({ q: 'ha', sort: 'name', families: ['weeder'], group: 7, mine: true, state: 'offline' }), 'mine, weeders, no link, group North, “ha”, by name');
});
