// The planned path that the scrubber travels along: where the robot is, and which way its nose looks.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const context = vm.createContext({ HL: { planner: {} } });
vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/plan_path.js', import.meta.url), 'utf8'), context);
const { Path } = context.HL.planner;
vm.runInContext(fs.readFileSync(new URL('../../static/js/ui/mission_numbers.js', import.meta.url), 'utf8'), context);
const { stops } = context.HL.plan;
const leg = (t, xy, more = {}) => ({ kind: 'turn', row: 0, on: false, dose: 1, pivot: false, t, xy, ...more });
const degrees = (rad) => Math.round((Math.atan2(Math.sin(rad), Math.cos(rad)) * 180) / Math.PI);

test('where it backs up it looks against its way, and its nose does not turn while it stops', () => {
  const path = new Path({ legs: [leg([0, 10], [0, 0, 0, 10]), leg([12, 22], [0, 10, 0, 4], { back: true }), leg([24, 34], [0, 4, 0, 8])] });
  assert.deepEqual([1, 9, 11, 13, 21, 23, 30].map((t) => degrees(path.at(t).heading)), [90, 90, 90, 90, 90, 90, 90]);
  assert.ok(Math.abs(path.at(17).y - 7) < 1e-9);
  assert.equal(path.at(17).isBack, true);
  assert.equal(path.at(30).isBack, false);
  assert.equal(path.at(34).driven, 20);
});

test('a turn on the spot turns the nose from where it came to where it goes', () => {
  const path = new Path({ legs: [leg([0, 10], [0, 0, 10, 0]), leg([12, 22], [10, 0, 10, 10], { pivot: true })] });
  assert.deepEqual([9, 11, 13].map((t) => degrees(path.at(t).heading)), [0, 45, 90]);
});

test('turns say how they stop, and nothing of what they never do', () => {
  assert.equal(stops({ pivots: 0 }), 'none on the spot');
  assert.equal(stops({ pivots: 3, reversals: 0 }), '3 on the spot');
  assert.equal(stops({ pivots: 0, reversals: 8 }), '4 backing up');
  assert.equal(stops({ pivots: 1, reversals: 2 }), '1 on the spot, 1 backing up');
});

test('a slider shows turns of a machine that stands for hours in its rows, and finds its way back', () => {
  const path = new Path({ legs: [leg([0, 36000], [0, 0, 0, 90], { row: 1, on: true }), leg([36000, 36030], [0, 90, 5, 90]), leg([36030, 72030], [5, 90, 5, 0], { row: 2, on: true })] });
  assert.ok(path.shareAt(36030) - path.shareAt(36000) > 0.03);
  const times = Array.from({ length: 101 }, (_, i) => path.timeAt(i / 100));
  assert.deepEqual([times[0], times[100], path.timeAt(2)], [0, 72030, 72030]);
  times.forEach((t, i) => assert.ok(i === 0 || t > times[i - 1]));
  times.forEach((t, i) => assert.ok(Math.abs(path.shareAt(t) - i / 100) < 1e-9));
});
