// Runs before viser's client inside the twin's frame. viser has no embedding interface: each point here closes one gap,
// and tests/hmi/app/test_viser_page.py and tests/e2e fail when viser's client changes under it.
(() => {
  "use strict";
  const BEAT_MS = 250; // how often the page around is told how old the picture is
  const RETRY_MS = 400; // viser itself tries once a second
  const ATTEMPT_MS = 6000; // viser gives an attempt up after five seconds
  const query = new URLSearchParams(location.search);
  const nonce = document.currentScript.nonce;
  const state = { isConnected: false, heardAt: null, frames: 0, worker: null, triedAt: null, rounds: null };
  const tell = (message) => parent !== window && parent.postMessage({ from: "headland-twin", ...message }, location.origin);

  // 1. An unfocused frame would never reconnect and would go on showing a frozen robot.
  document.hasFocus = () => true;

  // 2. The worker holds the socket: its messages tell whether the picture is connected and how old it is.
  // 5. The worker's way out: a request for a public tunnel never leaves the page.
  const RealWorker = window.Worker;
  window.Worker = class extends RealWorker {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", (event) => {
        const kind = event.data?.type;
        if (kind !== "connected" && kind !== "closed" && kind !== "message_batch") return;
        state.worker = this;
        if (kind !== "message_batch") state.triedAt = null;
        if (kind === "message_batch") {
          state.frames += 1;
          event.data.messages?.forEach(machine);
        } else [state.isConnected, state.rounds] = [kind === "connected", null];
        if (kind !== "closed") state.heardAt = performance.now();
        if (kind !== "message_batch") beat();
      });
    }
    postMessage(message, ...rest) {
      if (message?.type === "set_server") {
        const scheme = location.protocol === "https:" ? "wss:" : "ws:";
        message = { ...message, server: `${scheme}//${location.host}/viser?viewer=${query.get("viewer")}` };
        state.worker = this;
        state.triedAt = performance.now();
      }
      // a try ends the one before it: on a link where opening takes longer than the pause between two, none would succeed
      if (message?.type === "retry") {
        if (state.triedAt !== null && performance.now() - state.triedAt < ATTEMPT_MS) return;
        state.triedAt = performance.now();
      }
      if (message?.type === "send" && /^ShareUrl/.test(message.message?.type)) return;
      super.postMessage(message, ...rest);
    }
  };
  // The robot's frame and shapes came; a few rounds later they are in the picture, until then it is bare ground.
  const SHOWN_ROUNDS = 4;
  const body = `/machine/${query.get("robot")}`;
  function machine({ type, name }) {
    const isFrame = type === "FrameMessage" && name === body && state.rounds === null;
    if (isFrame || (type === "GlbMessage" && name.startsWith(`${body}/`))) state.rounds = 0;
  }
  function beat() {
    const ageMs = state.heardAt === null ? null : Math.round(performance.now() - state.heardAt);
    tell({ kind: "beat", isConnected: state.isConnected, ageMs, frames: state.frames, hasModel: state.rounds >= SHOWN_ROUNDS });
  }
  setInterval(beat, BEAT_MS);
  setInterval(() => !state.isConnected && state.worker?.postMessage({ type: "retry" }), RETRY_MS);

  // 4. A touch is captured by the canvas, and then viser never sees it end: taps would do nothing.
  addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch" && event.target.hasPointerCapture?.(event.pointerId)) event.target.releasePointerCapture(event.pointerId);
  }, true);

  // 6. viser's loader makes a script element; the page's policy wants the nonce on it.
  const make = document.createElement.bind(document);
  document.createElement = (name, options) => {
    const node = make(name, options);
    if (nonce && String(name).toLowerCase() === "script") node.nonce = nonce;
    return node;
  };

  // 7. The keys of STOP work wherever the focus is.
  addEventListener("keydown", (event) => {
    const isStop = event.key === "Pause" || event.code === "Pause" || (event.ctrlKey && (event.key === "." || event.code === "Period"));
    if (!isStop || parent === window) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const { key, code, ctrlKey, repeat } = event;
    parent.dispatchEvent(new parent.KeyboardEvent("keydown", { key, code, ctrlKey, repeat, bubbles: true, cancelable: true }));
  }, true);

  // 8. The picture and STOP share one thread. A machine that draws slower than 20 times a second gets as long a pause
  // after each frame as the frame took, so that half of its time is left for everything else.
  const realFrame = window.requestAnimationFrame.bind(window);
  const SMOOTH_MS = 50;
  const PAUSE_MS = 1500; // drawn in software, beside others, one frame may take a second
  const draws = new Map();
  let count = 0;
  let usualMs = 0;
  let begunAt = null;
  let isAsked = false;
  function frame(time) {
    const now = performance.now();
    if (begunAt !== null) {
      usualMs += (Math.min(now - begunAt, PAUSE_MS) - usualMs) * 0.2; // until the browser was ready for another one
      begunAt = null;
      if (usualMs > SMOOTH_MS) return void setTimeout(realFrame, Math.min(usualMs, PAUSE_MS), frame);
    }
    isAsked = false;
    if (state.rounds !== null) state.rounds += 1;
    const round = [...draws.values()];
    draws.clear();
    begunAt = performance.now();
    for (const draw of round) {
      try {
        draw(time);
      } catch (error) {
        reportError(error);
      }
    }
    if (!isAsked) begunAt = null; // nobody wants a next one: the time until then says nothing
  }
  window.requestAnimationFrame = (draw) => {
    draws.set((count += 1), draw);
    if (!isAsked) realFrame(frame);
    isAsked = true;
    return count;
  };
  window.cancelAnimationFrame = (id) => void draws.delete(id);

  // The camera belongs to the person while they turn it.
  let down = 0;
  const hold = (isOn) => tell({ kind: "hold", isOn });
  addEventListener("pointerdown", () => (down += 1) === 1 && hold(true), true);
  for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => (down = Math.max(0, down - 1)) === 0 && hold(false), true);
  let spun = 0;
  const nudge = () => performance.now() - spun > 200 && ((spun = performance.now()), hold(down > 0));
  addEventListener("wheel", nudge, { capture: true, passive: true });
  addEventListener("keydown", (event) => {
    if (/^Arrow/.test(event.key)) nudge();
    if ("+-0".includes(event.key) && event.key.length === 1) tell({ kind: "key", key: event.key });
  }, true);

  addEventListener("message", (event) => {
    if (event.source === parent && event.origin === location.origin && event.data?.kind === "theme") document.documentElement.dataset.theme = event.data.theme;
  });
  // a canvas measured while the page around was still moving keeps its first size on a slow machine
  new ResizeObserver(() => setTimeout(() => dispatchEvent(new Event("resize")), 300)).observe(document.documentElement);

  // a tablet takes the graphics away when it needs them itself, and what is left is an empty picture
  addEventListener("webglcontextlost", () => tell({ kind: "lost" }), true);
  addEventListener("webglcontextrestored", () => tell({ kind: "restored" }), true);

  // without WebGL the frame has nothing to show; the page around shows the map instead
  const gl = make("canvas").getContext("webgl2") || make("canvas").getContext("webgl");
  if (!gl) tell({ kind: "no-webgl" });

  // 9. Where the processor draws, each pixel is taken from everything else: viser is asked for coarser ones,
  // which shows two to three times as many pictures.
  // The names are those of static/js/map/webgl.js.
  const COARSE = "0.6";
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const renderer = gl ? String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER)) : "";
  if (/swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer)) {
    query.set("fixedDpr", COARSE);
    history.replaceState(history.state, "", `${location.pathname}?${query}`);
  }
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  tell({ kind: "ready" });
})();
