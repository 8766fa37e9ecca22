// What STOP claims of a robot whose heartbeats go on while its safety controller is silent, without a page.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const read = (name) => fs.readFileSync(new URL(`../../static/js/${name}.js`, import.meta.url), 'utf8');
const ID = 'weeder-07';

// STOP with a gateway that says what the test says, and a slab that remembers its words
function stop(scope = { kind: 'robot', id: ID, name: 'Weeder 07' }) {
  const world = { now: 5000, isFresh: true, said: null };
  const store = { getItem: () => null, setItem() {} };
  const none = { addEventListener() {}, dispatchEvent() {} };
  class GatewaySocket {
    rttMs = 14;
    constructor(told) { world.told = told; }
    isFresh = () => world.isFresh;
    send() {}
    use() {}
    tick() {}
  }
  class Slab {
    draw(one, all, isAll, now) {
      const { words } = window.headlandStopParts;
      world.said = isAll ? words.all(all, now) : words.one(one, now);
      world.one = one;
    }
  }
  const later = () => new Promise(() => {});
  const toConsole = () => (world.asked = (world.asked ?? 0) + 1, world.answer ? Promise.resolve([world.answer()]) : later());
  const window = { ...none, headlandStopParts: { GatewaySocket, Slab, toGateway: later, toConsole } };
  const context = vm.createContext({
    window, document: { ...none, readyState: 'complete', getElementById: () => null }, performance: { now: () => world.now },
    localStorage: store, sessionStorage: store, navigator: {}, location: {}, setTimeout() {}, CustomEvent: class {},
    setInterval: (tick) => (world.tick = tick), crypto: { getRandomValues: (bytes) => bytes.fill(7) },
  });
  for (const name of ['stop_press', 'stop_words', 'stop']) vm.runInContext(read(name), context);
  window.headlandStop.configure({ token: 'token', port: 1, scope });
  // the gateway's heartbeat, `more` of each robot
  world.beat = (...robots) => world.told.beat({ k: 'hb', robots: Object.fromEntries(robots.map(([id, more]) => [id, { name: id, heard_ms: 90, via: 'mqtt', rtt_ms: 5, latched: true, latched_ms: 60000, standstill: true, speed_mps: 0, hardware_stop: false, ...more }])) });
  world.step = (robot, state, more) => world.told.frame({ k: 'step', stop_id: 'press-1', robot, name: robot, state, age_ms: 1400, sent_ms: 1, ack_ms: 180, standstill_ms: 1340, by: 'Martha', ...more });
  world.pass = (ms) => {
    world.now += ms;
    world.tick();
  };
  const robot = (id = ID) => window.headlandStop.state().robots.find((one) => one.id === id);
  const press = () => window.headlandStop.press();
  return { world, robot, press, banner: () => window.headlandStop.banner(), state: () => window.headlandStop.state() };
}

test('standstill is confirmed while the safety controller reports', () => {
  const { world, robot } = stop();
  for (let i = 0; i < 40; i += 1) {
    world.beat([ID, { safety_ms: 190 }]);
    world.pass(250);
    assert.equal(world.said[1], 'Standstill confirmed');
    assert.ok(robot().is_standing);
  }
});

test('heartbeats without a safety report confirm nothing after two seconds', () => {
  const { world, robot, banner, state } = stop();
  for (const safety_ms of [1900, 2100, 12000, 125000]) {
    world.beat([ID, { safety_ms }]);
    world.pass(0);
    const isOld = safety_ms > 2000;
    assert.equal(robot().is_standing, !isOld);
    assert.equal(state().standing, isOld ? 0 : 1);
    assert.equal(world.one.isStanding, !isOld);
    assert.equal(/confirmed/.test(banner().title), !isOld);
  }
  assert.equal(world.said.slice(0, 3).join('|'), 'STOPPED|Standstill 2:05 ago|safety controller silent');
  assert.equal(banner().title, 'Stopped. Standstill told 2:05 ago');
  world.beat([ID, { safety_ms: 12000 }]);
  assert.equal(world.said[1], 'Standstill 12 s ago');
  world.beat([ID, { safety_ms: 100 }]);
  assert.equal(world.said[1], 'Standstill confirmed');
});

test('between two heartbeats the age of the report runs on in the browser', () => {
  const { world, robot } = stop();
  world.beat([ID, { safety_ms: 1500 }]);
  world.pass(400);
  assert.ok(robot().is_standing);
  world.pass(200);
  assert.ok(!robot().is_standing);
});

test('a confirmation is as good as a report, also before the next heartbeat tells of it', () => {
  const { world, robot } = stop();
  world.beat([ID, { safety_ms: 9000, latched: false, standstill: false }]);
  world.step(ID, 'standstill');
  assert.equal(world.said[1], 'Standstill confirmed');
  assert.ok(robot().is_standing);
  world.beat([ID, { safety_ms: 3000 }]);
  world.pass(2100);
  assert.ok(!robot().is_standing);
});

test('STOP ALL counts nobody whose safety controller is silent', () => {
  const { world, state } = stop({ kind: 'all' });
  for (const id of ['a', 'b', 'c']) world.step(id, 'standstill');
  world.pass(3000);
  world.beat(['a', { safety_ms: 200 }], ['b', { safety_ms: 200 }], ['c', { safety_ms: 200 }]);
  assert.equal(state().standing, 3);
  assert.equal(state().all_state, 'standstill');
  world.beat(['a', { safety_ms: 200 }], ['b', { safety_ms: 200 }], ['c', { safety_ms: 2500 }]);
  assert.equal(state().standing, 2);
  assert.notEqual(state().all_state, 'standstill');
  assert.match(world.said[2], /2 of 3 stopped/);
});

test('a gateway that does not tell the age yet is believed as before', () => {
  const { world, robot } = stop();
  world.beat([ID, {}]);
  world.pass(0);
  assert.equal(world.said[1], 'Standstill confirmed');
  assert.ok(robot().is_standing);
});

test('a robot that is offline too says since when', () => {
  const { world, robot } = stop();
  world.beat([ID, { safety_ms: 12000, heard_ms: 11000 }]);
  world.step(ID, 'standstill', { age_ms: 60000 });
  world.pass(0);
  assert.equal(world.said[1], 'Standstill 12 s ago');
  assert.match(world.said[2], /no link 11 s/);
  assert.ok(!robot().is_standing);
});

test('without the gateway its last report ages, and nothing is called confirmed by it', () => {
  const { world, banner } = stop();
  world.beat([ID, { safety_ms: 190 }]);
  world.step(ID, 'standstill', { age_ms: 60000 });
  world.pass(0);
  assert.equal(world.said[1], 'Standstill confirmed');
  world.isFresh = false;
  world.pass(3000);
  assert.equal(world.said[1], 'Standstill 3 s ago');
  assert.match(banner().title, /told 3 s ago/);
});

test('without the gateway the console confirms as long as its own reports are young', async () => {
  const { world, press } = stop();
  world.beat([ID, { safety_ms: 190 }]);
  const stop_id = press();
  world.step(ID, 'standstill', { stop_id });
  world.isFresh = false;
  let safety_ms = 150;
  world.answer = () => ({ stop_id, robot: ID, name: ID, state: 'standstill', boot: 'b', age_ms: world.now - 5000, ack_ms: 180, standstill_ms: 1340, safety_ms });
  for (let i = 0; i < 60; i += 1) {
    world.pass(100);
    await new Promise((resolve) => setImmediate(resolve));
    if (i > 15) assert.equal(world.said[1], 'Standstill confirmed', `${i}`);
  }
  safety_ms = 9000;
  for (let i = 0; i < 30; i += 1) {
    world.pass(100);
    await new Promise((resolve) => setImmediate(resolve));
  }
  assert.match(world.said[1], /^Standstill \d s ago$/);
  world.answer = () => ({ stop_id, robot: ID, name: ID, state: 'not-confirmed', boot: 'b', age_ms: world.now - 5000, ack_ms: 180, standstill_ms: null, safety_ms: 100 });
  world.pass(1000);
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(world.said[1], 'NOT CONFIRMED');
});
