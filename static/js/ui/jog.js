// Joints by hand, hold-to-run: setpoints ten times a second while one pad is held, and zero at once when it is let go,
// cancelled, covered, out of focus, touched twice, or too slow. The robot's own dead-man backs it. STOP always wins.
(() => {
  "use strict";
  const { el, icon, attr, toggle } = HL;
  const PERIOD_MS = 100; // 10 Hz: the robot's dead-man of 0.5 s is five missed pulses
  const LIMIT_MS = 300; // above this round trip nobody can steer by eye
  const IDLE_MS = 5 * 60 * 1000; // without input control ends
  const PICTURE_SLOW_MS = 500; // as of driving: a picture of the robot that is open is what the hand goes by
  const PICTURE_LIMIT_MS = 1000;
  const SETTLE_MS = 2000; // the robot says its mode twice a second; this long it may still say the old one
  const ENDS = ["pointerup", "pointercancel", "lostpointercapture", "pointerdown"];
  const STEPS = [["creep", "Creep", 0.2], ["slow", "Slow", 0.5]]; // shares of a joint's top rate; the console allows no more
  const FASTEST = 2; // of a joint that did not tell its top rate; the console slows it down

  const jog = { robot: null, share: STEPS[0][2], held: new Map(), lastInput: 0, begunAt: 0, blockedBy: "", timer: null, close: null, isGuest: false };
  const isMine = () => jog.robot !== null && jog.robot === HL.view.robot;
  const endsInMs = () => Math.max(0, IDLE_MS - (performance.now() - jog.lastInput));
  const joints = () => HL.port.inside(HL.view.robot).joints?.joints ?? [];

  function send(rates) {
    const tick = window.headland.tick();
    const ageMs = pictureMs();
    // what rests needs no picture
    const picture = ageMs === null || !Object.values(rates).some(Boolean) ? {} : { picture: Math.round(ageMs) };
    return tick !== null && window.headland.send({ k: "jog", robot: jog.robot, rates, tick, ...picture });
  }

  const pictureMs = () => HL.picture?.ageMs(jog.robot) ?? null;

  // why nothing may move now; empty when it may
  function obstacle() {
    const delayMs = HL.port.delayMs(jog.robot);
    if (HL.stops.worst(jog.robot)) return "STOP was pressed"; // before the robot says so
    if (HL.offline(jog.robot)) return "No fresh link";
    if (delayMs === null) return "Delay unknown";
    if (delayMs > LIMIT_MS) return `Off, ${Math.round(delayMs)} ms`;
    if (pictureMs() > PICTURE_LIMIT_MS) return HL.picture.why(PICTURE_LIMIT_MS);
    return document.hidden ? "Screen is hidden" : "";
  }

  function setpoint() {
    const rates = {};
    const share = pictureMs() > PICTURE_SLOW_MS ? STEPS[0][2] : jog.share;
    for (const { joint, way } of jog.held.values()) {
      const top = joints().find((one) => one.name === joint)?.max_rate ?? FASTEST / share;
      rates[joint] = Math.max(-FASTEST, Math.min(FASTEST, way * top * share));
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

  // shown() brings the pads and returns what takes them away
  async function open(robot, shown) {
    const { screen } = HL.view;
    const reply = await HL.port.command(robot, "drive_open");
    if (reply.outcome === "accepted") {
      if (HL.view.robot === robot && HL.view.screen === screen) begin(robot, shown);
      else HL.port.command(robot, "drive_close"); // the answer came after the person left
    }
    return reply;
  }

  // beside wheels that are driven by hand already: manual mode is theirs and does not end with the joints
  function attach(robot, shown) {
    begin(robot, shown);
    jog.isGuest = true;
  }

  function begin(robot, shown) {
    Object.assign(jog, { robot, begunAt: performance.now(), lastInput: performance.now(), blockedBy: obstacle(), isGuest: false });
    jog.held.clear();
    jog.timer ??= setInterval(beat, PERIOD_MS);
    jog.close = shown?.() ?? null;
    HL.repaint();
  }

  async function end(message) {
    const { robot, isGuest } = jog;
    if (!robot) return null;
    release();
    stopBeating();
    if (message) HL.toast(message, "sports_esports");
    return isGuest ? null : HL.port.command(robot, "drive_close");
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

  // ends what no longer holds; false when it ended. Whoever shows pads asks at each paint
  function check() {
    const mode = HL.port.robot(jog.robot).mode?.mode;
    const over = mode !== "manual" && mode !== "stopped" && performance.now() - jog.begunAt > SETTLE_MS ? "The robot ended driving by hand." : mode === "stopped" ? "Stopped. Reset the stop first." : HL.lease.of(jog.robot).owner && !HL.lease.isMine(jog.robot) ? "Somebody else has control now." : "";
    if (over) stopBeating(over);
    return !over;
  }

  // a pad that moves one joint while exactly one finger, or a key, holds it
  function pad(joint, way, { sign, look = "s-jogpad", hook = `jog-${joint}-${way < 0 ? "minus" : "plus"}` }) {
    const node = el("button", { type: "button", class: `h-pad ${look}`, "data-testid": hook, "data-state": "idle" }, icon(sign, "big"));
    node.addEventListener("pointerdown", (event) => down(event, joint, way, node));
    node.addEventListener("click", (event) => event.preventDefault());
    node.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      if (!event.repeat) press("key", joint, way);
    });
    node.addEventListener("keyup", () => jog.held.has("key") && release());
    node.addEventListener("blur", () => jog.held.has("key") && release());
    return node;
  }

  function showPad(node, joint, way, label) {
    const isHeld = [...jog.held.values()].some((one) => one.joint === joint && one.way === way);
    attr(node, "data-state", isHeld ? "held" : jog.blockedBy ? "off" : "idle");
    toggle(node, "held", isHeld);
    toggle(node, "off", Boolean(jog.blockedBy));
    attr(node, "aria-label", `${label}, hold`);
  }

  let finger = null;
  function down(event, joint, way, node) {
    event.preventDefault();
    if (event.button > 0 || event.width > HL.PALM_PX || event.height > HL.PALM_PX) return;
    if (finger !== null) return; // the window listener below stops for the second touch
    if (!press("pad", joint, way)) return;
    const id = (finger = event.pointerId);
    node.setPointerCapture?.(id);
    const done = (last) => {
      if (last.type === "pointerdown" ? last.pointerId === id : last.pointerId !== id) return;
      finger = null;
      for (const type of ENDS) window.removeEventListener(type, done, true);
      release();
    };
    for (const type of ENDS) window.addEventListener(type, done, true);
  }

  function letGo() {
    finger = null;
    if (jog.robot) end(); // what showed the pads is gone: nothing may go on being held
  }

  Object.assign(HL, { jog: Object.assign(jog, { STEPS, open, attach, end, what, isMine, joints, endsInMs, check, pad, showPad, letGo }) });
})();
