// Cameras: by which way pictures come, when one is frozen, and what is said about it, on a clock that tests move.
import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./camera_page.mjs";

const { camera, fleetOrder } = load();
const { Ways, Sight, Times, Again, says, order } = camera;

// pictures over the server every `period` ms from `from` to `to`; returns the last look
function feed(ways, from, to, { period = 66, ageMs = 90 } = {}) {
  let seen = ways.look(from);
  for (let now = from; now <= to; now += period) {
    ways.serverPicture(now, ageMs);
    seen = ways.look(now);
  }
  return seen;
}

test("pictures over the server are shown at once, direct ones as soon as the first is there", () => {
  const ways = new Ways(0);
  assert.deepEqual({ ...ways.look(0) }, { direct: true, way: "jpeg", shown: "server", hasGivenUp: false, why: "" });
  feed(ways, 100, 400);
  ways.directPicture(450);
  assert.deepEqual({ ...ways.look(450) }, { direct: true, way: "times", shown: "direct", hasGivenUp: false, why: "" });
});

test("where nothing comes directly it is given up and said within 2.2 s, and tried again ever more rarely", () => {
  const ways = new Ways(0);
  assert.equal(feed(ways, 100, 1900).hasGivenUp, false);
  const seen = feed(ways, 1966, 2150);
  assert.equal(seen.hasGivenUp, true);
  assert.equal(seen.why, "No direct way to the camera");
  assert.equal(seen.shown, "server");
  const tried = [];
  let isWanted = false;
  for (let now = 2200; now < 160000; now += 100) {
    ways.serverPicture(now, 90);
    const { direct } = ways.look(now);
    if (direct && !isWanted && now > 8000) tried.push(now);
    isWanted = direct;
  }
  const gaps = tried.slice(1).map((now, i) => now - tried[i]);
  assert.ok(tried[0] >= 13000 && tried[0] <= 13200, String(tried));
  assert.ok(gaps.every((gap, i) => i === 0 || gap > gaps[i - 1]), String(gaps));
});

test("a direct picture that comes late brings the better way back by itself", () => {
  const ways = new Ways(0);
  feed(ways, 100, 6000);
  ways.directPicture(6100);
  assert.deepEqual({ ...ways.look(6100) }, { direct: true, way: "times", shown: "direct", hasGivenUp: false, why: "" });
});

test("a camera that gives nothing says nothing about the way", () => {
  const ways = new Ways(0);
  for (let now = 0; now < 30000; now += 200) assert.equal(ways.look(now).hasGivenUp, false, String(now));
});

test("direct pictures that stop while the camera goes on are replaced within 1.2 s; a camera that stops is not", () => {
  const ways = new Ways(0);
  for (let now = 100; now < 5000; now += 66) ways.directPicture(now);
  for (let now = 5000; now < 6100; now += 66) ways.cameraPicture(now);
  const seen = ways.look(6100);
  assert.equal(seen.shown, "server");
  assert.equal(seen.why, "The direct pictures stopped");
  const calm = new Ways(0);
  for (let now = 100; now < 5000; now += 66) calm.directPicture(now);
  assert.equal(calm.look(20000).shown, "direct");
});

test("a line that brings only old pictures gets two a second, and is tried again later", () => {
  const ways = new Ways(0, { hasDirect: false, why: "This browser has no direct pictures" });
  assert.equal(feed(ways, 0, 2500, { ageMs: 1400 }).way, "jpeg");
  assert.equal(feed(ways, 2600, 3200, { ageMs: 1400 }).way, "still");
  assert.equal(feed(ways, 3300, 7900, { ageMs: 300, period: 500 }).way, "still");
  assert.equal(feed(ways, 8300, 8400, { ageMs: 300 }).way, "jpeg");
});

test("the same old picture sent once more is no sign of a poor line, and after good seconds the next trouble is the first", () => {
  const ways = new Ways(0, { hasDirect: false });
  for (let now = 0; now < 8000; now += 500) ways.serverPicture(now, 300000 + now, 7);
  assert.equal(ways.look(1000).way, "jpeg");
  const line = new Ways(0, { hasDirect: false });
  feed(line, 0, 3200, { ageMs: 1400 });
  assert.equal(line.drops, 1);
  assert.equal(feed(line, 8300, 12000).way, "jpeg");
  assert.equal(line.drops, 1, "not steady yet");
  feed(line, 12066, 19000);
  assert.equal(line.drops, 0);
});

test("still pictures are frozen after one second as all others, and those of a slow camera say their age", () => {
  const sight = looked(4000, { period: 500 });
  assert.equal(sight.judge(sight.last + 900, sight.last + 900, { ...INFO, period_s: 0.07 }).state, "live");
  assert.equal(sight.judge(sight.last + 1010, sight.last + 1010, { ...INFO, period_s: 0.07 }).state, "frozen");
  const station = new Sight(0);
  station.picture(0, -300000, 0);
  const judged = station.judge(130000, 130000, { ...INFO, period_s: 900 });
  assert.equal(says.corner(judged, { way: "still" }), "still pictures, 7:10 old");
  assert.match(says.sentence("Pole", judged, { way: "still" }), /^Pole\. Still pictures, 7:10 old/);
});

const INFO = { state: "live", fps: 15, reason: "", restarts: 0 };

function looked(until, { period = 66, delay = 110, isDated = true } = {}) {
  const sight = new Sight(0);
  for (let now = 100; now <= until; now += period) sight.picture(now, now - delay, now, isDated);
  return sight;
}

test("a picture is live with its delay and rate, and frozen one second after the last one", () => {
  const sight = looked(3000);
  const live = sight.judge(3050, 3050, INFO, "direct");
  assert.equal(live.state, "live");
  assert.equal(live.delayMs, 110);
  assert.ok(Math.abs(live.fps - 15) < 1, String(live.fps));
  const last = sight.last;
  assert.equal(sight.judge(last + 950, last + 950, INFO, "direct").state, "live");
  const frozen = sight.judge(last + 1010, last + 1010, INFO, "direct");
  assert.equal(frozen.state, "frozen");
  assert.equal(says.corner(sight.judge(last + 12000, last + 12000, INFO, "direct"), { way: "direct" }), "frozen 12 s");
  assert.equal(sight.judge(last + 41000, last + 41000, INFO, "direct").state, "off", "so old a picture tells nothing about now");
});

test("the last picture of a frozen camera, sent again for somebody who comes late, is not live", () => {
  const sight = looked(3000);
  const { last } = sight;
  const frozen = () => assert.equal(sight.judge(6100, 6100, INFO).state, "frozen");
  assert.ok(sight.isSilent(6000, 0.066), "its time decides whether it counts");
  sight.picture(6000, last - 110, 6000);
  frozen();
  sight.dated(last - 110, 6000, 6000);
  frozen();
  assert.equal(sight.judge(6100, 6100, INFO).ageMs, 6100 - (last - 110));
  sight.picture(6050, 5950, 6050);
  assert.equal(sight.judge(6100, 6100, INFO).state, "live");
});

test("a picture that counted before its time was told counts no more when it is the one before once more", () => {
  const sight = looked(3000);
  const { last } = sight;
  assert.ok(!sight.isSilent(last + 800, 0.066));
  sight.picture(last + 800, null, last + 800);
  sight.dated(last - 110, last + 800, last + 800);
  assert.equal(sight.judge(last + 1010, last + 1010, INFO).state, "frozen");
});

test("a camera without pictures has one age, that of its last picture", () => {
  const sight = new Sight(0);
  sight.picture(100, 100 - 85000, 100, true);
  const judged = sight.judge(34100, 34100, INFO);
  assert.equal(judged.state, "off");
  assert.equal(says.goneMs(judged), 119000);
  assert.equal(says.corner(judged, { way: "jpeg" }), "no picture 1:59");
  assert.equal(says.sentence("Pole", judged, { way: "jpeg" }), "Pole: no picture for 1:59");
  const none = new Sight(0).judge(34000, 34000, INFO);
  assert.equal(says.corner(none, { way: "jpeg" }), "no picture 34 s");
});

test("a picture of a slow camera that was old when it came is late, and says its age", () => {
  const slow = { ...INFO, fps: 0.2, period_s: 5 };
  const sight = new Sight(0);
  sight.picture(100, 100 - 300000, 100, true);
  assert.equal(sight.judge(1100, 1100, slow, "jpeg").state, "late");
  assert.equal(says.corner(sight.judge(1100, 1100, slow, "jpeg"), { way: "jpeg" }), "late, 5:01 old");
  const hourly = { ...slow, period_s: 3600 };
  const station = new Sight(0);
  station.picture(2000, 2000 - 1500000, 2000, true);
  assert.equal(station.judge(62000, 62000, hourly, "jpeg").state, "live");
  assert.equal(says.corner(station.judge(62000, 62000, hourly, "jpeg"), { way: "jpeg" }).slice(0, 9), "26:00 old");
});

test("a slow camera is frozen after three of its periods, not before", () => {
  const sight = looked(20000, { period: 5000 });
  const slow = { ...INFO, fps: 0.2, period_s: 5 };
  const { last } = sight;
  assert.equal(sight.judge(last + 9000, last + 9000, slow, "jpeg").state, "live");
  assert.equal(sight.judge(last + 15100, last + 15100, slow, "jpeg").state, "frozen");
});

test("a camera that should be fast and brings one picture in four seconds is frozen in between", () => {
  const sight = looked(20000, { period: 4000 });
  assert.equal(sight.judge(sight.last + 1100, sight.last + 1100, { ...INFO, fps: 0.25, period_s: 0.07 }, "direct").state, "frozen");
});

test("pictures that arrive in time but are old are not called live", () => {
  const judged = looked(3000, { delay: 1400 }).judge(3050, 3050, INFO, "jpeg");
  assert.equal(judged.state, "late");
  assert.equal(says.corner(judged, { way: "jpeg" }), "late, 1.4 s old");
  assert.equal(says.hook(judged, { way: "jpeg" }), "frozen");
});

test("without any picture it says after five seconds that there is none, at once when the camera is down", () => {
  const sight = new Sight(0);
  assert.equal(sight.judge(4000, 4000, INFO, "jpeg").state, "connecting");
  assert.equal(sight.judge(5100, 5100, INFO, "jpeg").state, "off");
  assert.equal(sight.judge(200, 200, { ...INFO, state: "failed" }, "jpeg").state, "off");
});

test("a frozen camera is asked for anew ever more rarely, and from the beginning once it was live", () => {
  const again = new Again();
  const due = [];
  for (let now = 0; now < 120000; now += 100) if (again.isDue(now, "frozen")) due.push(now);
  const gaps = due.map((now, i) => now - (due[i - 1] ?? 0));
  assert.deepEqual(gaps, [3000, 5100, 10100, 20100, 30100, 30100]);
  assert.equal(again.isDue(121000, "live"), false);
  assert.equal(again.isDue(122000, "frozen"), false);
  assert.equal(again.isDue(125000, "frozen"), true);
});

test("words are honest about the way and about a camera without its own time", () => {
  const judged = looked(3000).judge(3050, 3050, INFO, "jpeg");
  assert.equal(says.corner(judged, { way: "direct" }), "110 ms, 15 fps");
  assert.equal(says.note(judged, { way: "direct" }), "");
  assert.equal(says.note(judged, { way: "jpeg", hasGivenUp: true }), "Single pictures");
  assert.equal(says.sentence("Front", judged, { way: "jpeg", hasGivenUp: true, why: "No direct way to the camera" }), "Front, 110 ms, 15 fps. Single pictures: No direct way to the camera");
  assert.equal(says.corner({ ...judged, delayMs: 500 }, { way: "still" }), "still pictures, 0.5 s");
  assert.equal(says.hook(judged, { way: "jpeg", hasGivenUp: true }), "stills");
  assert.equal(says.hook(judged, { way: "jpeg", hasGivenUp: false }), "live");
  const undated = looked(3000, { isDated: false }).judge(3050, 3050, INFO, "jpeg");
  assert.equal(says.corner(undated, { way: "direct" }), "delay unknown, 15 fps");
  assert.equal(says.sentence("Front", undated, { way: "direct" }), "Front, delay unknown, 15 fps. The camera tells no time, over 110 ms");
  assert.equal(says.corner(undated, { way: "still" }), "still pictures, delay unknown");
  assert.equal(says.reason({ state: "failed", reason: "Node camera_rear is in error", restarts: 3 }), "Node camera_rear is in error. Restarted 3 times.");
  assert.equal(says.corner({ ...judged, fps: 0.2 }, { way: "direct" }), "110 ms, 1 per 5 s");
});

test("the time of a direct picture is found whether it is told before or after it is shown", () => {
  const times = new Times();
  times.told([[900, 100, 1]]);
  assert.equal(times.shown(900, 210), 100);
  assert.equal(times.shown(6900, 280), null);
  const [found] = times.told([[6900, 166, 2]]);
  assert.deepEqual({ ...found }, { captured: 166, at: 280 });
  for (let i = 0; i < 2000; i += 1) times.told([[10000 + i, i, i]]);
  assert.ok(times.known.size <= 256);
});

const item = (id, verdict) => ({ id, robot: { name: id, family: "weeder" }, verdict: { group: "normal", level: null, head: "", helpS: Infinity, since: null, ...verdict } });
const cam = (robot, name, view) => ({ robot, camera: name, view });

test("attention comes first, each robot shows its first camera before any shows a second", () => {
  const items = [item("w-1"), item("w-2", { group: "needs-you", level: 1 }), item("w-3", { group: "watch", level: 3 })];
  const cameras = [cam("w-1", "rear", "rear"), cam("w-1", "front", "front"), cam("w-2", "rear", "rear"), cam("w-3", "front", "front"), cam("w-2", "front", "front"), cam("field", "station", undefined)];
  const found = order.arrange(cameras, fleetOrder.rank(items), { mode: "attention" }).map(order.id);
  assert.deepEqual([...found], ["w-2/front", "w-3/front", "w-1/front", "field/station", "w-2/rear", "w-1/rear"]);
});

test("my wall keeps its own order and forgets cameras that are gone", () => {
  const cameras = [cam("w-1", "front", "front"), cam("w-2", "front", "front")];
  assert.deepEqual([...order.arrange(cameras, [], { mode: "mine", mine: ["w-2/front", "gone/x", "w-1/front"] }).map(order.id)], ["w-2/front", "w-1/front"]);
});
