// Manual driving is hold-to-run: setpoints ten times a second while one pad, key or stick is held, and zero at once
// when it is let go, cancelled, covered, out of focus, touched twice, or too slow. The robot's own dead-man backs it.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement, define, words } = HL;
  const PERIOD_MS = 100; // 10 Hz: the robot's dead-man of 0.5 s is five missed pulses
  const LIMIT_MS = 300; // above this round trip nobody can steer by eye
  const PICTURE_SLOW_MS = 500; // a camera picture this old lowers the speed of who steers by it
  const PICTURE_LIMIT_MS = 1000; // and nobody steers by an older one
  const IDLE_MS = 5 * 60 * 1000; // without input control ends
  const SETTLE_MS = 2000; // the robot says its mode twice a second; this long it may still say the old one
  const STEPS = [
    { key: "creep", label: "Creep", mps: 0.2, turn: 0.25 },
    { key: "slow", label: "Slow", mps: 0.5, turn: 0.4 },
    { key: "fast", label: "", mps: 1.0, turn: 0.5, isLocked: true },
  ];
  const PADS = {
    forward: { icon: "keyboard_arrow_up", label: "Forward", v: 1, w: 0, key: "ArrowUp" },
    left: { icon: "turn_left", label: "Left", v: 0, w: 1, key: "ArrowLeft" },
    back: { icon: "keyboard_arrow_down", label: "Reverse", v: -1, w: 0, key: "ArrowDown" },
    right: { icon: "turn_right", label: "Right", v: 0, w: -1, key: "ArrowRight" },
  };

  const drive = {
    robot: null, // the robot this page drives
    step: STEPS[0],
    held: new Map(), // source -> {v, w} in shares of the step
    isStickReady: false, // its trigger was seen let go since driving began or was interrupted
    lastInput: 0,
    // whatever else shows the robot: without the pads in sight no key and no stick may move it
    isMine: () => drive.robot !== null && drive.robot === HL.view.robot && drive.pads.isConnected,
    blockedBy: "",
    endsInMs: () => Math.max(0, IDLE_MS - (performance.now() - drive.lastInput)),
  };

  function setpoint() {
    let v = 0;
    let w = 0;
    for (const part of drive.held.values()) {
      v += part.v;
      w += part.w;
    }
    const cap = (share) => Math.min(1, Math.max(-1, share));
    const step = pictureMs() > PICTURE_SLOW_MS ? STEPS[0] : drive.step;
    return { v: cap(v) * step.mps, w: cap(w) * step.turn };
  }

  // age of the camera picture that is open for this robot; null when nobody steers by one
  const pictureMs = () => HL.picture?.ageMs(drive.robot) ?? null;

  // a sheet or a menu has the keys, and may lie over the pads
  const isCovered = () => document.querySelector(".h-scrim, .h-menu:not([hidden])");

  // why nothing may move now; empty when it may
  function obstacle() {
    const delayMs = HL.port.delayMs(drive.robot);
    if (HL.offline(drive.robot)) return "No fresh link";
    if (delayMs === null) return "Delay unknown";
    if (delayMs > LIMIT_MS) return `Off, ${Math.round(delayMs)} ms`;
    if (pictureMs() > PICTURE_LIMIT_MS) return HL.picture.why(PICTURE_LIMIT_MS);
    if (document.hidden) return "Screen is hidden";
    if (isCovered()) return "Close what is open";
    // the stick of one gamepad is heard in every window; a finger on a pad is here, also before its window has the focus
    return document.hasFocus() || drive.held.has("pad") ? "" : "This window is not in front";
  }

  function beat() {
    if (!drive.isMine()) return;
    drive.blockedBy = obstacle();
    readGamepad();
    if (drive.blockedBy) {
      if (drive.held.size) release();
    } else if (drive.held.size) {
      drive.lastInput = performance.now();
      const { v, w } = setpoint();
      HL.port.drive(drive.robot, v, w, pictureMs());
    }
    if (drive.endsInMs() === 0) end("Control ended after 5 minutes without input.");
    HL.repaint();
  }

  // zero now, twice: one lost frame must not cost the dead-man's half second
  function release() {
    const wasHeld = drive.held.size;
    drive.held.clear();
    drive.isStickReady = false;
    if (wasHeld && drive.robot) {
      HL.port.drive(drive.robot, 0, 0);
      setTimeout(() => drive.robot && drive.held.size === 0 && HL.port.drive(drive.robot, 0, 0), PERIOD_MS / 2);
    }
    HL.repaint();
  }

  function press(source, v, w) {
    if (!drive.isMine()) return false;
    drive.held.set(source, { v, w });
    drive.blockedBy = obstacle(); // anew: a touch may have brought the window to the front
    if (drive.blockedBy) return !drive.held.delete(source);
    beat();
    return drive.held.has(source);
  }

  async function open(robot) {
    drive.pads = document.querySelector("hl-drive");
    const reply = await HL.port.command(robot, "drive_open");
    // who left meanwhile does not drive: not from another screen, not when coming back
    if (reply.outcome === "accepted") drive.pads.isConnected && HL.view.robot === robot ? begin(robot) : HL.port.command(robot, "drive_close");
    return reply;
  }

  function begin(robot) {
    drive.robot = robot;
    drive.begunAt = drive.lastInput = performance.now();
    drive.held.clear();
    drive.isStickReady = false;
    drive.timer ??= setInterval(beat, PERIOD_MS);
    HL.repaint();
  }

  async function end(message) {
    const { robot } = drive;
    if (!robot) return null;
    release();
    stopBeating();
    if (message) HL.toast(message, "sports_esports");
    return HL.port.command(robot, "drive_close");
  }

  function stopBeating() {
    drive.held.clear();
    drive.robot = null;
    clearInterval(drive.timer);
    drive.timer = null;
    HL.repaint();
  }

  // A stick moves the robot only while the right trigger is held, so that a dropped gamepad does nothing; and a trigger
  // that was held when driving began, or while anything stopped it, has to be let go first: nothing sets off by itself.
  function readGamepad() {
    const pad = [...(navigator.getGamepads?.() || [])].find((one) => one?.connected);
    const isHeld = pad?.buttons[7]?.value > 0.5 || Boolean(pad?.buttons[5]?.pressed);
    const isAlone = drive.held.size === Number(drive.held.has("gamepad"));
    const isReady = isHeld ? drive.isStickReady && !drive.blockedBy && isAlone : Boolean(pad);
    const dead = (axis) => (Math.abs(axis || 0) < 0.15 ? 0 : axis);
    const [v, w] = isHeld ? [-dead(pad.axes[1]), -dead(pad.axes[0])] : [0, 0];
    if (isReady && (v || w)) drive.held.set("gamepad", { v, w });
    else if (drive.held.has("gamepad")) release();
    drive.isStickReady = isReady;
  }

  // the console ended it: nothing more to send
  function ended(message) {
    stopBeating();
    HL.toast(message || "Driving by hand ended.", "sports_esports");
  }

  // the console did not forward a setpoint: the robot rests, the hand must let go and press again
  function refused({ robot, code, text: why }) {
    if (drive.robot !== robot || drive.held.size === 0) return;
    if (code === "not_manual" && performance.now() - drive.begunAt < SETTLE_MS) return;
    release();
    HL.toast(why, "block");
  }

  const byKey = Object.fromEntries(Object.entries(PADS).map(([name, pad]) => [pad.key, name]));
  const isTaken = (event) => isCovered() || event.target.closest?.("input, textarea, select, [contenteditable], [role=radiogroup], [role=listbox]");
  window.addEventListener("keydown", (event) => {
    const name = byKey[event.key];
    if (!name || !drive.isMine() || isTaken(event) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    if (!event.repeat) press(`key:${name}`, PADS[name].v, PADS[name].w);
  });
  window.addEventListener("keyup", (event) => {
    const name = byKey[event.key];
    if (!name || !drive.held.delete(`key:${name}`)) return;
    if (drive.held.size === 0) {
      drive.held.set("ending", { v: 0, w: 0 });
      release();
    } else beat();
  });
  window.addEventListener("blur", release);
  window.addEventListener("pagehide", release);
  document.addEventListener("visibilitychange", () => document.hidden && release());
  document.addEventListener("contextmenu", (event) => drive.isMine() && event.preventDefault());

  class Drive extends LiveElement {
    build() {
      this.pads = Object.fromEntries(Object.entries(PADS).map(([name, pad]) => [name, this.pad(name, pad)]));
      const { forward, left, back, right } = this.pads;
      this.append(
        el("div", { class: "h-pads", role: "group", "aria-label": "Hold to drive" }, el("span"), forward.node, el("span"), left.node, back.node, right.node),
        this.card(),
        el("div", { class: "h-driveframe" }),
      );
    }
    card() {
      this.promise = el("div", { class: "h-2 h-t14" });
      this.steps = STEPS.map((step) =>
        el("button", { type: "button", "data-testid": `drive-speed-${step.key}`, disabled: step.isLocked, onclick: () => ((drive.step = step), HL.repaint()) },
          step.isLocked ? icon("lock", "s") : "", el("span", {}, step.label, step.label ? el("br") : "", step.mps.toFixed(1))),
      );
      return el("div", { class: "h-drivecard h-card" },
        el("div", { class: "h-t18 h-b" }, "Hold to drive"), this.promise, el("div", { class: "h-seg", role: "group", "aria-label": "Speed" }, ...this.steps),
        el("div", { class: "h-t13 h-2" }, "m/s. 1.0 needs a spotter on site."));
    }
    pad(name, pad) {
      const sign = icon(pad.icon, "big");
      const label = el("span", {}, pad.label);
      const node = el("button", { type: "button", class: "h-pad", "data-testid": `drive-${name}`, "data-state": "idle", "aria-label": `${pad.label}, hold` }, sign, label);
      node.addEventListener("pointerdown", (event) => this.down(event, name, node));
      node.addEventListener("click", (event) => event.preventDefault());
      return { node, sign, label, pad };
    }
    down(event, name, node) {
      event.preventDefault();
      if (event.button > 0 || event.width > HL.PALM_PX || event.height > HL.PALM_PX) return;
      if (this.finger !== null && this.finger !== undefined) return; // the window listener below stops for the second touch
      const { v, w } = PADS[name];
      if (!press("pad", v, w)) return;
      const id = (this.finger = event.pointerId);
      node.setPointerCapture?.(id);
      const done = (end) => {
        if ((end.type === "pointerdown") === (end.pointerId === id)) return;
        this.finger = null;
        for (const type of ENDS) window.removeEventListener(type, done, true);
        release();
      };
      for (const type of ENDS) window.addEventListener(type, done, true);
    }
    leave() {
      this.finger = null;
      if (drive.robot) end();
    }
    paint() {
      const mode = HL.port.robot(HL.view.robot).mode?.mode;
      attr(this, "hidden", !drive.isMine());
      attr(this, "data-state", drive.held.size ? "held" : "idle");
      if (!drive.isMine()) return;
      if (mode !== "manual" && mode !== "stopped" && performance.now() - drive.begunAt > SETTLE_MS) return ended("The robot ended driving by hand.");
      if (mode === "stopped" || (HL.lease.of(drive.robot).owner && !HL.lease.isMine(drive.robot))) return stopBeating();
      const isSlow = !drive.blockedBy && pictureMs() > PICTURE_SLOW_MS;
      attr(this, "data-picture", isSlow ? "slow" : drive.blockedBy && pictureMs() > PICTURE_LIMIT_MS ? "old" : null);
      text(this.promise, isSlow ? HL.picture.slow() : pictureMs() > PICTURE_LIMIT_MS ? HL.picture.advice() : `Let go and ${HL.view.name()} stops. ${HL.port.robot(drive.robot).body?.tool_label || "The tool"} stays off in manual.`);
      this.steps.forEach((button, i) => attr(button, "aria-pressed", String(STEPS[i] === drive.step)));
      for (const [name, { node, sign, label, pad }] of Object.entries(this.pads)) {
        const isHeld = [...drive.held.values()].some((part) => (pad.v && Math.sign(part.v) === pad.v) || (pad.w && Math.sign(part.w) === pad.w));
        const isOff = Boolean(drive.blockedBy);
        attr(node, "data-state", isHeld ? "held" : isOff ? "off" : "idle");
        toggle(node, "held", isHeld);
        toggle(node, "off", isOff);
        text(sign, isOff ? (pictureMs() > PICTURE_LIMIT_MS ? "videocam_off" : "signal_disconnected") : pad.icon);
        text(label, isOff ? drive.blockedBy : PADS[name].label);
      }
      return undefined;
    }
  }
  const ENDS = ["pointerup", "pointercancel", "lostpointercapture", "pointerdown"];

  define("hl-drive", Drive);
  Object.assign(HL, { drive: Object.assign(drive, { open, end, ended, refused, endsIn: () => words.clock(drive.endsInMs() / 1000) }) });
})();
