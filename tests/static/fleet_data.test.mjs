// What the fleet screen looks at anew, and when.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

test('what concerns no robot is looked at anew when the number of robots changes', () => {
  const robots = {};
  const alarms = {};
  const counted = [];
  const fleetOrder = { worstAlarms: () => ({}), notices: (_alarms, all) => (counted.push(Object.keys(all).length), []), rank() {}, judge: () => ({}), isMoved: () => false };
  const HL = { config: { user: null, rights: [] }, keep: { read: (_key, otherwise) => otherwise, write() {} }, repaint() {}, emit() {}, words: {}, LOST_MS: 3500, fleetOrder, port: { fleet: () => robots, ids: new Set() } };
  const lane = { state: (topic) => (topic === 'alarms' ? { alarms } : {}), now: () => 0 };
  const context = vm.createContext({ HL, window: { headland: lane, addEventListener() {} }, performance, setTimeout, setInterval });
  vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/fleet_data.js', import.meta.url), 'utf8'), context);
  for (const id of ['weeder-01', 'weeder-02']) {
    robots[id] = { name: id };
    HL.port.ids.add(id);
    HL.fleet.look();
    HL.fleet.look();
  }
  assert.deepEqual(counted, [1, 2]);
});

// a page with a lane whose listeners the test calls, and a server that answers as told
function screen(answers, kept = {}) {
  const asked = [];
  const said = [];
  const heard = {};
  const fleetOrder = { worstAlarms: () => ({}), notices: () => [], rank() {}, judge: () => ({}), isMoved: () => false };
  const port = { fleet: () => ({}), ids: new Set(), api: async (_method, path) => (asked.push(path), answers[path] ?? { ok: false }) };
  const HL = { config: { user: null, rights: [] }, keep: { read: () => kept, write() {} }, repaint() {}, emit() {}, words: {}, LOST_MS: 3500, fleetOrder, port, toast: (words) => said.push(words) };
  const lane = { state: () => null, now: () => 0, on: (topic, fn) => ((heard[topic] = fn), () => {}) };
  const context = vm.createContext({ HL, window: { headland: lane, addEventListener() {} }, performance, setTimeout, setInterval: () => 0 });
  vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/fleet_data.js', import.meta.url), 'utf8'), context);
  return { HL, asked, said, heard };
}

test('what changed while the line was down is asked for when it is back', () => {
  const { HL, asked, heard } = screen({});
  HL.fleet.begin();
  const first = asked.splice(0);
  heard.hello({});
  assert.deepEqual(asked, first);
  assert.ok(['/fleet/groups', '/fleet/duty', '/queue'].every((path) => asked.includes(path)));
});

test('a group of the filter that is gone is let go, and one that is not known yet is kept', async () => {
  const { HL, said } = screen({ '/fleet/groups': { ok: true, groups: [] } }, { group: 'g-0' });
  HL.fleet.setFilter({ state: 'working' });
  assert.equal(HL.fleet.filter.group, 'g-0');
  await HL.fleet.loadGroups();
  assert.equal(HL.fleet.filter.group, '');
  assert.equal(HL.fleet.filter.state, 'working');
  assert.equal(said.length, 1);
});


test('an answer that a newer one overtook changes nothing any more', async () => {
  const { HL } = screen({});
  const waiting = [];
  HL.port.api = () => new Promise((resolve) => waiting.push(resolve));
  const first = HL.fleet.loadDuty();
  const second = HL.fleet.loadDuty();
  const duty = (user) => ({ ok: true, duty: { 'weeder-01': { user } }, people: [], book: [] });
  waiting[1](duty('anna'));
  await second;
  waiting[0](duty('martha'));
  await first;
  assert.equal(HL.fleet.duty['weeder-01'].user, 'anna');
});
