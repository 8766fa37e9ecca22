// What is sent is what was shown for the last tap, never the answer to an older one.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const SHEET = readFileSync(new URL('../../static/js/ui/rest_sheet.js', import.meta.url), 'utf8');
const SUM = { duration_s: 1, energy_j: 1, battery_share: 0.1, area_m2: 1, length_m: 10, rows: 1 };
const OBSTACLE = { kind: 'obstacle', outline: [[0, 0], [0, 1], [1, 1]], clearance_m: 1 };
const settled = () => new Promise(setImmediate);

// A sheet on nodes that only remember; answers and timers come when the test says so.
async function sheet() {
  const node = () => ({ append() {}, replaceChildren() {}, isConnected: true, value: '', remove() {} });
  const world = { changed: {}, asked: [], sent: [], toasts: [], timer: null, isOpen: true, sends: null, button: node() };
  const api = (method, path, body) => {
    if (method === 'GET' && path.endsWith('/rest')) return { ok: true, data: { progress: { row: 1, rows: 5 }, pieces: [{ number: 3, row: 2, length_m: 10 }] } };
    if (method === 'GET') return path === '/fields' ? { ok: true, data: { homes: [] } } : { ok: false };
    if (path.endsWith('/preview')) {
      const sha256 = `plan ${world.asked.length + 1}`;
      const data = { sha256, left_out: [], notes: [], kept_until: 'After row 1.', before: SUM, after: SUM, ...world.changed, way_m: 0, geometry: { features: [] } };
      return new Promise((resolve) => world.asked.push({ body: structuredClone(body), answer: () => (resolve({ ok: true, data }), settled()) }));
    }
    world.sent.push(body.sha256);
    return new Promise((resolve) => (world.sends = (answer) => (resolve(answer), settled())));
  };
  class RestMap {
    constructor(_title, _arrow, changed) { Object.assign(this, { changed, areas: [], tools: node(), note: node(), list: node() }); }
    show() {}
  }
  const HL = {
    el: node, icon: node, text: (to, words) => (to.words = words), attr: (to, name, value) => (to[name] = value), RestMap,
    units: { area: (m2) => ({ text: String(m2), unit: 'ha' }) }, words: { left: String }, records: { table: node },
    toast: (words) => world.toasts.push(words), sheet: () => () => (world.isOpen = false), port: { fleet: () => ({}), api: async (...call) => api(...call) },
  };
  const context = vm.createContext({ HL, window: { headland: { tick: () => 'tick' } }, document: { querySelector: () => world.button }, setTimeout: (then) => ((world.timer = then), 1), clearTimeout: () => (world.timer = null), Promise });
  vm.runInContext(SHEET, context);
  const shown = await HL.rest.change({ id: 'm1', name: 'Wheat' });
  await settled();
  const tap = () => (shown.out.has(3) ? shown.out.delete(3) : shown.out.add(3), shown.soon());
  const draw = () => ((shown.map.areas = [OBSTACLE]), shown.map.changed());
  const waited = () => (world.timer(), settled());
  return { world, shown, tap, draw, waited };
}

test('a plan that is older than the last tap cannot be sent', async () => {
  const { world, shown, tap, draw, waited } = await sheet();
  await world.asked[0].answer();
  tap();
  await waited();
  draw(); // the answer for the tap before is still on its way
  await world.asked[1].answer();
  assert.equal(world.button.disabled, true);
  assert.equal(shown.said.words, 'Planning');
  await shown.send();
  assert.deepEqual(world.sent, []);
  await waited();
  await world.asked[2].answer();
  assert.deepEqual(world.asked[2].body.areas, [OBSTACLE]);
  assert.equal(world.button.disabled, false);
  shown.send();
  await settled();
  assert.deepEqual(world.sent, ['plan 3']);
});

test('a wish that is not the planned one is planned again instead of sent', async () => {
  const { world, shown, tap, waited } = await sheet();
  await world.asked[0].answer();
  tap();
  await waited();
  await world.asked[1].answer();
  shown.map.areas = [OBSTACLE]; // changed without a word
  await shown.send();
  assert.deepEqual(world.sent, []);
  assert.equal(world.button.disabled, true);
  await waited();
  assert.deepEqual(world.asked[2].body.areas, [OBSTACLE]);
});

test('an update that is refused after another tap does not open the button for the plan before', async () => {
  const { world, shown, tap, draw, waited } = await sheet();
  await world.asked[0].answer();
  tap();
  await waited();
  await world.asked[1].answer();
  shown.send();
  await settled();
  draw();
  await world.sends({ data: { outcome: 'rejected', text: 'It is too late.' } });
  assert.equal(world.button.disabled, true);
  assert.deepEqual(world.toasts, ['Not changed: It is too late.']);
  assert.equal(world.isOpen, true);
});

test('a map that changed makes another rest, which can be sent although nobody asked for anything', async () => {
  const { world, shown, waited } = await sheet();
  await world.asked[0].answer();
  assert.deepEqual([shown.said.words, world.button.disabled], ['Nothing changed yet.', true]);
  for (const changed of [{ notes: ['Rows end sooner.'] }, { after: { ...SUM, length_m: 7 } }]) {
    world.changed = changed;
    shown.soon();
    await waited();
    await world.asked.at(-1).answer();
    assert.equal(shown.said.words, 'You changed nothing, yet it comes out another way now. After row 1.');
    assert.equal(world.button.disabled, false);
  }
});
