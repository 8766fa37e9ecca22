import assert from 'node:assert/strict';
import test from 'node:test';
import { World } from './browser.mjs';

const R = 'robot/weeder-01';

test('the link is ok while ticks come and judged every 100 ms without any', () => {
  const w = new World();
  assert.equal(w.headland.link(), 'server-lost');
  w.connect();
  assert.equal(w.headland.link(), 'ok');
  w.run(2000);
  assert.equal(w.headland.link(), 'ok');
  w.advance(900);
  assert.equal(w.headland.link(), 'ok');
  w.advance(200);
  assert.equal(w.headland.link(), 'stale');
  w.advance(2500);
  assert.equal(w.headland.link(), 'server-lost');
  w.tick();
  assert.equal(w.headland.link(), 'ok');
  assert.deepEqual(w.events.filter(([n]) => n === 'headland:link').map(([, d]) => d.state), ['ok', 'stale', 'server-lost', 'ok']);
});

test('a burst of held ticks does not look fresh', () => {
  const w = new World();
  w.connect();
  w.run(3000);
  w.advance(8000);
  w.socket.readyState = 1;
  for (let late = 8000; late >= 5000; late -= 100) w.tick(late);
  assert.equal(w.headland.link(), 'server-lost');
  assert.equal(w.headland.tick(), null);
  assert.ok(w.headland.age(w.m - 5000) >= 4.9);
  w.tick();
  assert.equal(w.headland.link(), 'ok');
  assert.equal(w.headland.tick(), `boot1-${w.ticks}`);
});

test('every value ages by itself with the limits of its period', () => {
  const w = new World();
  w.connect();
  const t = w.m;
  const seen = [];
  for (const ms of [0, 999, 1000, 2000, 3500]) { const age = w.m - t; w.advance(ms - age); seen.push(w.headland.freshness(t)); }
  assert.deepEqual(seen, ['fresh', 'fresh', 'late', 'stale', 'lost']);
  assert.equal(w.headland.freshness(w.m - 1499, 1000), 'fresh');
  assert.equal(w.headland.freshness(w.m - 1500, 1000), 'late');
  assert.equal(w.headland.freshness(w.m - 3000, 1000), 'stale');
  assert.equal(w.headland.freshness(w.m - 60000, 1000), 'stale');
  assert.equal(w.headland.freshness(null), 'missing');
  assert.equal(w.headland.freshness(undefined, 100), 'missing');
});

test('clock drift of the console is followed within a minute or two', () => {
  const w = new World();
  w.connect();
  for (let i = 0; i < 1800; i++) { w.offset -= 0.05; w.run(100); } // 500 ppm for three minutes
  assert.ok(w.headland.age(w.m) < 0.05, String(w.headland.age(w.m)));
  assert.equal(w.headland.link(), 'ok');
});

test('ages are worded as an operator reads them', () => {
  const { headland } = new World();
  const words = [0.2, 9.94, 9.96, 12.4, 59.4, 59.6, 134, 3599.4, 3600, 4080, 36000].map(headland.ageText);
  assert.deepEqual(words, ['0.2 s', '9.9 s', '10 s', '12 s', '59 s', '1:00', '2:14', '59:59', '1 h 00', '1 h 08', '10 h 00']);
  assert.equal(headland.ageText(null), '––');
});

test('a snapshot replaces and a delta merges whole groups', () => {
  const w = new World();
  const heard = [];
  w.headland.on(R, (state, topic, changed) => heard.push(changed && Array.from(changed)));
  w.headland.sub([R]);
  w.connect();
  w.socket.say({ k: 'snap', rev: 5, d: { [R]: { pose: { lat: 1, lon: 2 }, why: null } } });
  w.socket.say({ k: 'delta', rev: 6, d: { [R]: { pose: { lat: 3 } } } });
  assert.equal(JSON.stringify(w.headland.state(R)), '{"pose":{"lat":3},"why":null}');
  assert.deepEqual(heard, [null, ['pose']]);
  assert.deepEqual(w.sent('sub'), [{ k: 'sub', topics: [R] }]);
});

test('the lists are subscribed as long as anybody listens, robots only as asked', () => {
  const w = new World();
  w.connect();
  w.headland.sub([R]);
  w.headland.on('robot/other', () => {});
  const off = w.headland.on('poses', () => {});
  w.headland.sub([R, 'fleet']);
  off();
  assert.deepEqual(w.sent('sub').map((f) => f.topics.join(' ')), [R, `${R} poses`, `${R} fleet poses`, `${R} fleet`]);
});

test('what the tick says of the parts of the system can be read', () => {
  const w = new World();
  w.connect();
  w.headland.sub([R]);
  assert.equal(w.headland.state('tick').stop, 'up');
});

test('a full server is tried again and does not send the page to sign-in', () => {
  const w = new World();
  w.socket.open();
  w.socket.say({ k: 'bye', code: 'full', text: 'Too many pages are open on this server.' });
  w.socket.fail(4429);
  w.advance(1000);
  assert.equal(w.sockets.length, 2);
  assert.equal(w.events.filter(([n]) => n === 'headland:bye').length, 0);
});

test('an old or repeated delta is not applied', () => {
  const w = new World();
  w.connect();
  w.socket.say({ k: 'snap', rev: 5, d: { [R]: { pose: 1 } } });
  w.socket.say({ k: 'delta', rev: 6, d: { [R]: { pose: 2 } } });
  w.socket.say({ k: 'delta', rev: 6, d: { [R]: { pose: 9 } } });
  w.socket.say({ k: 'delta', rev: 4, d: { [R]: { pose: 9 } } });
  w.socket.say({ k: 'snap', rev: 3, d: { [R]: { pose: 9 } } });
  assert.equal(w.headland.state(R).pose, 2);
});

test('fleet deltas merge by robot and null removes one', () => {
  const w = new World();
  w.connect();
  w.socket.say({ k: 'snap', rev: 1, d: { fleet: { robots: { a: { lat: 1 }, b: { lat: 2 } } } } });
  w.socket.say({ k: 'delta', rev: 2, d: { fleet: { robots: { a: null, c: { lat: 3 } } } } });
  assert.deepEqual(Object.keys(w.headland.state('fleet').robots), ['b', 'c']);
});

test('binary places are read with their age', () => {
  const w = new World();
  w.connect();
  w.socket.say({ k: 'snap', rev: 1, d: { poses: { numbers: { 'weeder-01': 0, 'weeder-02': 1 } } } });
  const buffer = new ArrayBuffer(36), view = new DataView(buffer);
  for (const [i, c] of [...'HLP1'].entries()) view.setUint8(i, c.charCodeAt(0));
  view.setUint32(4, 2, true); view.setFloat64(8, w.m, true); view.setUint32(16, 1, true);
  view.setUint32(20, 1, true); view.setInt32(24, -335000000, true); view.setInt32(28, 50000000, true);
  view.setUint16(32, 9000, true); view.setUint16(34, 25, true);
  w.socket.say(buffer);
  assert.deepEqual({ ...w.headland.state('poses').robots['weeder-02'] }, { lat: -33.5, lon: 5, heading_deg: 90, t: w.m - 250 });
});

test('beats bring an entry of the fleet up to date in place, and an entry that changes keeps them', () => {
  const w = new World();
  w.connect();
  w.socket.say({ k: 'snap', rev: 1, d: { fleet: { robots: { a: { n: 3, mode: 'auto' }, b: { n: 4 } }, beats: { a: [w.m - 700, 80] } } } });
  assert.equal(w.headland.state('fleet').robots.a.t, w.m - 700);
  assert.equal(w.headland.state('fleet').robots.b.t, null);
  const buffer = new ArrayBuffer(36), view = new DataView(buffer);
  for (const [i, c] of [...'HLB1'].entries()) view.setUint8(i, c.charCodeAt(0));
  view.setUint32(4, 2, true); view.setFloat64(8, w.m, true); view.setUint32(16, 2, true);
  view.setUint32(20, 3, true); view.setUint16(24, 25, true); view.setUint16(26, 91, true);
  view.setUint32(28, 4, true); view.setUint16(32, 65535, true); view.setUint16(34, 65535, true);
  const m = w.m;
  w.socket.say(buffer);
  const { a, b } = w.headland.state('fleet').robots;
  assert.deepEqual([a.t, a.rtt_ms, b.t, b.rtt_ms], [m - 250, 91, null, null]);
  w.socket.say({ k: 'delta', rev: 3, d: { fleet: { robots: { a: { n: 3, mode: 'paused' } } } } });
  assert.deepEqual([w.headland.state('fleet').robots.a.t, w.headland.state('fleet').robots.a.mode], [m - 250, 'paused']);
});

test('the places of robots that stand still come with the snapshot, as old as they are', () => {
  const w = new World();
  w.connect();
  w.socket.say({ k: 'snap', rev: 1, d: { poses: { numbers: { a: 0 }, places: { a: [52.1, 4.2, 90, w.m - 60000] } } } });
  assert.deepEqual({ ...w.headland.state('poses').robots.a }, { lat: 52.1, lon: 4.2, heading_deg: 90, t: w.m - 60000 });
});

test('it reconnects with a growing pause, subscribes again and takes a fresh snapshot', () => {
  const w = new World();
  w.headland.sub([R]);
  w.connect();
  w.socket.say({ k: 'snap', rev: 900, d: { [R]: { pose: 1 } } });
  w.socket.fail();
  w.advance(400);
  assert.equal(w.sockets.length, 2);
  w.socket.fail();
  w.advance(300);
  assert.equal(w.sockets.length, 2);
  w.advance(400);
  assert.equal(w.sockets.length, 3);
  w.offset = 70; // another run of the console: its clock starts anew
  w.connect('boot2');
  w.socket.say({ k: 'snap', rev: 1, d: { [R]: { pose: 2 } } });
  assert.equal(w.headland.state(R).pose, 2);
  assert.equal(w.headland.age(w.m), 0);
  assert.equal(w.sent('sub').length, 2);
});

test('a socket that hangs without a word is given up', () => {
  const w = new World();
  w.connect();
  w.run(1000);
  w.advance(8000);
  assert.equal(w.sockets.length, 2);
});

test('a handshake that hangs is given up', () => {
  const w = new World();
  w.advance(5000);
  assert.ok(w.sockets.length >= 2);
});

test('nothing sent while the socket is not open is sent later', () => {
  const w = new World();
  assert.equal(w.headland.send({ k: 'drive', robot: 'weeder-01', v: 1, w: 0, tick: 'x' }), false);
  w.connect();
  w.run(500);
  assert.equal(w.headland.send({ k: 'drive', robot: 'weeder-01', v: 0.2, w: 0, tick: w.headland.tick() }), true);
  w.socket.readyState = 2;
  assert.equal(w.headland.send({ k: 'drive', robot: 'weeder-01', v: 0.3, w: 0, tick: 'x' }), false);
  w.socket.fail();
  w.advance(500);
  w.connect();
  w.run(1000);
  assert.deepEqual(w.sent('drive').map((f) => f.v), [0.2]);
});

test('nothing is sent into a socket that is jammed', () => {
  const w = new World();
  w.connect();
  w.run(200);
  w.socket.bufferedAmount = 100000;
  assert.equal(w.headland.send({ k: 'drive', robot: 'weeder-01', v: 1, w: 0, tick: 'x' }), false);
});

test('while the page holds control it says so once a second, and stops at once when it does not', () => {
  const w = new World();
  w.connect();
  w.headland.setControl('weeder-01');
  w.run(5000);
  const during = w.sent('here').length;
  assert.ok(during >= 5 && during <= 7, String(during));
  assert.ok(w.sent('here').every((f) => f.robot === 'weeder-01' && f.tick.startsWith('boot1-')));
  w.headland.setControl(null);
  w.run(3000);
  assert.equal(w.sent('here').length, during);
});

test('no here is made without a fresh tick, so that nobody else can make one', () => {
  const w = new World();
  w.connect();
  w.headland.setControl('weeder-01');
  w.run(1000);
  const before = w.sent('here').length;
  w.advance(6000);
  assert.ok(w.sent('here').length - before <= 2);
});

test('the round trip is measured once a second and tells how far behind we are', () => {
  const w = new World();
  w.connect();
  w.run(1100);
  const ping = w.sent('ping').at(-1);
  assert.ok(Math.abs(ping.m - w.m) <= 200);
  w.advance(40);
  w.socket.say({ k: 'pong', n: ping.n, m: w.m });
  assert.ok(w.headland.rtt() >= 40 && w.headland.rtt() <= 140, String(w.headland.rtt()));
  w.socket.fail();
  assert.equal(w.headland.rtt(), null);
});

test('ages count what the fastest frame was under way: half of the shortest round trip', () => {
  const w = new World();
  w.connect();
  w.run(1000);
  const answer = (ping) => w.socket.say({ k: 'pong', n: ping.n, m: w.m });
  w.offset -= 60; // 60 ms each way: what arrives is as old
  for (let i = 0; i < 700; i++) { w.advance(100); w.tick(); } // the whole window
  const ping = w.sent('ping').at(-1);
  const at = w.m;
  w.advance(120 - (w.m - at) % 120);
  w.socket.sent.length = 0;
  w.advance(1000);
  const late = w.sent('ping').at(-1);
  w.advance(120);
  answer(late);
  const rtt = w.headland.rtt();
  assert.ok(rtt >= 120 && rtt < 1200, `${ping.n} ${rtt}`);
  assert.ok(Math.abs(w.headland.age(w.m - 1000) - (1 + rtt / 2000)) < 0.011, String(w.headland.age(w.m - 1000)));
  w.socket.fail();
  assert.equal(w.headland.rtt(), null);
});

test('a command carries a fresh tick, a fresh id and the CSRF header', async () => {
  const w = new World();
  w.connect();
  const answer = await w.headland.command('weeder-01', 'start', { mission_id: 'm-1' });
  assert.equal(answer.outcome, 'accepted');
  const request = w.requests[0];
  assert.equal(request.url, '/api/v1/robots/weeder-01/commands');
  assert.equal(request.method, 'POST');
  assert.equal(request.headers['X-Headland-CSRF'], 'csrf-1');
  const body = JSON.parse(request.body);
  assert.equal(body.tick, 'boot1-1');
  assert.match(body.command_id, /^[0-9a-f]{32}$/);
  assert.equal(body.mission_id, 'm-1');
});

test('a command while the server is lost is refused at once and never sent', async () => {
  const w = new World();
  w.connect();
  w.run(500);
  w.advance(4000);
  const answer = await w.headland.command('weeder-01', 'start');
  assert.equal(answer.outcome, 'rejected');
  assert.equal(answer.code, 'server_lost');
  w.tick();
  w.run(2000);
  assert.equal(w.requests.length, 0);
});

test('a command without an answer in 3 s is unknown', async () => {
  const w = new World();
  w.connect();
  w.respond = (_url, { signal }) => new Promise((_, reject) => signal.addEventListener('abort', () => reject(new Error('aborted'))));
  const pending = w.headland.command('weeder-01', 'pause');
  w.run(2900);
  assert.equal(w.requests[0].signal.aborted, false);
  w.run(200);
  const answer = await pending;
  assert.equal(answer.outcome, 'unknown');
  assert.equal(answer.code, 'no_answer');
});

test('a refusal of the server is a rejection with its words', async () => {
  const w = new World();
  w.connect();
  w.respond = async () => ({ ok: false, status: 403, json: async () => ({ code: 'forbidden', text: 'Driving needs the operator role.' }) });
  const answer = await w.headland.command('weeder-01', 'start');
  assert.equal(answer.outcome, 'rejected');
  assert.equal(answer.text, 'Driving needs the operator role.');
});

test('a server error leaves the outcome unknown', async () => {
  const w = new World();
  w.connect();
  w.respond = async () => ({ ok: true, status: 200, json: async () => { throw new Error('cut off'); } });
  assert.deepEqual([(await w.headland.api('GET', '/missions')).ok, (await w.headland.api('GET', '/missions')).code], [false, 'no_connection']);
  w.respond = async () => ({ ok: true, status: 204, json: async () => { throw new Error('empty'); } });
  assert.equal((await w.headland.api('DELETE', '/x')).ok, true);
  w.respond = async () => ({ ok: false, status: 502, json: async () => { throw new Error('no json'); } });
  assert.equal((await w.headland.command('weeder-01', 'start')).outcome, 'unknown');
});

test('bye ends the lane for good and is told to the page', () => {
  const w = new World();
  w.connect();
  w.socket.say({ k: 'bye', code: 'signed_out', text: 'You signed out.' });
  w.socket.fail(4401);
  w.advance(20000);
  assert.equal(w.sockets.length, 1);
  assert.equal(w.headland.link(), 'server-lost');
  assert.deepEqual(w.events.filter(([n]) => n === 'headland:bye').map(([, d]) => d.code), ['signed_out']);
});

test('presses made while the page socket is down are dropped, everything else passes', () => {
  const w = new World();
  const emitted = [];
  w.window.socket = { connected: false, sendBuffer: [], emit: (...args) => emitted.push(args[0]), on: () => {} };
  w.advance(200);
  w.window.socket.emit('event', {});
  w.window.socket.emit('handshake', {});
  w.window.socket.connected = true;
  w.window.socket.emit('event', {});
  assert.deepEqual(emitted, ['handshake', 'event']);
});

test('presses that were buffered when the page socket fell are thrown away', () => {
  const w = new World();
  let fall;
  w.window.socket = { connected: true, emit: () => {}, on: (name, fn) => { if (name === 'disconnect') fall = fn; },
    sendBuffer: [{ data: ['event', {}] }, { data: ['handshake', {}] }] };
  w.advance(200);
  fall();
  assert.deepEqual(w.window.socket.sendBuffer.map((p) => p.data[0]), ['handshake']);
});

test('a listener that fails harms no other', () => {
  const w = new World();
  w.window.console = { error: () => {} };
  const heard = [];
  w.headland.on('event', () => { throw new Error('no'); });
  w.headland.on('event', (d) => heard.push(d.kind));
  w.connect();
  w.socket.say({ k: 'event', d: { kind: 'lease' } });
  assert.deepEqual(heard, ['lease']);
});

test('what is no JSON is ignored', () => {
  const w = new World();
  w.connect();
  w.socket.onmessage({ data: '{' });
  w.socket.onmessage({ data: new ArrayBuffer(3) });
  assert.equal(w.headland.link(), 'ok');
});

test('an alarm that is normal again leaves the list, the others and the summary stay', () => {
  const w = new World();
  const heard = [];
  w.headland.on('alarms', (state, topic, changed) => heard.push(changed && Array.from(changed)));
  w.connect();
  assert.ok(w.sent('sub').at(-1).topics.includes('alarms'));
  const summary = { counts: { 1: [0, 0] }, flood: null, checked: 1 };
  w.socket.say({ k: 'snap', rev: 5, d: { alarms: { alarms: { 'link-lost.weeder-01': { priority: 2 }, 'disk-full.console': { priority: 2 } }, summary } } });
  w.socket.say({ k: 'delta', rev: 6, d: { alarms: { alarms: { 'link-lost.weeder-01': null }, summary: { ...summary, checked: 2 } } } });
  assert.equal(JSON.stringify(w.headland.state('alarms').alarms), '{"disk-full.console":{"priority":2}}');
  assert.equal(w.headland.state('alarms').summary.checked, 2);
  assert.deepEqual(heard, [null, ['link-lost.weeder-01']]);
});

test('a delta of the fleet carries only what changed of a robot; the rest stays', () => {
  const w = new World();
  w.connect();
  w.headland.on('fleet', () => {});
  w.socket.say({ k: 'snap', rev: 1, d: { fleet: { robots: { a: { n: 3, name: 'Weeder 01', mode: 'auto', task: 'Row 1/9' } }, beats: { a: [w.m - 700, 80] } } } });
  const before = w.headland.state('fleet').robots.a;
  w.socket.say({ k: 'delta', rev: 2, d: { fleet: { robots: { a: { task: 'Row 2/9' } } } } });
  const now = w.headland.state('fleet').robots.a;
  assert.deepEqual([now.name, now.mode, now.task, now.rtt_ms], ['Weeder 01', 'auto', 'Row 2/9', 80]);
  assert.notEqual(now, before, 'who compares entries sees that it is another one');
  w.socket.say({ k: 'delta', rev: 3, d: { fleet: { robots: { a: null } } } });
  assert.equal(w.headland.state('fleet').robots.a, undefined);
});
