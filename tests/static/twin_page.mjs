// A page for the twin's scripts without a browser: a clock that is told, sockets that are looked at.
import { readFileSync } from "node:fs";
import vm from "node:vm";

// the shape of the sign, by the signature of glyphs.js
function alarm(level, size = 26, state = "acknowledged") {
  if (typeof size !== "number") throw new TypeError(`a size of ${size}`);
  return { level, size, state: state.replaceAll("_", " ") };
}

const read = (name) => readFileSync(new URL(`../../static/js/ui/${name}.js`, import.meta.url), "utf-8");

class Node {
  constructor(tag, values, children) {
    Object.assign(this, { tag, children, dataset: {}, hidden: "hidden" in values, said: "", values: { ...values } });
    for (const [name, value] of Object.entries(values)) if (name.startsWith("data-")) this.dataset[name.slice(5)] = value;
  }
  replaceChildren(...children) {
    this.children = children;
  }
}

class Slide {
  constructor(options) {
    Object.assign(this, options, { node: new Node("slide", {}, []) });
  }
  allow(off, line) {
    Object.assign(this, { off, line });
  }
  drop() {}
}

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
  const answers = [];
  const toasts = [];
  const HL = {
    el: (tag, values, ...children) => new Node(tag, values, children), icon: () => new Node("icon", {}, []), text: (node, said) => (node.said = said),
    attr: (node, name, value) => (node.values[name] = value), toggle() {}, style() {}, repaint() {}, alarm, toast: (said) => toasts.push(said), Slide,
    words: { age: (ms) => `${(ms / 1000).toFixed(1)} s` }, config: { rights: ["drive"] }, superDock: { refusal: () => "" },
    port: { api: () => new Promise((done) => answers.push(done)), inside: () => ({}), robot: () => ({ id: { family: "planter" } }) },
  };
  const context = vm.createContext({
    HL, WebSocket, location, setTimeout: (call) => timers.push(call), setInterval: () => 0, clearInterval() {}, console, encodeURIComponent,
    performance: { now: () => now }, addEventListener: (kind, call) => listeners.push(call), removeEventListener() {},
    window: { headland: { uuid: () => "0123456789abcdef0123456789abcdef" } },
  });
  for (const name of ["twin_link", "twin_replay", "twin_details", "twin_joints"]) vm.runInContext(read(name), context);
  return {
    HL, frame, toasts,
    answer: async (data, isOk = true) => {
      answers.shift()({ ok: isOk, data });
      await new Promise((done) => setImmediate(done));
    },
    beat: (more = {}) => listeners.forEach((call) => call({ data: { from: "headland-twin", kind: "beat", isConnected: true, ageMs: 100, frames: 3, hasModel: true, ...more }, source: "frame", origin: location.origin })),
    status: (more = {}) => sockets.at(-1).onmessage({ data: JSON.stringify({ k: "status", is_drawn: true, pose_age_s: 0.1, ages_s: {}, is_past: false, past_ms: null, touched: null, ...more }) }),
    orders: () => sockets.at(-1).sent.map((text) => JSON.parse(text)),
    ring: () => timers.splice(0).forEach((call) => call()),
    pass: (ms) => (now += ms),
    socket: () => sockets.at(-1),
    say: (data, { source = "frame", origin = location.origin } = {}) => listeners.forEach((call) => call({ data, source, origin })),
  };
}
