// Joints by hand, hold-to-run: setpoints ten times a second while one pad is held, and zero at once when it is let go,
// cancelled, covered, out of focus, touched twice, or too slow. The robot's own dead-man backs it. STOP always wins.
(() => {
  "use strict";
  const { el, icon, text, attr, style, toggle, LiveElement, words } = HL;
  const PERIOD_MS = 100; // 10 Hz: the robot's dead-man of 0.5 s is five missed pulses
  const LIMIT_MS = 300; // above this round trip nobody can steer by eye
  const IDLE_MS = 5 * 60 * 1000; // without input control ends
  const SETTLE_MS = 2000; // the robot says its mode twice a second; this long it may still say the old one
  const ENDS = ["pointerup", "pointercancel", "lostpointercapture", "pointerdown"];
  const STEPS = [["creep", "Creep", 0.2], ["slow", "Slow", 0.5]]; // shares of a joint's top rate; the console allows no more
  const FASTEST = 2; // of a joint that did not tell its top rate; the console slows it down

  const jog = { robot: null, share: STEPS[0][2], held: new Map(), lastInput: 0, begunAt: 0, blockedBy: "", timer: null, close: null };
  const isMine = () => jog.robot !== null && jog.robot === HL.view.robot;
  const endsInMs = () => Math.max(0, IDLE_MS - (performance.now() - jog.lastInput));
  const joints = () => HL.port.inside(HL.view.robot).joints?.joints ?? [];

  function send(rates) {
    const tick = window.headland.tick();
    return tick !== null && window.headland.send({ k: "jog", robot: jog.robot, rates, tick });
  }

  // why nothing may move now; empty when it may
  function obstacle() {
    const delayMs = HL.port.delayMs(jog.robot);
    if (HL.stops.worst(jog.robot)) return "STOP was pressed"; // before the robot says so
    if (HL.offline(jog.robot)) return "No fresh link";
    if (delayMs === null) return "Delay unknown";
    if (delayMs > LIMIT_MS) return `Off, ${Math.round(delayMs)} ms`;
    return document.hidden ? "Screen is hidden" : "";
  }

  function setpoint() {
    const rates = {};
    for (const { joint, way } of jog.held.values()) {
      const top = joints().find((one) => one.name === joint)?.max_rate ?? FASTEST / jog.share;
      rates[joint] = Math.max(-FASTEST, Math.min(FASTEST, way * top * jog.share));
    }
    return rates;
  }

  function beat() {
    if (!isMine()) return;
    jog.blockedBy = obstacle();
    if (jog.blockedBy) {
      if (jog.held.size) release();
    } else if (jog.held.size) {
      jog.lastInput = performance.now();
      send(setpoint());
    }
    if (endsInMs() === 0) end("Control ended after 5 minutes without input.");
    HL.repaint();
  }

  // zero now, twice: one lost frame must not cost the dead-man's half second
  function release() {
    const names = [...new Set([...jog.held.values()].map((one) => one.joint))];
    jog.held.clear();
    if (names.length && jog.robot) {
      const rest = Object.fromEntries(names.map((name) => [name, 0]));
      send(rest);
      setTimeout(() => jog.robot && !jog.held.size && send(rest), PERIOD_MS / 2);
    }
    HL.repaint();
  }

  function press(source, joint, way) {
    if (!isMine() || jog.blockedBy || jog.held.size) return false;
    jog.held.set(source, { joint, way });
    jog.lastInput = performance.now();
    beat();
    return true;
  }

  // what the joints carry: "Camera pan" and "Camera tilt" move the camera; joints of no common name are the tool's
  function what(robot) {
    const first = (HL.port.inside(robot).joints?.joints ?? []).map((one) => one.label.split(" ")[0]);
    const isCommon = first.length > 0 && first.every((word) => word === first[0] && !/\d/.test(word));
    return { verb: isCommon ? "Move" : "Drive", name: (isCommon ? first[0] : HL.port.robot(robot).body?.tool_label || "tool").toLowerCase() };
  }

  async function open(robot) {
    const reply = await HL.port.command(robot, "drive_open");
    if (reply.outcome === "accepted" && HL.view.robot === robot) begin(robot);
    return reply;
  }

  function begin(robot) {
    Object.assign(jog, { robot, begunAt: performance.now(), lastInput: performance.now(), blockedBy: obstacle() });
    jog.held.clear();
    jog.timer ??= setInterval(beat, PERIOD_MS);
    const { verb, name } = what(robot);
    jog.close = HL.sheet({ title: `${verb} the ${name} by hand`, hook: "jog-sheet", body: [el("hl-super-jog")], buttons: [["End manual", () => end(), true]] });
    HL.repaint();
  }

  async function end(message) {
    const { robot } = jog;
    if (!robot) return null;
    release();
    stopBeating();
    if (message) HL.toast(message, "sports_esports");
    return HL.port.command(robot, "drive_close");
  }

  // nothing more is sent; the sheet goes
  function stopBeating(message) {
    jog.held.clear();
    jog.robot = null;
    clearInterval(jog.timer);
    jog.timer = null;
    const { close } = jog;
    jog.close = null;
    close?.();
    if (message) HL.toast(message, "sports_esports");
    HL.repaint();
  }

  // the console did not forward a setpoint: the joints rest, the hand must let go and press again
  window.headland.on("event", (event) => {
    if (!event || !jog.robot || event.robot !== jog.robot) return;
    if (event.kind === "drive" && event.op === "ended") stopBeating(event.text || "Driving by hand ended.");
    if (event.kind !== "jog" || !jog.held.size) return;
    if (event.code === "not_manual" && performance.now() - jog.begunAt < SETTLE_MS) return;
    release();
    HL.toast(event.text, "block");
  });
  window.addEventListener("blur", release);
  window.addEventListener("pagehide", release);
  document.addEventListener("visibilitychange", () => document.hidden && release());
  document.addEventListener("contextmenu", (event) => isMine() && event.preventDefault());

  class Jog extends LiveElement {
    build() {
      this.promise = el("p", { class: "h-2 h-t14" });
      this.steps = STEPS.map(([key, label, share]) => el("button", { type: "button", "data-testid": `jog-speed-${key}`, onclick: () => ((jog.share = share), HL.repaint()) }, label));
      this.left = el("b");
      this.list = el("div", { class: "s-joints" });
      this.rows = new Map();
      this.append(this.promise, el("div", { class: "s-jogbar" }, el("div", { class: "h-seg", role: "group", "aria-label": "Speed" }, ...this.steps), el("span", { class: "h-t14 h-2" }, "Control ends in ", this.left)), this.list);
    }
    leave() {
      this.finger = null;
      if (jog.robot) end(); // the sheet was closed: nothing may go on being held
    }
    paint() {
      if (!isMine()) return;
      const mode = HL.port.robot(jog.robot).mode?.mode;
      if (mode !== "manual" && mode !== "stopped" && performance.now() - jog.begunAt > SETTLE_MS) return stopBeating("The robot ended driving by hand.");
      if (mode === "stopped") return stopBeating("Stopped. Reset the stop first.");
      if (HL.lease.of(jog.robot).owner && !HL.lease.isMine(jog.robot)) return stopBeating("Somebody else has control now.");
      text(this.promise, jog.blockedBy ? `Off: ${jog.blockedBy}.` : `Hold a pad to move. Let go and it stops. ${HL.view.name()} stays where it is.`);
      attr(this, "data-state", jog.held.size ? "held" : jog.blockedBy ? "off" : "idle");
      this.steps.forEach((button, i) => attr(button, "aria-pressed", String(STEPS[i][2] === jog.share)));
      text(this.left, words.clock(endsInMs() / 1000));
      this.keep(joints());
      const ageMs = HL.port.age(HL.port.inside(jog.robot).joints?.t);
      for (const one of joints()) this.rows.get(one.name).paint(one, ageMs);
      return undefined;
    }
    keep(list) {
      const names = list.map((one) => one.name).join();
      if (names === this.names) return;
      this.names = names;
      for (const one of list) if (!this.rows.has(one.name)) this.rows.set(one.name, this.row(one));
      this.list.replaceChildren(...list.map((one) => this.rows.get(one.name).node));
    }
    row({ name }) {
      const [minus, plus] = [this.pad(name, -1), this.pad(name, 1)];
      const label = el("b", { class: "h-t16" });
      const value = el("span", { class: "h-t18 h-b" });
      const soft = el("span", { class: "soft" });
      const pointer = el("span", { class: "ptr" });
      const node = el("div", { class: "s-joint", "data-testid": `jog-${name}` }, minus, el("div", { class: "mid" }, el("div", { class: "h-row" }, label, el("span", { class: "h-sp" }), value), el("div", { class: "s-jointbar", "aria-hidden": "true" }, soft, pointer)), plus);
      const paint = (joint, ageMs) => {
        const isOld = joint.value === null || joint.value === undefined || ageMs > HL.STALE_MS;
        text(label, joint.label);
        text(value, joint.value === null || joint.value === undefined ? "––" : isOld ? `${measure(joint, joint.value)}, ${words.age(ageMs)} old` : measure(joint, joint.value));
        toggle(node, "stale", isOld);
        attr(node, "data-level", isOld ? null : joint.level);
        const at = (x) => Math.min(100, Math.max(0, ((x - joint.lower) / (joint.upper - joint.lower)) * 100));
        style(soft, "left", `${at(joint.soft_lower ?? joint.lower)}%`);
        style(soft, "right", `${100 - at(joint.soft_upper ?? joint.upper)}%`);
        attr(pointer, "hidden", joint.value === null || joint.value === undefined);
        style(pointer, "left", `${at(joint.value ?? joint.lower)}%`);
        for (const [pad, way] of [[minus, -1], [plus, 1]]) {
          const isHeld = [...jog.held.values()].some((one) => one.joint === name && one.way === way);
          attr(pad, "data-state", isHeld ? "held" : jog.blockedBy ? "off" : "idle");
          toggle(pad, "held", isHeld);
          toggle(pad, "off", Boolean(jog.blockedBy));
          attr(pad, "aria-label", `${joint.label} ${way < 0 ? "back" : "forward"}, hold`);
        }
      };
      return { node, paint };
    }
    pad(name, way) {
      const node = el("button", { type: "button", class: "h-pad s-jogpad", "data-testid": `jog-${name}-${way < 0 ? "minus" : "plus"}`, "data-state": "idle" }, icon(way < 0 ? "remove" : "add", "big"));
      node.addEventListener("pointerdown", (event) => this.down(event, name, way, node));
      node.addEventListener("click", (event) => event.preventDefault());
      node.addEventListener("keydown", (event) => {
        if (event.key !== " " && event.key !== "Enter") return;
        event.preventDefault();
        if (!event.repeat) press("key", name, way);
      });
      node.addEventListener("keyup", () => jog.held.has("key") && release());
      node.addEventListener("blur", () => jog.held.has("key") && release());
      return node;
    }
    down(event, name, way, node) {
      event.preventDefault();
      if (event.button > 0 || event.width > HL.PALM_PX || event.height > HL.PALM_PX) return;
      if (this.finger !== null && this.finger !== undefined) return; // the window listener below stops for the second touch
      if (!press("pad", name, way)) return;
      const id = (this.finger = event.pointerId);
      node.setPointerCapture?.(id);
      const done = (last) => {
        if (last.type === "pointerdown" ? last.pointerId === id : last.pointerId !== id) return;
        this.finger = null;
        for (const type of ENDS) window.removeEventListener(type, done, true);
        release();
      };
      for (const type of ENDS) window.addEventListener(type, done, true);
    }
  }

  const measure = (joint, value) => (joint.unit === "rad" ? `${((value * 180) / Math.PI).toFixed(0)}°` : `${value.toFixed(2)} m`);

  HL.superDefine("hl-super-jog", Jog);
  Object.assign(HL, { jog: Object.assign(jog, { open, end, what }) });
})();
