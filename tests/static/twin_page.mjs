// A page for the twin's scripts without a browser: a clock that is told, sockets that are looked at.
import { readFileSync } from "node:fs";
import vm from "node:vm";

const read = (name) => readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), "utf-8");

export function load() {
  let now = 0;
  const sockets = [];
  const listeners = [];
  const timers = [];
  class WebSocket {
    constructor(url) {
      Object.assign(this, { url, readyState: 1, bufferedAmount: 0, sent: [] });
      sockets.push(this);
    }
    send(text) {
      this.sent.push(text);
    }
    close() {}
  }
  const frame = (source) => ({ contentWindow: source });
  const location = { protocol: "http:", host: "console.local", origin: "http://console.local" };
  const HL = { el: () => ({}), icon: () => ({}), text() {}, attr() {}, toggle() {}, repaint() {}, words: { age: (ms) => `${(ms / 1000).toFixed(1)} s` } };
  const context = vm.createContext({
    HL, WebSocket, location, setTimeout: (call) => timers.push(call), setInterval: () => 0, clearInterval() {}, console, encodeURIComponent,
    performance: { now: () => now }, addEventListener: (kind, call) => listeners.push(call), removeEventListener() {},
    window: { headland: { uuid: () => "0123456789abcdef0123456789abcdef" } },
  });
  for (const name of ["twin_link", "twin_replay"]) vm.runInContext(read(name), context);
  return {
    HL, frame,
    ring: () => timers.splice(0).forEach((call) => call()),
    pass: (ms) => (now += ms),
    socket: () => sockets.at(-1),
    say: (data, { source = "frame", origin = location.origin } = {}) => listeners.forEach((call) => call({ data, source, origin })),
  };
}
