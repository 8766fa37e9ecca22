// Driving by hand and its pads, without a page: what moves the robot when the person is on another screen.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const read = (name) => readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8');
const ROBOT = 'weeder-01';
const settled = () => new Promise((resolve) => setImmediate(resolve));

class Node {
  constructor() {
    this.isConnected = false;
    this.style = {};
  }
  append() {}
  addEventListener() {}
}

const COVERS = /^\.h-scrim, \.h-menu/;
const gamepad = () => ({ connected: true, axes: [0, 0], buttons: Array.from({ length: 17 }, () => ({ value: 0, pressed: false })) });

// one page: Operate puts up its pads, another screen takes them away; the robot answers when the test says so
function page({ pad = null } = {}) {
  const world = { isInFront: true, cover: null, commands: [], setpoints: [], answers: [], beats: [], keys: {}, screen: null, time: 1000 };
  const define = (_tag, kind) => (world.Pads = kind);
  const HL = {
    view: { robot: null, screen: '', name: () => 'Weeder 01' }, config: {}, words: { clock: () => '' },
    el: () => new Node(), icon: () => new Node(), text() {}, attr() {}, toggle() {}, repaint() {}, toast() {}, define, LiveElement: Node,
    offline: () => '', stops: { worst: () => null }, lease: { of: () => ({ owner: null }), isMine: () => true },
    port: {
      delayMs: () => 50, robot: () => ({ mode: { mode: 'manual' } }), inside: () => ({}),
      drive: (_robot, v) => world.setpoints.push(v) > 0,
      command(robot, action) {
        world.commands.push(`${action} ${robot}`);
        return action === 'drive_open' ? new Promise((answer) => world.answers.push((outcome) => answer({ outcome }))) : Promise.resolve({ outcome: 'accepted' });
      },
    },
  };
  const listen = (type, act) => (world.keys[type] ??= []).push(act);
  const document = { hidden: false, hasFocus: () => world.isInFront, addEventListener() {}, querySelector: (what) => (COVERS.test(what) ? world.cover : (world.pads ?? null)) };
  const window = { addEventListener: listen, removeEventListener() {}, headland: { on() {}, tick: () => 't', send: (frame) => world.setpoints.push(frame.rates) } };
  const later = (act) => (act(), 0);
  const context = vm.createContext({ HL, window, document, navigator: { getGamepads: () => [pad] }, HTMLElement: Node, performance: { now: () => world.time }, setInterval: (act) => (world.beats.push(act), 1), clearInterval: () => (world.beats.length = 0), setTimeout: later });
  for (const name of ['hold_to_drive', 'jog']) vm.runInContext(read(name), context);
  world.show = (screen, robot) => {
    Object.assign(HL.view, { screen, robot });
    if (world.pads) {
      world.pads.isConnected = false;
      world.pads.leave();
    }
    world.pads = screen === 'operate' ? new world.Pads() : null;
    if (world.pads) {
      world.pads.isConnected = true;
      world.pads.enter?.();
    }
  };
  world.down = (key, target = {}) => {
    let isSpent = false;
    for (const act of world.keys.keydown) act({ key, target, preventDefault: () => (isSpent = true) });
    return isSpent;
  };
  world.pass = (beats = 1) => {
    world.setpoints.length = 0;
    for (let i = 0; i < beats; i += 1) {
      world.time += 100;
      for (const beat of [...world.beats]) beat();
    }
    return [...world.setpoints];
  };
  world.press = (key) => {
    world.down(key);
    world.time += 100;
    for (const beat of [...world.beats]) beat();
  };
  return { world, HL };
}

test('the arrow keys drive while the pads that were asked for are in sight', async () => {
  const { world, HL } = page();
  world.show('operate', ROBOT);
  const asked = HL.drive.open(ROBOT);
  world.answers[0]('accepted');
  await asked;
  world.press('ArrowUp');
  assert.ok(world.setpoints.some((v) => v > 0));
  assert.deepEqual(world.commands, [`drive_open ${ROBOT}`]);
});

for (const [screen, robot] of [['supervisor', ROBOT], ['twin', ROBOT], ['operate', 'weeder-02'], ['fleet', null]]) {
  test(`a robot that answers after the person left for ${screen} ${robot ?? ''} is not driven from there and leaves manual`, async () => {
    const { world, HL } = page();
    world.show('operate', ROBOT);
    const asked = HL.drive.open(ROBOT);
    world.show(screen, robot);
    world.answers[0]('accepted');
    await asked;
    await settled();
    world.press('ArrowUp');
    assert.deepEqual(world.setpoints, []);
    assert.ok(!HL.drive.isMine());
    assert.deepEqual(world.commands, [`drive_open ${ROBOT}`, `drive_close ${ROBOT}`]);
  });
}

test('coming back to the same robot does not drive by what was asked before', async () => {
  const { world, HL } = page();
  world.show('operate', ROBOT);
  const asked = HL.drive.open(ROBOT);
  world.show('twin', ROBOT);
  world.show('operate', ROBOT);
  world.answers[0]('accepted');
  await asked;
  world.press('ArrowUp');
  assert.deepEqual(world.setpoints, []);
  assert.equal(world.commands.at(-1), `drive_close ${ROBOT}`);
});

test('an order that was refused ends nothing', async () => {
  const { world, HL } = page();
  world.show('operate', ROBOT);
  const asked = HL.drive.open(ROBOT);
  world.show('twin', ROBOT);
  world.answers[0]('rejected');
  await asked;
  assert.deepEqual(world.commands, [`drive_open ${ROBOT}`]);
});

for (const [screen, robot] of [['twin', ROBOT], ['supervisor', 'planter-02']]) {
  test(`joints asked for on another screen than ${screen} ${robot} are not moved there, and manual ends`, async () => {
    const { world, HL } = page();
    Object.assign(HL.view, { screen: 'supervisor', robot: ROBOT });
    let sheets = 0;
    const asked = HL.jog.open(ROBOT, () => void (sheets += 1));
    Object.assign(HL.view, { screen, robot });
    world.answers[0]('accepted');
    await asked;
    assert.equal(sheets, 0);
    assert.equal(HL.jog.robot, null);
    assert.deepEqual(world.commands, [`drive_open ${ROBOT}`, `drive_close ${ROBOT}`]);
  });
}

test('joints go by the picture that is open: slower when it is old, not at all when it is frozen', async () => {
  const { world, HL } = page();
  Object.assign(HL.view, { screen: 'operate', robot: ROBOT });
  const asked = HL.jog.open(ROBOT);
  world.answers[0]('accepted');
  await asked;
  HL.port.inside = () => ({ joints: { joints: [{ name: 'pan', max_rate: 1 }] } });
  HL.jog.share = 0.5;
  let ageMs = 300;
  HL.picture = { ageMs: () => ageMs, why: () => 'Picture 1.2 s old' };
  const held = () => (HL.jog.held.set('pad', { joint: 'pan', way: 1 }), world.pass().map((rates) => rates.pan));
  assert.deepEqual(held(), [0.5]);
  ageMs = 600;
  assert.deepEqual(held(), [0.2]);
  ageMs = Infinity;
  assert.deepEqual(new Set(held()), new Set([0]));
  assert.equal(HL.jog.blockedBy, 'Picture 1.2 s old');
  assert.equal(HL.jog.held.size, 0);
  ageMs = null;
  assert.deepEqual(held(), [0.5]);
});

test('an answer for the robot before does not end driving of the robot that is shown', async () => {
  const { world, HL } = page();
  world.show('operate', ROBOT);
  const before = HL.drive.open(ROBOT);
  world.show('operate', 'weeder-02');
  const asked = HL.drive.open('weeder-02');
  world.answers[1]('accepted');
  await asked;
  world.answers[0]('accepted');
  await before;
  assert.equal(HL.drive.robot, 'weeder-02');
  assert.equal(world.commands.at(-1), `drive_close ${ROBOT}`);
});

// driving, from Operate
async function driving(options) {
  const { world, HL } = page(options);
  world.show('operate', ROBOT);
  const asked = HL.drive.open(ROBOT);
  world.answers[0]('accepted');
  await asked;
  return { world, HL };
}

test('of two windows in sight the stick moves the robot of the one in front, and never by a trigger that was held', async () => {
  const pad = gamepad();
  const [behind, front] = [await driving({ pad }), await driving({ pad })];
  behind.world.isInFront = false;
  for (const act of behind.world.keys.blur) act();
  behind.world.pass();
  front.world.pass();
  pad.buttons[7].value = 1;
  pad.axes[1] = -1;
  assert.deepEqual(behind.world.pass(5), []);
  assert.equal(behind.HL.drive.blockedBy, 'This window is not in front');
  assert.ok(front.world.pass(5).every((v) => v > 0));
  [behind.world.isInFront, front.world.isInFront] = [true, false];
  assert.deepEqual(front.world.pass(2), [0, 0]);
  assert.deepEqual(behind.world.pass(2), []); // its trigger was held before it came to the front
  pad.buttons[7].value = 0;
  behind.world.pass();
  pad.buttons[7].value = 1;
  assert.ok(behind.world.pass().some((v) => v > 0));
});

test('a finger on a pad drives at its first touch, whenever its window hears of the focus', async () => {
  const { world, HL } = await driving();
  world.isInFront = false;
  world.pass();
  const event = { pointerId: 1, button: 0, width: 20, height: 20, preventDefault() {} };
  HL.PALM_PX = 48;
  world.pads.down(event, 'forward', {});
  assert.ok(world.pass(2).every((v) => v > 0));
  assert.equal(HL.drive.held.size, 1);
});

for (const cover of ['sheet', 'menu']) {
  test(`a ${cover} that opens lets go of a held key, and no key or stick drives behind it`, async () => {
    const pad = gamepad();
    const { world, HL } = await driving({ pad });
    assert.ok(world.down('ArrowUp'));
    assert.ok(world.pass().some((v) => v > 0));
    world.cover = { cover };
    assert.deepEqual(world.pass(3), [0, 0]);
    assert.equal(HL.drive.blockedBy, 'Close what is open');
    assert.ok(!world.down('ArrowDown')); // it scrolls what is open
    pad.buttons[7].value = 1;
    pad.axes[1] = -1;
    assert.deepEqual(world.pass(3), []);
    world.cover = null;
    assert.deepEqual(world.pass(3), []);
    pad.buttons[7].value = 0;
    world.pass();
    assert.ok(world.down('ArrowUp'));
    assert.ok(world.pass().some((v) => v > 0));
  });
}

test('a key that chooses among options never drives', async () => {
  const { world } = await driving();
  const inside = (kind) => ({ closest: (what) => what.includes(kind) });
  for (const kind of ['input', '[role=radiogroup]', '[role=listbox]']) {
    assert.ok(!world.down('ArrowDown', inside(kind)), kind);
    assert.deepEqual(world.pass(), []);
  }
});
