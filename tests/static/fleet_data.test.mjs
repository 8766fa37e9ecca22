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
  const HL = { config: { user: null, rights: [] }, keep: { read: (_key, otherwise) => otherwise, write() {} }, repaint() {}, words: {}, LOST_MS: 3500, fleetOrder, port: { fleet: () => robots, ids: new Set() } };
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
