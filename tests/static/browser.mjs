// A browser reduced to what lane.js needs, on clocks that only tests move.
import fs from 'node:fs';
import vm from 'node:vm';

const SOURCE = fs.readFileSync(new URL('../../static/js/lane.js', import.meta.url), 'utf8');

export class FakeSocket {
  constructor(world, url) { this.world = world; this.url = url; this.readyState = 0; this.bufferedAmount = 0; this.sent = []; }
  send(text) { if (this.readyState !== 1) throw new Error('not open'); this.sent.push(JSON.parse(text)); }
  close() { this.readyState = 3; }
  open() { this.readyState = 1; this.onopen?.(); }
  fail(code = 1006) { this.readyState = 3; this.onclose?.({ code }); }
  say(frame) { this.onmessage?.({ data: frame instanceof ArrayBuffer ? frame : JSON.stringify(frame) }); }
}

export class World {
  constructor(config = { csrf: 'csrf-1' }) {
    this.t = 1000;                 // performance.now() of the browser
    this.offset = 500000;          // console monotonic ms - performance.now()
    this.ticks = 0;
    this.sockets = [];
    this.timers = [];
    this.events = [];
    this.requests = [];
    this.respond = async () => ({ ok: true, status: 200, json: async () => ({ outcome: 'accepted' }) });
    const world = this;
    const window = {
      HEADLAND: config,
      location: { protocol: 'http:', host: 'farm:8080' },
      performance: { now: () => world.t },
      WebSocket: class extends FakeSocket { constructor(url) { super(world, url); world.sockets.push(this); } },
      setInterval: (fn, ms) => { const timer = { fn, ms, due: world.t + ms, every: true }; world.timers.push(timer); return timer; },
      setTimeout: (fn, ms) => { const timer = { fn, ms, due: world.t + ms }; world.timers.push(timer); return timer; },
      clearTimeout: (timer) => { world.timers = world.timers.filter((x) => x !== timer); },
      fetch: (url, options) => { world.requests.push({ url, ...options }); return world.respond(url, options); },
      dispatchEvent: (event) => { world.events.push([event.type, event.detail]); },
      addEventListener: () => {},
      CustomEvent: class { constructor(type, init) { this.type = type; this.detail = init.detail; } },
      crypto: { getRandomValues: (a) => { for (let i = 0; i < a.length; i++) a[i] = (world.random = (world.random ?? 7) * 31 % 251); return a; } },
      AbortController, DataView, Uint8Array, console,
    };
    window.window = window;
    this.window = window;
    vm.runInContext(SOURCE, vm.createContext(window));
    this.headland = window.headland;
  }
  get socket() { return this.sockets.at(-1); }
  get m() { return this.t + this.offset; }
  advance(ms) {
    const end = this.t + ms;
    for (;;) {
      const next = this.timers.filter((x) => x.due <= end).sort((a, b) => a.due - b.due)[0];
      if (!next) break;
      this.t = Math.max(this.t, next.due);
      if (next.every) next.due += next.ms; else this.timers = this.timers.filter((x) => x !== next);
      next.fn();
    }
    this.t = end;
  }
  connect(boot = 'boot1') {
    this.socket.open();
    this.socket.say({ k: 'hello', boot, user: { id: 'martha', name: 'Martha', role: 'operator' }, device: {} });
    this.boot = boot;
    this.tick();
    return this.socket;
  }
  tick(late = 0) {
    this.ticks += 1;
    this.socket.say({ k: 'tick', id: `${this.boot}-${this.ticks}`, m: this.m - late, stop: 'up', keeper: [] });
  }
  run(ms) { for (let left = ms; left > 0; left -= 100) { this.advance(Math.min(100, left)); if (this.socket.readyState === 1) this.tick(); } }
  sent(kind) { return this.sockets.flatMap((s) => s.sent).filter((f) => f.k === kind); }
}
