// STOP in the browser. Plain scripts, no framework: works while the console, its page framework or its network is dead.
//
//   headlandStop.configure({base, port, consoleBase, token, csrf, scope, note})   any of them, at any time
//   headlandStop.setScope({kind: "robot", id, name} | {kind: "all"})              at each change of screen
//   headlandStop.press(scope?)  .state()  .banner()  .renderSteps(element, {robot}?)  .silence(ms)
//   window event "headland:stop": detail = state(), at every change but the running of times
//
// A step in `state().steps` is the step of docs/protocols/stop.md with the state this browser stands for, and
// `at` and `heard_at` (performance.now of press and newest evidence) and `is_mine`.
(() => {
  "use strict";
  if (window.headlandStop) return;
  const { Presses, GatewaySocket, Sound, Slab, toGateway, toConsole, words, WORST, ANY } = window.headlandStopParts;
  const LOST_MS = 3500; // as for every stream of 2 Hz and more
  const RETRY_MS = 1000;
  const FAILED_RETRY_MS = 200;
  const HOPELESS_MS = 3000; // a path missing for this long is missing; before, the page may just have opened
  const KEEP_OUT_M = 15;
  const TOKEN_KEY = "headland.stop_token";
  const PENDING_KEY = "headland.stop_pending";
  const CARDS_KEY = "headland.stop_robots";

  const config = { base: "", port: 0, consoleBase: "", token: "", csrf: "", note: "", scope: { kind: "all" } };
  const given = {}; // what the shell said, which outranks what the page was served with
  const presses = new Presses();
  const robots = new Map(); // id -> line of the newest hb, with `at`
  let cards = read(localStorage, CARDS_KEY, {});
  let hello = { device: "", user: "" };
  let helloAt = -Infinity;
  let isReconciled = true;
  let pathLostAt = performance.now();
  let signature = "";
  let summary = null;
  const mounted = new Map(); // element -> options of renderSteps

  function read(store, key, fallback) {
    try {
      return JSON.parse(store.getItem(key)) ?? fallback;
    } catch {
      return fallback;
    }
  }
  function write(store, key, value) {
    try {
      store.setItem(key, JSON.stringify(value));
    } catch {
      // a full or forbidden store costs comfort, not STOP
    }
  }
  function keptToken() {
    try {
      return localStorage.getItem(TOKEN_KEY) || "";
    } catch {
      return "";
    }
  }
  const token = () => config.token || keptToken();
  const base = () => config.base || (config.port ? `${location.protocol}//${location.hostname}:${config.port}` : "");

  // ---- link -------------------------------------------------------------------------------------------
  const socket = new GatewaySocket({
    hello(frame) {
      if (hello.boot !== frame.boot) presses.forgetAges("gateway");
      hello = frame;
      [helloAt, isReconciled] = [performance.now(), false];
      for (const press of presses.open(helloAt, true)) sendBySocket(press);
    },
    beat(frame) {
      const now = performance.now();
      if (frame.robots) {
        for (const id of [...robots.keys()]) if (!(id in frame.robots)) robots.delete(id);
        for (const [id, line] of Object.entries(frame.robots)) robots.set(id, { ...line, at: now });
      }
      if (!isReconciled) [isReconciled] = [true, presses.reconcile(helloAt)];
      paint();
    },
    frame(frame) {
      if (frame.k === "step") take([frame], "gateway");
      else if (frame.k === "robots") write(localStorage, CARDS_KEY, (cards = frame.robots));
      paint();
    },
    refused: () => paint(),
  });

  const sendBySocket = (press) => socket.send({ k: "stop", stop_id: press.id, robots: press.robots });

  function take(steps, source, press) {
    const now = performance.now();
    for (const step of steps) presses.take(step, source, now);
    if (press && !steps.length) presses.take({ stop_id: press.id, robot: ANY, state: "reset" }, source, now); // no robots at all
    remember();
  }

  function sendByHttp(press) {
    const tries = [
      [base() && token(), "gateway", () => toGateway(base(), token(), press)],
      [true, "console", () => toConsole(config.consoleBase, token(), press, config.csrf)],
    ];
    for (const [isPossible, source, send] of tries) {
      if (!isPossible) continue;
      send().then(
        (steps) => (take(steps, source, press), paint()),
        () => (press.retryAt = Math.min(press.retryAt, performance.now() + FAILED_RETRY_MS)),
      );
    }
  }

  // ---- press ------------------------------------------------------------------------------------------
  function press(scope = config.scope) {
    const now = performance.now();
    const wanted = scope.kind === "robot" && scope.id ? [scope.id] : "all";
    const isHopeless = !token() || (!socket.isFresh(now) && now - pathLostAt > HOPELESS_MS);
    const made = presses.press(wanted, [...robots.keys()], now, { by: hello.user || hello.device, device: hello.device, isHopeless, cards });
    sendBySocket(made);
    made.retryAt = now + RETRY_MS;
    sendByHttp(made);
    navigator.vibrate?.(60);
    remember();
    paint();
    return made.id;
  }

  // A reload must not forget a press that is not confirmed.
  function remember() {
    const now = performance.now();
    write(sessionStorage, PENDING_KEY, presses.open(now, true).map((p) => ({ id: p.id, robots: p.robots, wall: Date.now() - (now - p.at) })));
  }
  function recall() {
    for (const { id, robots: ids, wall } of read(sessionStorage, PENDING_KEY, [])) {
      const agoMs = Math.max(0, Date.now() - wall);
      presses.press(ids, [], performance.now(), { id, agoMs, cards }).retryAt = 0;
    }
  }

  function retry(now) {
    for (const one of presses.open(now, socket.isFresh(now))) {
      if (now < one.retryAt) continue;
      one.retryAt = now + (presses.isConfirmed(one) ? 2 * RETRY_MS : RETRY_MS);
      sendByHttp(one);
    }
  }

  // ---- state ------------------------------------------------------------------------------------------
  function robotView(id, now, isFresh) {
    const line = robots.get(id);
    const card = cards[id] || {};
    const steps = presses.at(id, now, card);
    const heardMs = line && typeof line.heard_ms === "number" ? line.heard_ms + now - line.at : null;
    const isLinked = isFresh && heardMs !== null && heardMs <= LOST_MS;
    const view = {
      id, name: line?.name || card.name || (config.scope.id === id && config.scope.name) || id, robot: line, step: steps[0], steps, heardMs, isLinked,
      isEnrolled: Boolean(token()) && !socket.refusal, note: config.note, link: linkText(line),
      keep_out_m: card.keep_out_m ?? KEEP_OUT_M, contact_name: card.contact_name, contact_phone: card.contact_phone,
    };
    view.state = stateOf(view, steps, line, now, isFresh);
    const step = view.step;
    view.latchedMs = step?.standstill_ms != null ? now - step.at - step.standstill_ms : (line?.latched_ms ?? 0) + (line ? now - line.at : 0);
    return view;
  }

  function stateOf(view, steps, line, now, isFresh) {
    const worst = WORST.find((state) => steps.some((step) => step.state === state));
    if (worst && worst !== "standstill") return worst;
    if (worst && (isFresh || presses.hasEvidence(view.id, now))) return worst;
    if (!isFresh || !view.isEnrolled) return "no-path";
    if (line?.latched && view.isLinked) return line.standstill ? "standstill" : "acknowledged";
    return view.isLinked ? "ready" : "no-link";
  }

  function linkText(line) {
    if (socket.rttMs === null) return "linked";
    if (line && line.rtt_ms === null) return line.via === "http" ? "direct, no broker" : "linked";
    return `link ${Math.max(1, Math.round(socket.rttMs + (line?.rtt_ms || 0)))} ms`;
  }

  function allView(views, now, isFresh) {
    const total = views.length;
    const counted = views.filter((v) => v.state === "standstill" && v.isLinked); // an offline robot is never counted
    const failing = views.filter((v) => v.state === "not-confirmed");
    const open = views.filter((v) => v.steps.length && v.state !== "standstill");
    const isForAll = views.length > 0 && views.every((v) => v.steps.length || v.state === "standstill");
    const view = {
      total, standing: counted.length, linked: views.filter((v) => v.isLinked).length, failing: failing.map((v) => v.name),
      isEnrolled: Boolean(token()) && !socket.refusal, note: config.note, link: linkText(),
      at: Math.min(...open.map((v) => v.step.at), now),
    };
    if (failing.length) view.state = "not-confirmed";
    else if (isForAll && open.length) view.state = open.some((v) => v.state === "sent") ? "sent" : "acknowledged";
    else if (total && counted.length === total) view.state = "standstill";
    else if (!isFresh || !view.isEnrolled) view.state = "no-path";
    else view.state = view.linked ? "ready" : "no-link";
    return view;
  }

  function look(now) {
    const isFresh = socket.isFresh(now);
    if (isFresh) pathLostAt = now;
    const ids = new Set([...robots.keys(), ...presses.robots()]);
    if (config.scope.kind === "robot" && config.scope.id) ids.add(config.scope.id);
    const views = [...ids].filter((id) => id !== ANY || ids.size === 1).map((id) => robotView(id, now, isFresh));
    const all = allView(views, now, isFresh);
    const isAll = config.scope.kind !== "robot" || !config.scope.id;
    const one = isAll ? null : views.find((view) => view.id === config.scope.id);
    return { scope: config.scope, isAll, one, all, robots: views, total: all.total, state: isAll ? all.state : one.state, isFresh };
  }

  function publicState(now = performance.now()) {
    const seen = look(now);
    const plain = ({ id, name, state, isLinked, heardMs, step }) => ({ id, name, state, is_linked: isLinked, heard_ms: heardMs, step });
    return {
      state: seen.state, scope: seen.scope, is_fresh: seen.isFresh, is_enrolled: seen.all.isEnrolled, total: seen.total,
      standing: seen.all.standing, all_state: seen.all.state, failing: seen.all.failing, robots: seen.robots.map(plain),
      steps: seen.robots.flatMap((view) => view.steps), rtt_ms: socket.rttMs, device: hello.device, user: hello.user,
    };
  }

  const readyOnce = (() => {
    let done = null;
    const first = new Promise((resolve) => (done = resolve));
    const after = (ms) => new Promise((resolve) => setTimeout(resolve, Math.max(ms, 0)));
    // 150 ms more let the first values of the robot be drawn before the next download begins
    const wait = (limitMs) => Promise.race([first, after(limitMs - performance.now())]);
    return { done: () => setTimeout(done, 150), wait };
  })();

  // ---- paint ------------------------------------------------------------------------------------------
  let slab = null;
  let sound = null;

  function paint() {
    const now = performance.now();
    const before = summary;
    summary = look(now);
    slab?.draw(summary.one, summary.all, summary.isAll, now);
    const loudest = summary.all.failing.length ? "not-confirmed" : summary.state;
    const isLoss = ["no-link", "no-path"].includes(loudest); // silence is an alarm only where there was a link
    const isSame = before && before.scope === summary.scope;
    sound?.follow(loudest, now, isSame && (!isLoss || before.state === "ready" || sound.state === loudest));
    const next = JSON.stringify([summary.state, summary.scope, summary.total, summary.all.state, summary.all.standing, summary.robots.map((r) => [r.id, r.state, r.isLinked, r.steps.map((s) => [s.stop_id, s.state, s.sent_ms, s.ack_ms, s.standstill_ms, s.by, s.stopping_distance_m])])]);
    if (summary.state === "ready") readyOnce.done();
    if (next !== signature) {
      signature = next;
      window.dispatchEvent(new CustomEvent("headland:stop", { detail: publicState(now) }));
    }
    for (const [element, options] of mounted) {
      if (element.isConnected) window.headlandStopParts.card?.(element, summary, options, now);
      else if (options.wasShown) mounted.delete(element);
      options.wasShown ||= element.isConnected;
    }
  }

  function tick() {
    const now = performance.now();
    socket.use(base(), token());
    socket.tick(now);
    retry(now);
    paint();
  }

  function onKey(event) {
    const isStop = event.key === "Pause" || event.code === "Pause" || (event.ctrlKey && (event.key === "." || event.code === "Period"));
    if (!isStop || event.repeat) return;
    event.preventDefault();
    press();
  }

  function start() {
    const served = { getItem: (id) => document.getElementById(id)?.textContent };
    Object.assign(config, read(served, "headland-stop-config", {}), given);
    slab = new Slab({ onPress: () => press(), onPressAll: () => press({ kind: "all" }) });
    sound = Sound && new Sound();
    recall();
    window.addEventListener("keydown", onKey, { capture: true });
    window.addEventListener("online", () => socket.retryNow());
    document.addEventListener("visibilitychange", () => document.hidden || socket.retryNow());
    setInterval(tick, 100);
    tick();
  }

  window.headlandStop = {
    configure(values) {
      Object.assign(config, Object.assign(given, values));
      if (slab) tick();
    },
    setScope(scope) {
      config.scope = given.scope = scope;
      if (slab) paint();
    },
    press,
    state: () => publicState(),
    banner: () => words.banner(look(performance.now()), performance.now()),
    renderSteps(element, options = {}) {
      mounted.set(element, { ...options });
      paint();
    },
    // resolves when STOP has been ready once, at the latest so long after the page began: what can wait, waits for it
    whenReady: (limitMs = 1500) => readyOnce.wait(limitMs),
    silence: (forMs = 120000) => sound?.silence(performance.now(), forMs),
    sounding: () => sound?.sounding(performance.now()) ?? null,
  };
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else start();
})();
