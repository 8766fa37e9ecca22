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
  page.say({ from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3, hasModel: true });
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
  page.say({ from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3, hasModel: true });
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
  page.say({ from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3, hasModel: true });
  page.socket().onmessage({ data: JSON.stringify({ k: "status", is_drawn: true, pose_age_s: 30, ages_s: {} }) });
  assert.equal(link.judge(true).state, "live");
  assert.equal(link.judge(false).state, "stale");
  page.pass(4000);
  assert.match(link.judge(true).text, /^Picture is/);
});

const THEN = Date.now() - 60000;
const SHORT = { t: [THEN, THEN + 1000, THEN + 2000], lat: [52, 52, 52], lon: [5, 5, 5], theta: [0, 0, 0], joints: {}, events: [{ t: THEN + 1500, target: "t2", name: "treatment", kind: "treatment" }] };

function screen() {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", { contentWindow: "frame" });
  const replay = new page.HL.TwinReplay(link, "weeder-07", "");
  const details = new page.HL.TwinDetails("weeder-07", link, () => replay.isReplay || link.isPast());
  replay.onturn = () => details.close();
  link.on("status", (said) => details.follow(said.touched));
  page.beat();
  page.status();
  const said = () => (replay.paint(), replay.said.said);
  return { ...page, page, link, replay, details, said };
}

test("the record is called shown when the picture says so, not when it was asked for", async () => {
  const { page, link, replay, said } = screen();
  replay.choose("replay");
  assert.equal(said(), "Loading the record");
  await page.answer(SHORT);
  const order = page.orders().filter((one) => one.k === "replay").at(-1);
  assert.deepEqual({ at_ms: order.at_ms, undone: order.undone }, { at_ms: THEN, undone: ["t2"] });
  page.status();
  assert.equal(said(), "Loading the record", "the robot is not drawn yet: the picture is live");
  assert.equal(link.isPast(), false);
  page.status({ is_past: true, past_ms: THEN });
  assert.match(said(), /, recorded$/);
  replay.seek(THEN + 2000);
  page.status({ is_past: true, past_ms: THEN - 50000 });
  assert.equal(said(), "Loading the record", "another moment is shown");
  page.status({ is_past: true, past_ms: THEN + 2000 });
  assert.match(said(), /, recorded$/);
  page.socket().onclose({});
  assert.equal(said(), "Loading the record", "who draws forgot it with the socket");
  page.ring();
  page.socket().onopen();
  assert.equal(page.orders().find((one) => one.k === "replay").at_ms, THEN + 2000);
  page.status({ is_past: true, past_ms: THEN + 2000 });
  assert.match(said(), /, recorded$/);
  page.pass(4000);
  assert.equal(said(), "Loading the record", "nobody told for long");
});

test("a gap of the record and joints it does not have are said, and the picture of before is not called then", async () => {
  const { page, link, replay, said } = screen();
  replay.choose("replay");
  await page.answer({ ...SHORT, t: [THEN, THEN + 1000, THEN + 61000], lat: [52, 52, 52], lon: [5, 5, 5], theta: [0, 0, 0], height: [null, null, null], joints: { slew: [0.1, 0.1, 0.1] }, events: [] });
  page.status({ is_past: true, past_ms: THEN, past_unheard: ["slew"] });
  assert.equal(replay.gap(), "");
  assert.match(said(), /, joints not recorded$/);
  replay.seek(THEN + 30000);
  assert.equal(replay.past, null);
  assert.match(replay.gap(), /^Nothing recorded from \d\d:\d\d:\d\d to \d\d:\d\d:\d\d$/);
  replay.seek(THEN + 61000);
  assert.equal(replay.gap(), "");
  replay.choose("live");
  assert.equal(replay.gap(), "");
});

test("a record without anything goes back to live and says so", async () => {
  const { page, replay, said } = screen();
  replay.choose("replay");
  await page.answer({ t: [] });
  assert.equal(replay.isReplay, false);
  assert.deepEqual(page.toasts, ["Nothing was recorded in the last 10 minutes."]);
  assert.match(said(), /behind$/);
});

test("an answer that comes after the way back, or beside a newer one, is not played", async () => {
  const { page, replay } = screen();
  replay.choose("replay");
  replay.choose("live");
  replay.choose("replay");
  await page.answer(SHORT);
  assert.equal(replay.samples, null, "it was the first one's");
  await page.answer(SHORT);
  assert.equal(replay.isPlaying, true);
});

test("going back to live is told until the line takes it, and the picture is not called live before", async () => {
  const { page, link, replay, said } = screen();
  replay.choose("replay");
  await page.answer(SHORT);
  page.status({ is_past: true, past_ms: THEN });
  page.socket().bufferedAmount = 70000;
  page.socket().sent.length = 0;
  replay.choose("live");
  page.status({ is_past: true, past_ms: THEN });
  assert.equal(said(), "Going back to live");
  assert.equal(link.isPast(), true);
  page.socket().bufferedAmount = 0;
  page.status({ is_past: true, past_ms: THEN });
  assert.deepEqual(page.orders(), [{ k: "live" }]);
  page.status();
  assert.match(said(), /behind$/);
  assert.deepEqual(page.orders(), [{ k: "live" }], "once is enough");
});

test("an angle beyond a turn is asked for within one", () => {
  const { HL } = load();
  const shown = HL.replaySampleAt({ ...record, theta: [999.9, 999.9, 0, 0] }, 500);
  assert.ok(Math.abs(shown.theta_rad) <= Math.PI, String(shown.theta_rad));
  assert.ok(Math.abs(Math.cos(shown.theta_rad) - Math.cos(999.9)) < 1e-9);
});

const TAP = { k: "tap", what: "ground", name: "Ground", lines: [], x_m: 5, y_m: 1, distance_m: 2, arm_m: 2, reach_m: 6 };

test("the card of a tap says how far it is now, and the arm's reach counts from there", () => {
  const { page, details } = screen();
  details.show({ ...TAP });
  const [crane, drive] = details.slides.map((one) => one.slide);
  assert.equal(crane.off, "");
  page.status({ touched: { x_m: 5, y_m: 1, distance_m: 40, arm_m: 40, reach_m: 6 } });
  details.paint();
  assert.match(details.slides[1].words.said, /40\.0 m away/);
  assert.match(details.where.said, /^40\.0 m from the robot/);
  assert.equal(crane.off, "Out of reach: 40.0 m, it reaches 6.0 m.");
  page.pass(3000);
  details.paint();
  assert.equal(drive.off, "The pose is old. How far it is now is not known.");
});

test("nothing is sent by a picture that stands still, though poses go on coming", () => {
  const { page, details } = screen();
  const touched = { x_m: 5, y_m: 1, distance_m: 2, arm_m: 2, reach_m: 6 };
  const offs = () => Array.from(details.slides, ({ slide }) => slide.off);
  details.show({ ...TAP });
  assert.deepEqual(offs(), ["", ""]);
  page.pass(3000);
  page.status({ touched });
  details.paint();
  assert.deepEqual(offs(), Array(2).fill("The picture is old. Wait until it is live again."));
  page.beat({ isConnected: false });
  details.paint();
  assert.ok(offs().every(Boolean), "its connection is gone");
  page.beat();
  details.paint();
  assert.deepEqual(offs(), ["", ""]);
});

test("a place that is not marked any more is not offered", () => {
  const { page, details } = screen();
  details.show({ ...TAP });
  page.status();
  assert.equal(details.node.hidden, true);
  details.show({ ...TAP });
  page.status({ touched: { x_m: 5, y_m: 2, distance_m: 40 } });
  assert.equal(details.node.hidden, true);
});

test("turning to the record or back closes the card, and nothing is sent while the record is shown", async () => {
  const { page, replay, details } = screen();
  const touched = { x_m: 5, y_m: 1, distance_m: 2 };
  details.show({ ...TAP });
  replay.choose("replay");
  assert.equal(details.node.hidden, true);
  await page.answer(SHORT);
  details.show({ ...TAP });
  page.status({ is_past: true, past_ms: THEN, touched });
  replay.choose("live");
  assert.equal(details.node.hidden, true);
  details.show({ ...TAP });
  assert.equal(details.slides[1].slide.off, "This is a replay. Go back to Live first.", "the picture still shows it");
  page.status({ touched });
  details.paint();
  assert.equal(details.slides[1].slide.off, "");
});

test("nobody is offered to drive onto an obstacle", () => {
  const { details } = screen();
  details.show({ ...TAP, what: "obstacle" });
  assert.deepEqual([...details.slides.map(({ send }) => send.action)], ["tool_go_to"]);
  details.show({ ...TAP });
  assert.deepEqual([...details.slides.map(({ send }) => send.action)], ["tool_go_to", "go_to"]);
});

test("a machine that flies is not asked to drive", () => {
  const { page: { HL }, details } = screen();
  HL.port.robot = () => ({ id: { family: "uav" } });
  details.show({ ...TAP });
  assert.deepEqual([...details.slides.map(({ send }) => [send.action, send.button])], [["go_to", "Fly here"]]);
});

test("a moment has the height between two samples, and none where none was recorded", () => {
  const { HL } = load();
  assert.equal(HL.replaySampleAt({ ...record, height: [4, 6, null, null] }, 500).height_m, 5);
  assert.equal(HL.replaySampleAt(record, 500).height_m, null);
});

test("a picture in which the robot's shapes were not drawn yet is loading, however fresh its pose", () => {
  const page = load();
  const link = new page.HL.TwinLink("weeder-07", page.frame("frame"));
  assert.match(link.frame.src, /&robot=weeder-07$/);
  page.beat({ hasModel: false });
  page.status();
  assert.deepEqual({ ...link.judge() }, { state: "connecting", text: "Loading model" });
  page.pass(20000);
  page.beat({ hasModel: false });
  page.status();
  assert.equal(link.judge().state, "connecting", "a slow tablet draws for half a minute");
  page.beat();
  assert.equal(link.judge().state, "live");
});

test("an arm that was not heard is not live, and nothing is sent by it", () => {
  const { page, link, details } = screen();
  details.show({ ...TAP });
  const touched = { x_m: 5, y_m: 1, distance_m: 2 };
  page.status({ pose_age_s: null, joints: ["slew", "boom"], unheard: ["slew", "boom"], touched });
  assert.deepEqual({ ...link.judge() }, { state: "stale", text: "Joints not heard" });
  details.paint();
  assert.deepEqual(Array.from(details.slides, ({ slide }) => slide.off), Array(2).fill("Joints not heard. How it stands is not known."));
  page.status({ pose_age_s: null, joints: ["slew", "boom"], unheard: ["boom"], touched });
  assert.equal(link.judge().text, "Joint boom not heard");
});

test("an unregistered robot is said to be new", () => {
  const { page: { HL }, link } = screen();
  HL.port.robot = () => ({ id: { family: "weeder", is_registered: false } });
  assert.deepEqual({ ...link.judge() }, { state: "unavailable", text: "New robot. An admin must accept it first." });
});

test("the robot itself has no distance from itself, another one has, and its mark goes with it", () => {
  const { page, details } = screen();
  const tapped = { ...TAP, what: "robot", id: "weeder-07", name: "Weeder 07" };
  details.show({ ...tapped });
  details.paint();
  assert.equal(details.where.said, "east 5.0, north 1.0");
  details.show({ ...tapped, id: "weeder-08" });
  page.status({ touched: { x_m: 6, y_m: 1, distance_m: 3 } });
  details.paint();
  assert.equal(details.node.hidden, false);
  assert.equal(details.where.said, "3.0 m from the robot, east 6.0, north 1.0");
  page.status();
  assert.equal(details.node.hidden, true);
});

test("what a slide does and how far away is said beside it, whole, while it is open", () => {
  const { details } = screen();
  details.show({ ...TAP });
  const [{ slide, words }] = details.slides;
  assert.equal(words.values.hidden, true);
  slide.isOpen = true;
  slide.onopen(true);
  assert.equal(words.values.hidden, false);
  assert.equal(words.said, "The crane moves. Keep everyone away: 2.0 m away, 1.0 m above ground");
});

test("a joint beyond its soft limit has its sign", () => {
  const { HL } = load();
  const joint = { name: "slew", label: "Slew", unit: "rad", value: 2.9, planned: null, lower: -3, upper: 3, soft_lower: -2.8, soft_upper: 2.8 };
  HL.port.inside = () => ({ joints: { t: 0, joints: [joint] } });
  HL.port.age = () => 100;
  const side = new HL.TwinSide();
  side.paint("weeder-07");
  const row = side.rows.get("slew");
  assert.equal(row.node.values["data-level"], 2);
  assert.deepEqual({ ...row.sign.children[0] }, { level: 2, size: 20, state: "acknowledged" });
});
