// Who is responsible for the robot of an alarm.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

test('names are those of the newest question, in whatever order the answers come', async () => {
  const waiting = [];
  const heard = {};
  const HL = { repaint() {}, port: { fleet: () => ({ 'weeder-01': {} }), api: () => new Promise((resolve) => waiting.push(resolve)) } };
  const headland = { on: (topic, fn) => ((heard[topic] = fn), () => {}) };
  vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/alarm_duty.js', import.meta.url), 'utf8'), vm.createContext({ HL, window: { headland } }));
  HL.alarmDuty.begin();
  heard.event({ kind: 'duty' });
  const duty = (name) => ({ ok: true, duty: { 'weeder-01': { user: name, name } } });
  waiting[1](duty('Anna'));
  await new Promise((resolve) => setTimeout(resolve));
  assert.equal(HL.alarmDuty.of('weeder-01'), 'Anna');
  waiting[0](duty('Martha'));
  await new Promise((resolve) => setTimeout(resolve));
  assert.equal(HL.alarmDuty.of('weeder-01'), 'Anna');
});
