// READY is a claim about the way a press would go: heartbeats that arrive are not enough, on a link that only the test moves.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

const SOURCE = fs.readFileSync(new URL('../../static/js/stop_link.js', import.meta.url), 'utf8');

// A browser on a path that delays each answer to a ping by `lagMs`; heartbeats arrive four times a second all the same.
function link() {
  const world = { now: 5000, lagMs: 14, wall: 0, pongs: [], pings: 0, sockets: [] };
  class FakeSocket {
    static OPEN = 1;
    constructor() {
      this.readyState = 1;
      world.sockets.push(this);
    }
    send(text) {
      const frame = JSON.parse(text);
      if (frame.k !== 'ping') return;
      world.pings += 1;
      world.pongs.push({ at: world.now + world.lagMs, frame: { k: 'pong', n: frame.n }, to: this });
    }
    close() {}
  }
  const window = {};
  const clock = { now: () => world.now };
  vm.runInContext(SOURCE, vm.createContext({ window, WebSocket: FakeSocket, performance: clock, Date: { now: () => world.now + world.wall }, Map }));
  const socket = new window.headlandStopParts.GatewaySocket({ hello() {}, frame() {}, beat() {}, refused() {} });
  socket.use('http://gateway', 'token');
  const hear = (frame) => socket.socket?.onmessage({ data: JSON.stringify(frame) });
  const welcome = () => (socket.tick(world.now), hear({ k: 'hello', boot: 'b' }));
  const run = (ms) => {
    for (const end = world.now + ms; world.now < end; ) {
      world.now += 50;
      const due = world.pongs.filter((one) => one.at <= world.now);
      world.pongs = world.pongs.filter((one) => one.at > world.now);
      for (const one of due) if (one.to === socket.socket) hear(one.frame);
      if (world.now % 250 === 0) hear({ k: 'hb', n: 1 });
      if (world.now % 100 === 0) socket.tick(world.now);
    }
  };
  welcome();
  run(1000);
  return { world, socket, run, welcome };
}

test('a path on which pings are answered in time is fresh, and tells how long it takes', () => {
  const { world, socket, run } = link();
  run(3000);
  assert.equal(socket.isFresh(world.now), true);
  assert.ok(socket.rttMs <= 50);
});

test('a path that is seconds late is not fresh, although heartbeats arrive', () => {
  const { world, socket, run } = link();
  world.lagMs = 4000;
  run(3000);
  assert.equal(socket.isFresh(world.now), false);
  for (let second = 0; second < 8; second += 1) {
    run(1000);
    assert.equal(socket.isFresh(world.now), false, `${second} s`); // nor for a moment in between
  }
  assert.ok(socket.rttMs >= 3900, 'it does not keep its last good value');
});

test('a path that answers again is fresh again', () => {
  const { world, socket, run } = link();
  world.lagMs = 4000;
  run(6000);
  world.lagMs = 14;
  run(6000);
  assert.equal(socket.isFresh(world.now), true);
  assert.ok(socket.rttMs <= 50);
});

test('a path with one second and a bit is slow, and still a path', () => {
  const { world, socket, run } = link();
  world.lagMs = 1200;
  run(5000);
  assert.equal(socket.isFresh(world.now), true);
  assert.ok(socket.rttMs >= 1200);
});

test('without any answer it asks a few times and no more', () => {
  const { world, socket, run } = link();
  world.lagMs = Infinity;
  const before = world.pings;
  run(60_000);
  assert.ok(world.pings - before <= 8);
  assert.equal(socket.isFresh(world.now), false);
});

test('a new connection is not judged by the old one', () => {
  const { world, socket, run, welcome } = link();
  world.lagMs = Infinity;
  run(6000);
  socket.drop(world.now);
  world.lagMs = 14;
  world.now += 3000;
  welcome();
  run(1000);
  assert.equal(socket.isFresh(world.now), true);
});

test('after a sleep nothing from before counts', () => {
  const { world, socket, run } = link();
  world.wall += 3_600_000;
  socket.tick(world.now);
  assert.equal(socket.isFresh(world.now), false);
  assert.equal(socket.rttMs, null);
  run(1000);
  assert.equal(socket.isFresh(world.now), true);
});
