// What a slide names is what was on the screen when the person began; something else there cancels it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const read = (name) => readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), 'utf8');
const M1 = { id: 'field-1', sha256: 'a'.repeat(64), status: 'loaded' };
const M2 = { id: 'field-2', sha256: 'b'.repeat(64), status: 'loaded' };
const press = (stop_id, by = 'Martha', is_reset = false) => ({ stop_id, by, device: 'Tablet 1', t: 1, is_reset });

// The dock of one robot, on nodes that only remember; `slide` is the one slide that a person uses here.
function dock(groups) {
  const node = () => ({ addEventListener() {}, replaceChildren() {}, focus() {}, contains: () => true, querySelector: node, clientWidth: 400, offsetWidth: 80 });
  const heard = {};
  const world = { robot: { id: { is_registered: true }, actions: {}, ...groups }, sent: [], steps: [] };
  const window = { headlandStop: null, addEventListener: (name, listener) => (heard[name] = listener), removeEventListener() {} };
  const HL = {
    el: node, icon: node, text() {}, attr: (to, name, value) => (to[name] = value), style() {}, toggle() {}, repaint() {}, toast() {},
    LiveElement: class {}, define: (_tag, kind) => (HL.Dock = kind), preferences: { get: () => 'slide' }, words: {},
    config: { rights: ['start', 'resume', 'reset'] }, view: { robot: 'weeder-01', name: () => 'Weeder 01' }, linkState: () => 'ok', offline: () => '',
    port: {
      robot: () => world.robot, fleet: () => ({}),
      command: async (robot, action, extra) => (world.sent.push({ robot, action, ...extra }), { outcome: 'accepted', text: '' }),
      reset: async (robot, stopIds, reason) => (world.sent.push({ robot, action: 'reset', stopIds: [...stopIds], reason }), { outcome: 'accepted', text: '' }),
    },
    lease: { obstacle: () => '' }, drive: { isMine: () => false }, startChecks: { reason: () => '', recordId: () => 'list-1', summary: () => '' },
    stopReason: { get: () => 'Person', clear() {} },
  };
  const context = vm.createContext({ HL, window, document: { addEventListener() {}, removeEventListener() {} }, performance, requestAnimationFrame() {}, setTimeout: () => 0, clearTimeout() {}, matchMedia: () => ({ matches: false, addEventListener() {} }), console });
  for (const name of ['stops', 'slide_to_confirm', 'action_dock']) vm.runInContext(read(name), context);
  const shown = Object.assign(new HL.Dock(), { replaceChildren() {}, reason: node() });
  shown.build();
  shown.enter();
  shown.paint();
  const slide = (hook) => shown.controls.find(([one]) => one.options?.hook === hook)[0];
  const begin = (one) => one.down({ button: 0, width: 1, height: 1, pointerId: 1, clientX: 0, target: one.thumb, preventDefault() {} });
  const pull = (one) => one.drag && one.move({ clientX: 400 });
  const knows = (...steps) => heard['headland:stop']({ detail: { steps: steps.map((stop_id) => ({ stop_id, robot: 'weeder-01', state: 'standstill', at: 1 })) } });
  return { world, shown, slide, begin, pull, knows };
}
const finish = async (one) => (one.up(), await new Promise(setImmediate));
const IDLE = { mode: { mode: 'idle' }, mission: M1 };
const PAUSED = { mode: { mode: 'paused' }, mission: { ...M1, status: 'paused' } };
const LATCHED = { mode: { mode: 'stopped' }, safety: { latched: true, standstill: true, presses: [press('stop-one')] } };

for (const [hook, action, groups] of [['mission-start', 'start', IDLE], ['mission-resume', 'resume', PAUSED]]) {
  test(`${action} names the mission and the version that were shown`, async () => {
    const { world, slide, begin, pull } = dock(groups);
    const one = slide(hook);
    begin(one);
    pull(one);
    await finish(one);
    assert.deepEqual(world.sent, [{ robot: 'weeder-01', action, mission_id: M1.id, mission_sha256: M1.sha256, checklist_id: 'list-1' }]);
  });

  for (const [what, change] of [['another mission', { id: M2.id, sha256: M2.sha256 }], ['another version of it', { sha256: M2.sha256 }]]) {
    test(`${what} under an armed ${action} cancels the slide`, async () => {
      const { world, shown, slide, begin, pull } = dock(groups);
      const one = slide(hook);
      begin(one);
      pull(one);
      world.robot = { ...world.robot, mission: { ...world.robot.mission, ...change } };
      shown.paint();
      assert.equal(one.state, 'idle');
      assert.equal(one.wording()[0], 'What you saw has changed');
      await finish(one);
      assert.deepEqual(world.sent, []);
    });

    test(`${action} never names ${what} that came too late to be painted`, async () => {
      const { world, slide, begin, pull } = dock(groups);
      const one = slide(hook);
      begin(one);
      pull(one);
      world.robot = { ...world.robot, mission: { ...world.robot.mission, ...change } };
      await finish(one);
      assert.equal(world.sent[0].mission_id, M1.id);
      assert.equal(world.sent[0].mission_sha256, M1.sha256);
    });
  }
}

test('progress of the same mission does not disturb a slide', () => {
  const { world, shown, slide, begin } = dock(IDLE);
  const one = slide('mission-start');
  begin(one);
  world.robot = { ...world.robot, mission: { ...M1, t: 2, row: 3 } };
  shown.paint();
  assert.equal(one.state, 'armed');
});

test('a reset clears the presses that were there when the slide began, and no later one', async () => {
  const { world, slide, begin, pull } = dock(LATCHED);
  const one = slide('stop-reset');
  begin(one);
  pull(one);
  world.robot = { ...world.robot, safety: { ...LATCHED.safety, presses: [press('stop-one'), press('stop-two', '')] } };
  await finish(one);
  assert.deepEqual(world.sent, [{ robot: 'weeder-01', action: 'reset', stopIds: ['stop-one'], reason: 'Person' }]);
});

for (const [who, push] of [
  ['the robot', ({ world }) => (world.robot = { ...world.robot, safety: { ...LATCHED.safety, presses: [press('stop-one'), press('stop-two')] } })],
  ['the slab alone', ({ knows }) => knows('stop-one', 'stop-two')],
]) {
  test(`a STOP that ${who} tells of while somebody resets cancels the slide`, async () => {
    const page = dock(LATCHED);
    const one = page.slide('stop-reset');
    page.begin(one);
    page.pull(one);
    push(page);
    page.shown.paint();
    assert.equal(one.state, 'idle');
    await finish(one);
    assert.deepEqual(page.world.sent, []);
  });
}
