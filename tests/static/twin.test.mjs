// Twin: the replayed moment between two samples, gaps of the record, and when the picture is old.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./twin_page.mjs";

const record = { t: [0, 1000, 2000, 20000], lat: [52, 52, 52, 52], lon: [5, 5.001, 5.002, 5.003], theta: [3.1, -3.1, -3.1, 0], joints: { slew: [0, 1, null, 2] } };

test("a moment between two samples lies between them, the turn by the shorter way", () => {
  const { HL } = load();
  const shown = HL.replaySampleAt(record, 500);
  assert.ok(Math.abs(shown.lon_deg - 5.0005) < 1e-9);
  assert.equal(shown.joints.slew, 0.5);
  assert.ok(Math.abs(Math.abs(shown.theta_rad) - Math.PI) < 0.05, String(shown.theta_rad));
});

test("in a gap of the record nothing is shown, and nothing outside of it", () => {
  const { HL } = load();
  assert.equal(HL.replaySampleAt(record, 9000), null);
  assert.equal(HL.replaySampleAt(record, -5000), null);
  assert.equal(HL.replaySampleAt({ ...record, t: [] }, 0), null);
});

test("a joint that was not recorded is not invented", () => {
  const { HL } = load();
  assert.equal(HL.replaySampleAt(record, 2000).joints.slew, undefined);
});

test("connecting, live, stale and unavailable are told apart", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  assert.equal(link.judge().state, "connecting");
  page.say({ from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3 });
  page.socket().onmessage({ data: JSON.stringify({ k: "status", is_drawn: true, pose_age_s: 0.1, ages_s: {} }) });
  assert.equal(link.judge().state, "live");
  page.pass(3000);
  assert.deepEqual({ ...link.judge() }, { state: "stale", text: "Pose is 3.1 s old" });
  page.socket().onmessage({ data: JSON.stringify({ k: "status", is_drawn: true, pose_age_s: 0.1, ages_s: {} }) });
  assert.equal(link.judge().state, "stale", "the picture itself is old");
  assert.match(link.judge().text, /^Picture is/);
  page.socket().onclose({});
  page.pass(6000);
  assert.equal(link.judge().state, "unavailable");
});

test("a robot that is drawn with a pose of unknown age is not live", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  page.say({ from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3 });
  page.socket().onmessage({ data: JSON.stringify({ k: "status", is_drawn: true, pose_age_s: null, ages_s: {} }) });
  assert.deepEqual({ ...link.judge() }, { state: "stale", text: "The age of this pose is not known" });
});

test("a browser without WebGL is shown the map", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  page.say({ from: "headland-twin", kind: "no-webgl" });
  assert.deepEqual({ ...link.judge() }, { state: "unavailable", text: "3D is not available here. Showing the map." });
});

test("what another frame says is not believed", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  page.say({ from: "headland-twin", kind: "no-webgl" }, { source: "other" });
  page.say({ from: "headland-twin", kind: "no-webgl" }, { origin: "http://evil.example" });
  assert.equal(link.judge().state, "connecting");
});

test("wishes are told again when the socket comes back, each once", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  link.wish("view", { k: "view", view: "top" });
  link.wish("view", { k: "view", view: "side" });
  link.wish("layer:trees", { k: "layer", name: "trees", on: false });
  page.socket().sent.length = 0;
  page.socket().onopen();
  assert.deepEqual(page.socket().sent.map((text) => JSON.parse(text).k), ["view", "layer"]);
});

test("graphics that the device took away are said, and the picture is loaded again if they do not come back", () => {
  const page = load();
  const frame = { contentWindow: "frame", loads: 0, set src(_address) { this.loads += 1; } };
  const link = new page.HL.TwinLink("weeder-07", frame);
  page.say({ from: "headland-twin", kind: "lost" });
  assert.deepEqual({ ...link.judge() }, { state: "connecting", text: "This device took the graphics away. Loading the picture again" });
  page.say({ from: "headland-twin", kind: "restored" });
  page.ring();
  assert.equal(frame.loads, 1);
  page.say({ from: "headland-twin", kind: "lost" });
  page.ring();
  assert.equal(frame.loads, 2);
  assert.equal(link.judge().text, "Loading model");
});

test("in a replay the pose of now does not count as old, a lost picture does", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  page.say({ from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3 });
  page.socket().onmessage({ data: JSON.stringify({ k: "status", is_drawn: true, pose_age_s: 30, ages_s: {} }) });
  assert.equal(link.judge(true).state, "live");
  assert.equal(link.judge(false).state, "stale");
  page.pass(4000);
  assert.match(link.judge(true).text, /^Picture is/);
});

test("a moment has the height between two samples, and the ground where none was recorded", () => {
  const { HL } = load();
  assert.equal(HL.replaySampleAt({ ...record, height: [4, 6, null, null] }, 500).height_m, 5);
  assert.equal(HL.replaySampleAt(record, 500).height_m, 0);
});
