// Whom "Skip" on the camera wall means: the robot that the button names, however the wall goes on, without a page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const read = (name) => readFileSync(new URL(`../../static/js/${name}.js`, import.meta.url), 'utf8');
const KEYS = ['planter-01/head', 'planter-02/head'];

class Node {
  constructor(values = {}) {
    Object.assign(this, { values: { ...values }, listeners: {}, dataset: {} });
  }
  append() {}
  addEventListener(type, act) {
    this.listeners[type] = act;
  }
}

// a wall with one picture of each planter; `waits` are those that ask for a person
function wall(waits) {
  const world = { now: 10000, sent: [], answer: null, waits: new Set(waits), at: 'tree-1', kinds: {} };
  const HL = {
    el: (_tag, values) => new Node(values), icon: () => new Node(), text: (node, said) => (node.said = said), attr: (node, name, value) => (node.values[name] = value),
    style() {}, toggle() {}, repaint() {}, toast() {}, LiveElement: Node, superDefine: (name, kind) => (world.kinds[name] = kind),
    config: { rights: ['tool'] }, offline: () => '', lease: { obstacle: () => '' }, outcomeWords: (outcome) => outcome,
    port: {
      follow() {}, robot: () => ({ actions: { skip_target: { ok: true } } }), fleet: () => ({ 'planter-01': { name: 'Planter 01' }, 'planter-02': { name: 'Planter 02' } }),
      inside: () => ({ site: { targets: [{ id: 'tree-0', status: 'done' }, { id: world.at, status: 'current' }] } }),
      command(robot, action, extra) {
        world.sent.push([robot, action, extra?.target]);
        return new Promise((done) => (world.answer = () => done({ outcome: 'accepted' })));
      },
    },
    camera: {
      order: { id: (one) => `${one.robot}/${one.camera}` },
      wall: { current: null, items: () => new Map(KEYS.map((key) => key.split('/')[0]).map((robot) => [robot, { verdict: { waits: world.waits.has(robot) }, robot: { code: world.waits.has(robot) ? 'ask_person' : '' } }])) },
    },
  };
  const window = { addEventListener() {} };
  vm.runInContext(read('camera/wall'), vm.createContext(Object.assign(world, { context: { HL, window, performance: { now: () => world.now }, HTMLElement: Node } }).context));
  vm.runInContext(read('camera/dock'), world.context);
  const shown = (HL.camera.shown = new HL.camera.Cameras());
  shown.tiles = new Map(KEYS.map((key) => [key, { one: { robot: key.split('/')[0], camera: 'head' } }]));
  const dock = new world.kinds['hl-cameras-dock']();
  dock.build();
  const paint = (keys = KEYS) => {
    if (!shown.isChosen) shown.first(keys);
    dock.paint();
  };
  const pass = (ms) => {
    for (const end = world.now + ms; world.now < end; ) {
      world.now += 200;
      paint();
    }
  };
  const settle = () => new Promise((done) => setImmediate(done));
  return { world, HL, shown, dock, paint, pass, settle, said: () => (dock.skip.values.hidden ? null : dock.skipWord.said) };
}

test('the button names the robot and the order names the tree', async () => {
  const { world, dock, paint, said } = wall(['planter-02']);
  paint();
  assert.equal(said(), 'Skip at Planter 02');
  dock.ask();
  assert.deepEqual(world.sent, [['planter-02', 'skip_target', 'tree-1']]);
});

test('the second tap of a double tap never reaches the robot that the wall would show next', async () => {
  const { world, dock, paint, settle, said } = wall(['planter-01', 'planter-02']);
  paint();
  dock.listeners.pointerdown();
  dock.ask();
  dock.ask();
  assert.equal(dock.skip.values['data-state'], 'pending');
  world.waits.delete('planter-01');
  world.answer();
  await settle();
  world.now += 10000;
  paint();
  dock.listeners.pointerdown();
  dock.ask();
  assert.equal(said(), null);
  assert.deepEqual(world.sent.map(([robot]) => robot), ['planter-01']);
});

test('a robot that was chosen by itself is not exchanged while Skip is offered, nor right after', () => {
  const { world, pass, paint, said } = wall(['planter-02']);
  paint();
  world.waits.add('planter-01'); // and stands before it
  pass(10000);
  assert.equal(said(), 'Skip at Planter 02');
  world.waits.delete('planter-02');
  pass(1000);
  assert.equal(said(), null);
  pass(4000);
  assert.equal(said(), 'Skip at Planter 01');
});

test('the tree that is skipped is the one of the picture, though the robot is at the next by now', () => {
  const { world, dock, paint } = wall(['planter-01']);
  paint();
  world.at = 'tree-2';
  dock.ask();
  assert.deepEqual(world.sent, [['planter-01', 'skip_target', 'tree-1']]);
});
