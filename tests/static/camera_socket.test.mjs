// The page's one socket for pictures: one for all streams, alive by its pings, back by itself, gone when nobody watches.
import assert from "node:assert/strict";
import { test } from "node:test";
import { loadSocket } from "./camera_page.mjs";

function stream(camera, log = []) {
  const on = { frame: (one) => log.push(["frame", one.captured, one.seq, one.jpeg.length]), times: (list) => log.push(["times", list]), state: (one) => log.push(["state", one.state]), refused: (text) => log.push(["refused", text]), up: () => log.push(["up"]), down: () => log.push(["down"]) };
  return { robot: "weeder-01", camera, way: "jpeg", width: 640, fps: 15, on };
}
const kinds = (socket, k) => socket.sent.filter((one) => one.k === k);

test("all pictures of a page come over one socket, asked for when it has said who watches", () => {
  const { socket, sockets } = loadSocket();
  const [front, rear] = [socket.watch(stream("front")), socket.watch(stream("rear"))];
  assert.deepEqual([front, rear, sockets.length, sockets[0].url], [1, 2, 1, "wss://farm/cameras/live"]);
  assert.equal(socket.watcher(), null);
  sockets[0].greet();
  assert.equal(socket.watcher(), "token");
  assert.deepEqual(kinds(sockets[0], "watch").map((one) => [one.n, one.camera, one.way]), [[1, "front", "jpeg"], [2, "rear", "jpeg"]]);
  socket.change(1, { way: "times" });
  socket.change(1, { way: "times" });
  assert.equal(kinds(sockets[0], "watch").length, 3, "what is so already is not asked for again");
});

test("a picture is read from its frame, and one of a stream that was dropped goes nowhere", () => {
  const log = [];
  const { socket, sockets } = loadSocket();
  const n = socket.watch(stream("front", log));
  sockets[0].greet();
  const buffer = new ArrayBuffer(24 + 5);
  const view = new DataView(buffer);
  view.setUint32(0, 0x31434c48, true);
  view.setUint8(4, n);
  view.setUint8(5, 1);
  view.setUint16(6, 640, true);
  view.setFloat64(8, 1234.5, true);
  view.setUint32(16, 77, true);
  view.setUint16(20, 480, true);
  sockets[0].onmessage({ data: buffer });
  assert.deepEqual(log.at(-1), ["frame", 1234.5, 77, 5]);
  socket.drop(n);
  sockets[0].onmessage({ data: buffer });
  assert.equal(log.filter(([kind]) => kind === "frame").length, 1);
});

test("it says twice a second that the page lives, and a dead socket is replaced ever more slowly", () => {
  const log = [];
  const { socket, sockets, pass } = loadSocket();
  socket.watch(stream("front", log));
  sockets[0].greet();
  pass(1500);
  assert.equal(kinds(sockets[0], "ping").length, 3);
  pass(2100); // nothing came back
  assert.deepEqual(log.at(-1), ["down"]);
  assert.equal(socket.watcher(), null);
  pass(200);
  assert.equal(sockets.length, 2);
  sockets[1].greet("another");
  assert.deepEqual([socket.watcher(), kinds(sockets[1], "watch").length, log.at(-1)[0]], ["another", 1, "up"]);
  for (let i = 1; i < 6; i += 1) {
    const count = sockets.length;
    sockets.at(-1).onclose({ code: 4503 });
    pass([200, 400, 800, 1500, 2500][i - 1] - 10);
    assert.equal(sockets.length, count, String(i));
    pass(20);
    assert.equal(sockets.length, count + 1, String(i));
  }
});

test("when nobody watches it is closed, and a session that ended is not knocked at again", () => {
  const { socket, sockets, pass } = loadSocket();
  const n = socket.watch(stream("front"));
  sockets[0].greet();
  socket.drop(n);
  pass(1000);
  assert.equal(sockets[0].readyState, 1, "the next screen may want it");
  pass(1100);
  assert.equal(sockets[0].readyState, 3);
  pass(10000);
  assert.equal(sockets.length, 1);
  const other = loadSocket();
  other.socket.watch(stream("front"));
  other.sockets[0].greet();
  other.sockets[0].onclose({ code: 4401 });
  other.pass(60000);
  assert.equal(other.sockets.length, 1);
});
