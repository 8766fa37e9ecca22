// The page's one socket for pictures: streams by number, answers by number, and the proof that the page still lives.
(() => {
  "use strict";
  const PING_MS = 500; // the server lets go of a page that is silent for 1.5 s
  const DEAD_MS = 3000; // pings unanswered for so long: the socket is dead, whatever the browser believes
  const BACKOFF_MS = [200, 400, 800, 1500, 2500];
  const LINGER_MS = 2000; // going from screen to screen opens no new socket
  const MOST = 64;
  const HEAD = 24;
  const MAGIC = 0x31434c48; // "HLC1"

  const streams = new Map(); // number -> {robot, camera, way, width, fps, on: {frame, times, state, refused, up, down}}
  let socket = null;
  let watcher = null;
  let attempt = 0;
  let heardAt = 0;
  let timer = null;
  let closing = null;
  let waiting = null;

  const url = () => `${location.protocol === "https:" ? "wss:" : "ws:"}//${location.host}${HL.config.cameraPath || "/cameras/live"}`;
  const isOpen = () => socket !== null && socket.readyState === 1;

  function say(frame) {
    if (isOpen()) socket.send(JSON.stringify(frame));
  }

  function ask(n, { robot, camera, way, width, fps }) {
    if (watcher) say({ k: "watch", n, robot, camera, way, width, fps });
  }

  function connect() {
    waiting = null;
    if (socket || !streams.size) return;
    let mine;
    try {
      mine = new WebSocket(url());
    } catch {
      return retry();
    }
    socket = mine;
    mine.binaryType = "arraybuffer";
    mine.onopen = () => (heardAt = performance.now());
    mine.onmessage = (message) => socket === mine && hear(message.data);
    mine.onclose = (event) => socket === mine && lost(event.code);
    heardAt = performance.now();
    timer ??= setInterval(beat, PING_MS);
    return undefined;
  }

  function beat() {
    if (performance.now() - heardAt > DEAD_MS) return lost();
    return say({ k: "ping", m: Math.round(performance.now()) });
  }

  function lost(code) {
    const old = socket;
    socket = null;
    watcher = null;
    clearInterval(timer);
    timer = null;
    if (old) old.onclose = old.onmessage = null;
    old?.close();
    for (const stream of streams.values()) stream.on.down();
    if (code !== 4401) retry();
  }

  function retry() {
    if (waiting || !streams.size) return;
    waiting = setTimeout(connect, BACKOFF_MS[Math.min(attempt, BACKOFF_MS.length - 1)] * (0.75 + Math.random() * 0.5));
    attempt += 1;
  }

  function hear(data) {
    heardAt = performance.now();
    if (typeof data !== "string") return picture(data);
    const frame = JSON.parse(data);
    if (frame.k === "hello") return greet(frame);
    const stream = streams.get(frame.n);
    if (!stream) return undefined;
    if (frame.k === "state") return stream.on.state(frame.camera);
    if (frame.k === "times") return stream.on.times(frame.p);
    if (frame.k === "refused") return stream.on.refused(frame.text || frame.code);
    return undefined;
  }

  function greet(frame) {
    ({ watcher } = frame);
    attempt = 0;
    for (const [n, stream] of streams) {
      ask(n, stream);
      stream.on.up();
    }
  }

  function picture(buffer) {
    if (buffer.byteLength <= HEAD) return;
    const view = new DataView(buffer);
    if (view.getUint32(0, true) !== MAGIC) return;
    const stream = streams.get(view.getUint8(4));
    stream?.on.frame({
      isDated: Boolean(view.getUint8(5) & 1), width: view.getUint16(6, true), captured: view.getFloat64(8, true), seq: view.getUint32(16, true), height: view.getUint16(20, true),
      jpeg: new Uint8Array(buffer, HEAD),
    });
  }

  // -> number of the stream; null when the page watches as much as it may
  function watch(stream) {
    clearTimeout(closing);
    let n = 1;
    while (streams.has(n)) n += 1;
    if (n > MOST) return null;
    streams.set(n, stream);
    if (socket) ask(n, stream);
    else if (!waiting) connect();
    return n;
  }

  function change(n, wish) {
    const stream = streams.get(n);
    if (!stream || Object.entries(wish).every(([key, value]) => stream[key] === value)) return;
    Object.assign(stream, wish);
    ask(n, stream);
  }

  function drop(n) {
    if (!streams.delete(n)) return;
    say({ k: "drop", n });
    clearTimeout(closing);
    if (!streams.size) closing = setTimeout(close, LINGER_MS);
  }

  function close() {
    if (streams.size) return;
    clearTimeout(waiting);
    waiting = null;
    clearInterval(timer);
    timer = null;
    const old = socket;
    socket = null;
    watcher = null;
    if (old) old.onclose = old.onmessage = null;
    old?.close();
  }

  // from the first one on only two pictures are under way: a slow line then shows the newest, not what buffers hold
  const seen = (n, seq) => streams.has(n) && say({ k: "seen", n, seq });

  Object.assign(HL.camera, { socket: { watch, change, drop, seen, watcher: () => watcher, again: (n) => streams.has(n) && ask(n, streams.get(n)), count: () => streams.size } });
})();
