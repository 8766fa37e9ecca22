// What a page asks the live lane for, and how it keeps control of many robots alive.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const ME = { session: 's-1' };
const BURST = 120; // frames the console takes from one page at once, hmi/live/lane.py
const many = (count) => Array.from({ length: count }, (_, i) => `weeder-${i}`);

// a page over a lane that only takes note; every timer is run by hand
function page({ held = [], screen = 'operate', robot = 'weeder-900', answer = { ok: true } } = {}) {
  const subs = [];
  const sent = [];
  const timers = [];
  const lane = { state: () => undefined, age: () => null, tick: () => 'tick-1', sub: (topics) => subs.push([...topics]), on() {}, send: (frame) => sent.push(frame), api: async () => answer, uuid: () => 'u-1' };
  const keep = { read: (key, otherwise) => (key.startsWith('headland.held') ? held : otherwise), write() {} };
  const HL = { config: { user: { id: 'martha' }, session: ME.session, rights: [] }, keep, repaint() {}, view: { screen, robot }, maps: {} };
  const context = vm.createContext({ HL, window: { headland: lane, addEventListener() {} }, performance, setTimeout, setInterval: (run) => timers.push(run), navigator: {} });
  const load = (name) => vm.runInContext(fs.readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8'), context);
  load('port');
  return { HL, load, sent, topics: () => subs.at(-1), second: () => timers.forEach((run) => run()) };
}

test('what the screen looks into is asked for however many robots are held', () => {
  const { HL, topics } = page({ held: many(60), screen: 'supervisor' });
  HL.port.watch();
  assert.equal(topics().length, 40);
  assert.ok(topics().includes('inside/weeder-900'));
  assert.ok(topics().includes('robot/weeder-900'));
});

test('a walk keeps its robot while other screens watch theirs and leave', () => {
  const { HL, load, topics } = page();
  load('maps_receiver');
  new HL.maps.RobotReceiver('weeder-7').start();
  HL.port.follow('weeder-8', 'plan');
  assert.ok(['robot/weeder-7', 'robot/weeder-8'].every((one) => topics().includes(one)));
  HL.port.follow(null, 'plan');
  HL.port.follow(null, 'wall');
  assert.ok(topics().includes('robot/weeder-7'));
  assert.ok(!topics().includes('robot/weeder-8'));
  new HL.maps.RobotReceiver('weeder-7').stop();
  assert.ok(!topics().includes('robot/weeder-7'));
});

test('control of one robot is told at once', () => {
  const { HL, sent } = page();
  HL.port.noteLease('weeder-1', ME);
  assert.deepEqual(sent.map((one) => [...one.robots]), [['weeder-1']]);
});

test('control of hundreds is kept alive from the next round on, in no more frames than the console takes', async () => {
  const robots = many(300);
  const results = robots.map((robot) => ({ robot, outcome: 'accepted', text: '', owner: ME }));
  const one = page({ answer: { ok: true, results } });
  one.HL.fleet = {};
  one.load('fleet_results');
  await one.HL.fleetOrders.act('return_home', robots);
  one.second();
  assert.ok(one.sent.length < BURST);
  assert.equal(new Set(one.sent.slice(-3).flatMap((frame) => [...frame.robots])).size, 300);
});

test('a robot that somebody else has is not kept', async () => {
  const one = page({ answer: { ok: true, results: [{ robot: 'weeder-1', outcome: 'rejected', owner: { session: 's-2' } }] } });
  one.HL.fleet = {};
  one.load('fleet_results');
  await one.HL.fleetOrders.act('return_home', ['weeder-1']);
  one.second();
  assert.deepEqual(one.sent, []);
});
