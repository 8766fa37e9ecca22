// Outlines drawn by hand.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import vm from "node:vm";

const HL = {};
vm.runInNewContext(readFileSync(new URL("../../static/js/ui/area_shape.js", import.meta.url), "utf8"), { HL, Math });
const { thinned, closed, problem, area } = HL.areaShape;

const side = (from, to) => Array.from({ length: 50 }, (_, k) => [from[0] + ((to[0] - from[0]) * k) / 50, from[1] + ((to[1] - from[1]) * k) / 50 + (k % 2) * 0.02]);
const round = (x) => Math.round(x);

test("a shaky square keeps four corners", () => {
  const line = [...side([0, 0], [10, 0]), ...side([10, 0], [10, 10]), ...side([10, 10], [0, 10]), ...side([0, 10], [0, 0]), [0, 0.1]];
  const ring = closed(line, 0.3);
  assert.equal(ring.length, 4);
  assert.equal(round(area(ring)), 100);
  assert.equal(problem(ring, 1), "");
});

test("what is left is never further from what was drawn than it may be", () => {
  const line = Array.from({ length: 200 }, (_, k) => [5 * Math.cos((k / 200) * 6), 5 * Math.sin((k / 200) * 6)]);
  const kept = thinned(line, 0.2);
  assert.ok(kept.length < 40);
  for (const [x, y] of kept) assert.ok(Math.abs(Math.hypot(x, y) - 5) < 1e-9);
  assert.ok(area(kept) > 0.95 * area(line));
});

test("an eight, a line and a dot are no areas", () => {
  assert.match(problem([[0, 0], [10, 10], [10, 0], [0, 10]], 1), /crosses itself/);
  assert.match(problem([[0, 0], [10, 0]], 1), /three corners/);
  assert.match(problem([[0, 0], [0.1, 0], [0.1, 0.1]], 1), /Too small/);
});
