// Where the states of a chart stand and how the lines between them run: rules that hold for any chart.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const read = (name) => readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8');
for (const name of ['chart_placing', 'chart_routing', 'super_chart_facts', 'super_gantt_rows']) vm.runInThisContext(read(name)); // another context looks every global up by name, six times slower
const { chartLayout, chartFacts, ganttRows } = globalThis.HLC;
const planter = JSON.parse(readFileSync(new URL('../charts/planter.json', import.meta.url), 'utf8'));
const plain = (value) => JSON.parse(JSON.stringify(value));
const widthsOf = (chart) => Object.fromEntries(chart.states.map((s) => [s.id, s.label.length * 8 + 24]));
const WINDOWS = [{ w: 1140, h: 486 }, { w: 752, h: 640 }, { w: 1820, h: 900 }];

function random(seed) {
  let x = seed * 2654435761 % 4294967296;
  return (n) => { x = (x * 1664525 + 1013904223) % 4294967296; return Math.floor((x / 4294967296) * n); };
}

// a chart nobody drew by hand: nested, with parallel regions, and transitions across everything
function anyChart(seed, count) {
  const pick = random(seed);
  const states = [];
  const add = (parent, kind) => { const id = `s${states.length}`; states.push({ id, label: `State ${'x'.repeat(pick(14))} ${id}`, parent, kind, is_initial: pick(5) === 0, subsystem: 'A', normal_s: pick(2) ? 5 : null, entry: [], exit: [] }); return id; };
  const fill = (parent, depth) => {
    const many = 2 + pick(7);
    for (let i = 0; i < many && states.length < count; i += 1) {
      const kind = depth > 2 || pick(3) ? 'simple' : pick(3) ? 'composite' : 'parallel';
      const id = add(parent, kind);
      if (kind === 'composite') fill(id, depth + 1);
      if (kind === 'parallel') for (let r = 0; r < 2 + pick(2); r += 1) fill(add(id, 'region'), depth + 1);
    }
  };
  while (states.length < count) fill(null, 0);
  const transitions = Array.from({ length: Math.round(count * 1.4) }, (_, i) => ({ source: states[pick(states.length)].id, target: states[pick(states.length)].id, event: `e${i}`, guard: '' }));
  return { states, transitions };
}

const CHARTS = [['the planter', planter], ...[1, 2, 3, 4].map((seed) => [`chart ${seed}`, anyChart(seed, 16 + seed * 10)])];
const isInside = (a, b) => a.x >= b.x && a.y >= b.y && a.x + a.w <= b.x + b.w && a.y + a.h <= b.y + b.h;
const apart = (a, b) => a.x + a.w <= b.x || b.x + b.w <= a.x || a.y + a.h <= b.y || b.y + b.h <= a.y;

for (const [name, chart] of CHARTS) {
  test(`${name}: every state has a place inside of its parent, and siblings do not overlap`, () => {
    for (const window of WINDOWS) {
      const { places, w, h } = chartLayout(chart, widthsOf(chart), window);
      const at = new Map(places);
      assert.equal(at.size, chart.states.length);
      for (const one of chart.states) {
        const place = at.get(one.id);
        assert.ok(isInside(place, at.get(one.parent) ?? { x: 0, y: 0, w, h }), `${one.id} leaves its parent`);
        assert.ok(place.w >= 0 && place.h >= 0);
        for (const other of chart.states) if (other.id < one.id && other.parent === one.parent) assert.ok(apart(place, at.get(other.id)), `${one.id} over ${other.id}`);
      }
    }
  });

  test(`${name}: every line begins and ends at its states and runs through no other`, () => {
    const { places, ways } = chartLayout(chart, widthsOf(chart), WINDOWS[0]);
    const at = new Map(places);
    const onBorder = ([x, y], p) => x >= p.x && x <= p.x + p.w && y >= p.y && y <= p.y + p.h && (x === p.x || x === p.x + p.w || y === p.y || y === p.y + p.h);
    for (const way of ways.filter((one) => !one.isForced)) {
      assert.ok(onBorder(way.points[0], at.get(way.source)), `${way.source}>${way.target} begins beside it`);
      assert.ok(onBorder(way.points.at(-1), at.get(way.target)), `${way.source}>${way.target} ends beside it`);
      way.points.slice(1).forEach(([x, y], i) => {
        const [px, py] = way.points[i];
        assert.ok(x === px || y === py, 'a slanted line');
        for (const one of chart.states) {
          const p = at.get(one.id);
          if (p.isFrame || p.isRegion || one.id === way.source || one.id === way.target) continue;
          const misses = Math.max(x, px) <= p.x || Math.min(x, px) >= p.x + p.w || Math.max(y, py) <= p.y || Math.min(y, py) >= p.y + p.h;
          assert.ok(misses, `${way.source}>${way.target} runs through ${one.id}`);
        }
      });
    }
    assert.ok(ways.filter((one) => one.isForced).length <= ways.length * 0.03, 'too many lines found no way');
  });
}

test('transitions of the same two states are one line that knows all of them', () => {
  const chart = { states: ['a', 'b'].map((id) => ({ id, label: id, parent: null, kind: 'simple' })), transitions: [{ source: 'a', target: 'b', event: 'x' }, { source: 'a', target: 'b', event: 'y' }, { source: 'a', target: 'a', event: 'z' }] };
  const { ways } = chartLayout(chart, {}, WINDOWS[0]);
  assert.deepEqual(plain(ways.map((one) => one.numbers)), [[0, 1]]);
});

test('charts that make no sense are drawn all the same: parents in a circle, unknown parents, one state alone', () => {
  const one = (id, parent) => ({ id, label: id, parent, kind: 'simple' });
  assert.equal(chartLayout({ states: [one('a', 'b'), one('b', 'a')], transitions: [] }, {}, WINDOWS[0]).places.length, 2);
  assert.equal(chartLayout({ states: [one('a', 'gone')], transitions: [{ source: 'a', target: 'nowhere', event: '' }] }, {}, WINDOWS[0]).places.length, 1);
});

test('parents in a circle are cut open in lists as in the drawing: no state is lost', () => {
  const state = (id, parent) => ({ id, label: id, parent, kind: 'simple', subsystem: 'A', normal_s: null });
  const facts = chartFacts.index({ states: [state('a', 'b'), state('b', 'a'), state('c', 'a'), state('d', 'd')], transitions: [] });
  assert.deepEqual(plain(facts.kids(null).map((one) => one.id)), ['a', 'b', 'd']);
  assert.deepEqual(plain(facts.path('c').map((one) => one.id)), ['a', 'c']);
  assert.ok(chartFacts.isLeaf(facts, 'b') && chartFacts.isLeaf(facts, 'd'));
});

test('a state that its chart does not have goes on in the durations under its own name', () => {
  const facts = chartFacts.index(planter);
  const found = ganttRows.withActive([stay('new-state', 'Other', 5000, null)], facts, [['new-state', 5000], ['newer', 9000]]);
  assert.deepEqual(plain(found.map((one) => [one.state, one.lane, one.start, one.end])), [['new-state', 'Other', 5000, null], ['newer', 'Other', 9000, null]]);
});

test('the same chart in the same window has the same places', () => {
  assert.deepEqual(plain(chartLayout(planter, widthsOf(planter), WINDOWS[0])), plain(chartLayout(planter, widthsOf(planter), WINDOWS[0])));
});

test('how long 100 states take to be laid out', () => {
  const chart = anyChart(9, 100);
  const from = process.cpuUsage();
  const { places } = chartLayout(chart, widthsOf(chart), WINDOWS[0]);
  console.log(`layout of ${chart.states.length} states, ${chart.transitions.length} transitions: ${Math.round(process.cpuUsage(from).user / 1000)} ms of a core`);
  assert.equal(places.length, chart.states.length);
});

test('a state is over its time after half as long again, and two seconds at least', () => {
  assert.equal(chartFacts.isOver(7, 10), false);
  assert.equal(chartFacts.isOver(7, 10.6), true);
  assert.equal(chartFacts.isOver(0.2, 1), false);
  assert.equal(chartFacts.isOver(null, 1e6), false);
});

test('time stands still when nothing is heard', () => {
  assert.equal(chartFacts.seconds(1000, 5000, 500, 2000), 4.5);
  assert.equal(chartFacts.seconds(1000, 5000, 60000, 2000), 6);
});

test('the breadcrumb follows the region that moved last', () => {
  const facts = chartFacts.index(planter);
  const states = ['mission', 'plant-site', 'base', 'hold', 'crane', 'on-ground', 'guard', 'area-clear'].map((id) => [id, 0]);
  assert.deepEqual(plain(chartFacts.crumbs(facts, states, { target: 'on-ground' }).map((one) => one.id)), ['mission', 'plant-site', 'crane', 'on-ground']);
  assert.deepEqual(plain(chartFacts.crumbs(facts, states, null).map((one) => one.id)), ['mission', 'plant-site', 'base', 'hold']);
});

test('times are said as people say them', () => {
  assert.deepEqual(plain([4.2, 59.4, 134, 6720, 59.6].map(chartFacts.span)), ['4 s', '59 s', '2:14', '1 h 52', '1:00']);
});

const stay = (state, lane, start, end, normal_s = null) => ({ state, lane, label: state, subsystem: lane, start, end, normal_s, result: '', path: [] });
const span = { start: 0, end: 100000, width: 1000 };

test('a row for each region in the order of the chart, then the subsystems outside of them', () => {
  const facts = chartFacts.index(planter);
  const found = ganttRows.rows([stay('transit', 'Drive', 0, 10000), stay('dock', 'Crane', 0, 5000), stay('hold', 'Base', 0, 90000)], facts, [], span);
  assert.deepEqual(plain(found.map((row) => row.lane)), ['Base', 'Crane', 'Drive']);
});

test('a stay beyond its usual time is marked, with where it should have ended', () => {
  const [row] = ganttRows.rows([stay('a', 'L', 10000, 30000, 5), stay('b', 'L', 30000, 36000, 5)], null, [], span);
  assert.equal(row.bars[0].isOver, true);
  assert.equal(row.bars[0].planned, 150);
  assert.equal(row.bars[1].isOver, false);
});

test('what is active now is carried on, and what it replaced ends where it begins', () => {
  const facts = chartFacts.index(planter);
  const found = ganttRows.withActive([stay('dock', 'Crane', 10000, null), stay('hold', 'Base', 5000, null)], facts, [['dock-waypoint', 40000], ['hold', 5200]]);
  assert.deepEqual(plain(found.map((one) => [one.state, one.start, one.end])), [['dock', 10000, 40000], ['hold', 5000, null], ['dock-waypoint', 40000, null]]);
});

test('a thousand stays in a row of a hundred pixels become few bars, and what was over its time stays', () => {
  const many = Array.from({ length: 1000 }, (_, i) => stay(i % 2 ? 'a' : 'b', 'L', i * 100, i * 100 + 100, i === 500 ? 0.01 : null));
  many[500].end = many[500].start + 5000;
  const [row] = ganttRows.rows(many, null, [], { ...span, width: 100 });
  assert.ok(row.bars.length < 160, String(row.bars.length));
  assert.equal(row.bars.filter((bar) => bar.isOver).length, 1);
});

test('the axis counts back from now, or says the time of a mission that is over', () => {
  const clock = (at) => `${at / 60000}`;
  assert.deepEqual(plain(ganttRows.axis(0, 600000, true, clock).at(0)), [600000, 'now']);
  assert.deepEqual(plain(ganttRows.axis(0, 600000, true, clock).at(-1)), [0, '−10 min']);
  assert.deepEqual(plain(ganttRows.axis(30000, 630000, false, clock).at(0)), [60000, '1']);
});

test('the states are placed before the lines are found, and stay there', () => {
  let placed = null;
  const whole = chartLayout(planter, widthsOf(planter), WINDOWS[0], (layout) => (placed = plain(layout)));
  assert.deepEqual(placed.places, plain(whole.places));
  assert.deepEqual([placed.w, placed.h, placed.ways], [whole.w, whole.h, []]);
  assert.ok(whole.ways.length > 20);
});

test('what ended between two looks at the record stays in the picture until the record has it', () => {
  const facts = chartFacts.index(planter);
  const kept = ganttRows.memory();
  ganttRows.follow(kept, { t: 10000, states: [['hold', 5000], ['dock', 10000]] });
  ganttRows.follow(kept, { t: 14100, states: [['hold', 5000], ['crane-idle', 14000]] });
  ganttRows.follow(kept, { t: 16100, states: [['hold', 5000], ['above-plant', 16000]] });
  const { active, ended } = ganttRows.onRecord(kept, { now: 20000, now_m: 20000 });
  const found = (recorded) => plain(ganttRows.withActive(recorded, facts, active, ended).map((one) => [one.state, one.start, one.end]));
  assert.deepEqual(found([stay('hold', 'Base', 5000, null)]), [['hold', 5000, null], ['dock', 10000, 14000], ['crane-idle', 14000, 16000], ['above-plant', 16000, null]]);
  assert.deepEqual(found([stay('hold', 'Base', 5000, null), stay('dock', 'Crane', 10100, 13900), stay('crane-idle', 'Crane', 13900, null)]), [['hold', 5000, null], ['dock', 10100, 13900], ['crane-idle', 13900, 16000], ['above-plant', 16000, null]]);
});

test('the record and the reports are put together on the clock of the console, whatever this machine says', () => {
  const facts = chartFacts.index(planter);
  const kept = ganttRows.memory();
  ganttRows.follow(kept, { t: 500, states: [['dock', 100]] });
  ganttRows.follow(kept, { t: 40500, states: [['above-plant', 40100]] });
  const hour = 3600000;
  const { active, ended } = ganttRows.onRecord(kept, { now: hour + 41000, now_m: 41000 });
  const stays = ganttRows.withActive([stay('dock', 'Crane', hour + 100, hour + 40100), stay('above-plant', 'Crane', hour + 40100, null)], facts, active, ended);
  assert.deepEqual(plain(stays.map((one) => [one.state, one.start - hour, one.end && one.end - hour])), [['dock', 100, 40100], ['above-plant', 40100, null]]);
});

test('a state that was entered again is another stay', () => {
  const kept = ganttRows.memory();
  ganttRows.follow(kept, { t: 10000, states: [['hold', 5000]] });
  ganttRows.follow(kept, { t: 20000, states: [['hold', 18000]] });
  assert.deepEqual(plain(kept.ended), [{ state: 'hold', start: 5000, end: 18000 }]);
});

test('a state keeps its tone when the oldest stay leaves the picture', () => {
  const facts = chartFacts.index(planter);
  const stays = ['dock', 'above-plant', 'photo', 'dock', 'retract'].map((id, i) => stay(id, 'Crane', i * 10000, i * 10000 + 9000));
  const toneBy = (list) => Object.fromEntries(ganttRows.rows(list, facts, [], span)[0].bars.map((bar) => [bar.label, bar.tone]));
  const { dock, photo, retract } = toneBy(stays);
  assert.deepEqual(toneBy(stays.slice(2)), { dock, photo, retract });
});
