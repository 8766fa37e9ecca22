// Why an order is off in the dock of Supervisor and Twin, on a link that only the test moves, without a page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const OFFLINE = 'Commands are off until the link is back.';
const read = (name) => readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8');

function dock() {
  const world = { serverMs: 0, robotMs: 100, tick: 't1', stop: null, groups: { id: { is_registered: true }, mode: { mode: 'auto' }, actions: {}, link: { t: 1 } } };
  const HL = {
    el: () => ({}), icon: () => ({}), text() {}, attr() {}, style() {}, toggle() {}, define() {}, superDefine() {}, LiveElement: class {},
    words: {}, config: { rights: ['pause', 'tool', 'drive', 'return_home', 'manage_nodes'] }, view: { robot: 'planter-01', name: () => 'Planter 01' },
    port: { server: () => ({ silentMs: world.serverMs }), age: () => world.robotMs, robot: () => world.groups, inside: () => ({ site: world.site }), delayMs: () => 80 },
    stops: { worst: () => world.stop }, lease: { obstacle: () => '' },
  };
  const window = { headland: { tick: () => world.tick, on() {} }, addEventListener() {} };
  const context = vm.createContext({ HL, window, document: { addEventListener() {}, hidden: false }, performance, setInterval: () => 0, setTimeout: () => 0, clearInterval() {} });
  for (const name of ['banner', 'super_jog', 'super_dock', 'super_nodes', 'super_node_sheet']) vm.runInContext(read(name), context);
  return { world, HL, why: (action) => HL.superDock.refusal(action) };
}
const ACTIONS = ['pause', 'return_home', 'tool_retract', 'skip_target', 'stock_refilled', 'jog'];

test('a fresh picture allows what the robot allows', () => {
  const { why } = dock();
  for (const action of ACTIONS) assert.equal(why(action), '', action);
});

test('without a fresh tick, as two seconds after the console froze, every order is off and says why', () => {
  const { world, HL, why } = dock();
  Object.assign(world, { serverMs: 2100, tick: null });
  for (const action of ACTIONS) assert.equal(why(action), OFFLINE, action);
  assert.equal(HL.superRestart.refusal(), OFFLINE);
});

test('a tick that came late in a burst is none, though the server talks', () => {
  const { world, why } = dock();
  world.tick = null;
  for (const action of ACTIONS) assert.equal(why(action), OFFLINE, action);
});

test('a tree can be skipped only while one is worked at', () => {
  const { world, why } = dock();
  world.site = { targets: [{ id: 'tree-3', status: 'done' }, { id: 'tree-4', status: 'planned' }] };
  assert.equal(why('skip_target'), 'There is no tree to skip now.');
  world.site.targets[1].status = 'current';
  assert.equal(why('skip_target'), '');
});

test('a robot not heard for two seconds takes no order', () => {
  const { world, why } = dock();
  world.robotMs = 2100;
  for (const action of ACTIONS) assert.equal(why(action), OFFLINE, action);
});

test('a stop that this page knows of is enough, before robot or console say so', () => {
  const { world, why } = dock();
  world.stop = { state: 'sent' };
  for (const action of ACTIONS) assert.match(why(action), /^Stopped\. Reset the stop/, action);
});
