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
  const STALE_MS = 2000; // likewise
  const RETRY_MS = 1000;
  const FAILED_RETRY_MS = 200;
  const HOPELESS_MS = 3000; // a path missing for this long is missing; before, the page may just have opened
  const KEEP_OUT_M = 15;
  const TOKEN_KEY = "headland.stop_token";
  const PENDING_KEY = "headland.stop_pending";
  const CARDS_KEY = "headland.stop_robots";
  const MANY = 50;
  const CALM_MS = 500;
  const NO_CARD = {};
  const NO_STEPS = [];

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
  let paintedAt = -Infinity;
  const mounted = new Map(); // element -> options of renderSteps
  const views = new Map(); // id -> what is shown of a robot, kept while nothing was told about it
  let changes = 0; // robots that came, went, or changed what is said of them

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
        for (const [id, line] of Object.entries(frame.robots)) robots.set(id, Object.assign(line, { at: now }));
      }
      if (!isReconciled) [isReconciled] = [true, presses.reconcile(helloAt)];
      paint();
    },
    frame(frame) {
      if (frame.k === "step") take([frame], "gateway");
      else if (frame.k === "robots") write(localStorage, CARDS_KEY, (cards = frame.robots));
      // of a large fleet the steps of STOP ALL come one by one: they are shown together, at the latest with the next tick
      if (frame.k !== "step" || robots.size <= MANY || frame.robot === config.scope.id) paint();
    },
    refused: () => paint(),
  });

  const sendBySocket = (press) => socket.send({ k: "stop", stop_id: press.id, robots: press.robots });

  function take(steps, source, press) {
    const now = performance.now();
    for (const step of steps) presses.take(step, source, now, socket.isFresh(now));
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
      one.retryAt = now + RETRY_MS; // confirmed ones too: without the gateway their proof comes from the console alone
      sendByHttp(one);
    }
  }

  // ---- state ------------------------------------------------------------------------------------------
  // With a thousand robots ten times a second: only what time alone changes is worked out each time.
  function robotView(id, steps, now, isFresh, isEnrolled) {
    const line = robots.get(id);
    const card = cards[id] || NO_CARD;
    let view = views.get(id);
    if (!view || view.robot !== line || view.card !== card || view.scope !== config.scope) {
      const name = line?.name || card.name || (config.scope.id === id && config.scope.name) || id;
      if (view?.name !== name) changes += 1;
      const { state, isLinked, isStanding } = view ?? {};
      view = { id, name, robot: line, card, scope: config.scope, state, isLinked, isStanding, keep_out_m: card.keep_out_m ?? KEEP_OUT_M, contact_name: card.contact_name, contact_phone: card.contact_phone };
      views.set(id, view);
    }
    const { state: stateBefore, isLinked: wasLinked, isStanding: wasStanding } = view;
    view.heardMs = line && typeof line.heard_ms === "number" ? line.heard_ms + now - line.at : null;
    view.isLinked = isFresh && view.heardMs !== null && view.heardMs <= LOST_MS;
    view.isEnrolled = isEnrolled;
    view.note = config.note;
    view.steps = steps;
    view.step = steps[0];
    view.state = stateOf(view, steps, line, now, isFresh);
    view.standstillMs = view.state === "standstill" ? proofMs(line, steps, now, isFresh) : 0;
    view.isOld = view.standstillMs > STALE_MS;
    view.isStanding = view.state === "standstill" && view.isLinked && !view.isOld; // who is offline or silent never counts
    if (view.state !== stateBefore || view.isLinked !== wasLinked || view.isStanding !== wasStanding) changes += 1;
    const { step } = view;
    view.latchedMs = step?.standstill_ms != null ? now - step.at - step.standstill_ms : (line?.latched_ms ?? 0) + (line ? now - line.at : 0);
    return view;
  }

  function stateOf(view, steps, line, now, isFresh) {
    const worst = steps.length ? WORST.find((state) => steps.some((step) => step.state === state)) : null;
    if (worst && worst !== "standstill") return worst;
    if (worst && (isFresh || presses.hasEvidence(steps, now))) return worst;
    if (!isFresh || !view.isEnrolled) return "no-path";
    if (line?.latched && view.isLinked) return line.standstill ? "standstill" : "acknowledged";
    return view.isLinked ? "ready" : "no-link";
  }

  // How long ago its safety controller last said that it stands; heartbeats alone prove nothing. A gateway of before
  // `safety_ms` leaves that open. Without the gateway its last word ages, unless the console has a newer one.
  function proofMs(line, steps, now, isFresh) {
    if (line ? line.safety_ms === undefined : isFresh) return 0;
    const told = !line || line.safety_ms === null ? Infinity : line.safety_ms + now - line.at;
    return steps.reduce((ms, step) => (step.state === "standstill" ? Math.min(ms, now - step.at - step.standstill_ms, now - (step.proven_at ?? -Infinity)) : ms), told);
  }

  function linkText(line) {
    if (socket.rttMs === null) return "linked";
    if (line && line.rtt_ms === null) return line.via === "http" ? "direct, no broker" : "linked";
    return `link ${Math.max(1, Math.round(socket.rttMs + (line?.rtt_ms || 0)))} ms`;
  }

  function allView(seen, now, isFresh, isEnrolled) {
    const view = { total: seen.length, standing: 0, linked: 0, failing: [], isEnrolled, note: config.note, link: linkText(), at: now };
    let [open, untouched, isSent] = [0, 0, false];
    for (const { state, isLinked, isStanding, steps, step, name } of seen) {
      if (isLinked) view.linked += 1;
      if (isStanding) view.standing += 1;
      if (state === "standstill") continue; // or stood when it was last heard: nothing is awaited of it
      if (state === "not-confirmed") view.failing.push(name);
      if (steps.length) {
        open += 1;
        isSent ||= state === "sent";
        view.at = Math.min(view.at, step.at);
      } else untouched += 1;
    }
    if (view.failing.length) view.state = "not-confirmed";
    else if (open && !untouched) view.state = isSent ? "sent" : "acknowledged";
    else if (view.total && view.standing === view.total) view.state = "standstill";
    else if (!isFresh || !view.isEnrolled) view.state = "no-path";
    else view.state = view.linked ? "ready" : "no-link";
    return view;
  }

  function look(now) {
    const isFresh = socket.isFresh(now);
    if (isFresh) pathLostAt = now;
    const pressed = presses.byRobot(now, cards);
    const ids = new Set(robots.keys());
    for (const id of pressed.keys()) ids.add(id);
    if (config.scope.kind === "robot" && config.scope.id) ids.add(config.scope.id);
    if (ids.size > 1) ids.delete(ANY);
    const isEnrolled = Boolean(token()) && !socket.refusal;
    const seen = [];
    for (const id of ids) seen.push(robotView(id, pressed.get(id) || NO_STEPS, now, isFresh, isEnrolled));
    if (views.size > ids.size) for (const id of [...views.keys()]) if (!ids.has(id)) [changes] = [changes + 1, views.delete(id)];
    const all = allView(seen, now, isFresh, isEnrolled);
    const isAll = config.scope.kind !== "robot" || !config.scope.id;
    const one = isAll ? null : views.get(config.scope.id);
    if (one) one.link = linkText(one.robot);
    return { scope: config.scope, isAll, one, all, robots: seen, total: all.total, state: isAll ? all.state : one.state, isFresh };
  }

  function publicState(now = performance.now()) {
    const seen = look(now);
    const plain = ({ id, name, state, isLinked, isStanding, heardMs, step }) => ({ id, name, state, is_linked: isLinked, is_standing: isStanding, heard_ms: heardMs, step });
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
    paintedAt = now;
    slab?.draw(summary.one, summary.all, summary.isAll, now);
    const loudest = summary.all.failing.length ? "not-confirmed" : summary.state;
    const isLoss = ["no-link", "no-path"].includes(loudest); // silence is an alarm only where there was a link
    const isSame = before && before.scope === summary.scope;
    sound?.follow(loudest, now, isSame && (!isLoss || before.state === "ready" || sound.state === loudest));
    const next = JSON.stringify([summary.state, summary.scope, summary.total, summary.all.state, summary.all.standing, changes, presses.revision]);
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
    if (!isCalm(now)) paint();
  }

  // A large fleet without a press, everything READY: nothing can differ but what is asked here, until the next look.
  function isCalm(now) {
    if (robots.size <= MANY || presses.entries.size || summary?.state !== "ready" || now - paintedAt >= CALM_MS) return false;
    const { one, isFresh, scope } = summary;
    return isFresh === socket.isFresh(now) && scope === config.scope && (!one || one.heardMs + now - paintedAt <= LOST_MS);
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
    banner: () => words.banner(summary ?? look(performance.now()), performance.now()), // at most 100 ms old; it counts seconds
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
