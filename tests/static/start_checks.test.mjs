// When the slide of a start is locked, by what the server told, without a page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import vm from 'node:vm';

const source = readFileSync(new URL('../../static/js/ui/start_checks.js', import.meta.url), 'utf8');
const groups = { mission: { status: 'accepted', is_supervised: true }, checks: [] };

async function checks(record, world = {}) {
  const api = async () => (world.isDown ? { ok: false } : { ok: true, data: { items: [], is_required: true, valid_hours: 12, record } });
  const HL = { el: () => ({}), icon: () => ({}), text() {}, attr() {}, define() {}, LiveElement: class {}, repaint() {}, config: { rights: [] }, port: { robot: () => groups, api } };
  vm.runInContext(source, vm.createContext({ HL, performance: { now: () => world.ms ?? 0 } }));
  HL.startChecks.reason('weeder-07'); // asks for the list
  await new Promise((done) => setTimeout(done, 0));
  return HL.startChecks;
}

test('a ticked list counts as long as the server tells it, whatever a tablet takes for the time', async () => {
  const told = { id: 'c1', by: 'Martha', utc: '2001-01-01T06:00:00Z', valid_until_utc: '2001-01-01T18:00:00Z' };
  const { reason, recordId } = await checks(told);
  assert.equal(reason('weeder-07'), '');
  assert.equal(recordId('weeder-07'), 'c1');
});

test('without one the slide says what to do', async () => {
  const { reason, recordId } = await checks(null);
  assert.equal(reason('weeder-07'), 'Tick the list first: Checks');
  assert.equal(recordId('weeder-07'), null);
});

test('what nobody could ask for again does not count: it may have run out', async () => {
  const world = { ms: 0 };
  const { reason } = await checks({ id: 'c1', by: 'Martha', utc: '2026-11-23T06:00:00Z', valid_until_utc: '2026-11-23T18:00:00Z' }, world);
  Object.assign(world, { isDown: true, ms: 31000 });
  reason('weeder-07');
  await new Promise((done) => setTimeout(done, 0));
  assert.equal(reason('weeder-07'), 'Tick the list first: Checks');
});
