// The pure parts of the camera scripts, without a browser.
import { readFileSync } from "node:fs";
import vm from "node:vm";

const read = (path) => readFileSync(new URL(`../../static/js/${path}.js`, import.meta.url), "utf-8");

export function load() {
  const HL = { el: () => ({}), icon: () => ({}), text() {}, attr() {}, toggle() {}, repaint() {}, LiveElement: class {} };
  const context = vm.createContext({ HL, console });
  for (const path of ["ui/words", "ui/fleet_order", "camera/ways", "camera/sight", "camera/says", "camera/order"]) vm.runInContext(read(path), context);
  return HL;
}

// The socket of a page on a clock that tests move: {camera, sockets, pass(ms)}.
export function loadSocket() {
  let now = 0;
  let timers = [];
  const sockets = [];
  class WebSocket {
    constructor(url) {
      Object.assign(this, { url, readyState: 0, sent: [] });
      sockets.push(this);
    }
    send(text) {
      this.sent.push(JSON.parse(text));
    }
    close() {
      this.readyState = 3;
    }
    greet(watcher = "token") {
      this.readyState = 1;
      this.onopen?.();
      this.onmessage({ data: JSON.stringify({ k: "hello", watcher, m: 5 }) });
    }
  }
  const later = (every) => (call, ms) => {
    const timer = { call, ms, due: now + ms, every };
    timers.push(timer);
    return timer;
  };
  const forget = (timer) => (timers = timers.filter((one) => one !== timer));
  const HL = { config: {}, camera: {} };
  const context = vm.createContext({ HL, WebSocket, DataView, Uint8Array, location: { protocol: "https:", host: "farm" }, performance: { now: () => now }, Math: Object.assign(Object.create(Math), { random: () => 0.5 }), setTimeout: later(false), setInterval: later(true), clearTimeout: forget, clearInterval: forget, JSON, Map, Object });
  vm.runInContext(read("camera/socket"), context);
  function pass(ms) {
    const end = now + ms;
    for (;;) {
      const [next] = timers.filter((one) => one.due <= end).sort((a, b) => a.due - b.due);
      if (!next) break;
      now = next.due;
      if (next.every) next.due += next.ms;
      else forget(next);
      next.call();
    }
    now = end;
  }
  return { socket: HL.camera.socket, sockets, pass };
}
