// What can be asked of the robot now. The set of controls follows its state; what is off keeps its place and says why.
(() => {
  "use strict";
  const { el, icon, text, attr, style, toggle, LiveElement, define } = HL;
  const RIGHT_OF = { start: "start", pause: "pause", resume: "resume", later: "send_mission", fresh: "send_mission", abort: "abort", return_home: "return_home", drive: "drive", reset: "reset" };
  const NEEDS_CONTROL = new Set(["start", "resume", "return_home", "drive", "reset"]);

  // why an action is off; empty when it may be tried
  function refusal(action) {
    const robot = HL.view.robot;
    const groups = HL.port.robot(robot);
    if (!HL.config.rights.includes(RIGHT_OF[action])) return `You can watch ${HL.view.name()}. ${action === "reset" ? "Resetting" : "Driving"} needs the operator role.`;
    if (groups.id && groups.id.is_registered === false) return "New robot. An admin must accept it first.";
    const off = HL.offline(robot);
    if (off) return off;
    const verdict = groups.actions?.[action];
    if (verdict && !verdict.ok) return verdict.reason;
    const gate = action === "start" || (action === "resume" && groups.why?.code === "continued") ? HL.startChecks ? HL.startChecks.reason(robot) : "The checks are being loaded" : "";
    if (gate) return gate;
    if (action === "fresh" && !HL.rest) return "What it forgets is being loaded";
    return NEEDS_CONTROL.has(action) ? HL.lease.obstacle(robot) : "";
  }

  // which set of controls fits
  function situation() {
    const groups = HL.port.robot(HL.view.robot);
    const stop = HL.stops.worst(HL.view.robot);
    if (stop?.state === "not-confirmed") return "unsure";
    if (HL.linkState() === "server-lost" || HL.linkState() === "robot-lost" || !groups.mode) return "lost";
    const mode = groups.mode.mode;
    if (groups.safety?.latched || mode === "stopped" || stop) return "latched";
    if (HL.drive.isMine()) return "driving";
    if (mode === "manual") return "manual";
    if (mode === "auto") return "running";
    if (groups.actions?.later?.ok) return groups.mission?.status === "paused" ? "moved" : "interrupted";
    if (mode === "paused" && groups.why?.code === "continued") return "ready";
    if (mode === "paused" && ["running", "paused"].includes(groups.mission?.status ?? "paused")) return "paused";
    if (groups.mission?.status === "done") return "done";
    return groups.mission ? "idle" : "empty";
  }

  const what = () => HL.port.robot(HL.view.robot).body?.tool_label?.toLowerCase() || "tool";
  function motionLine() {
    const { body } = HL.port.robot(HL.view.robot);
    return `Tracks and ${what()} start${body?.horn_s ? ` after ${body.horn_s} s horn` : ""}`;
  }

  const order = (action) => () => HL.port.command(HL.view.robot, action);
  const onRobot = () => HL.port.robot(HL.view.robot).mission;
  const forgotten = () => HL.rest?.forgets(onRobot()) ?? "";
  // others may send a mission at any moment: the order names the one that was shown when the slide began
  const shown = () => [onRobot()?.id, onRobot()?.sha256];
  const start = (action) => ([mission_id, mission_sha256]) => HL.port.command(HL.view.robot, action, { mission_id, mission_sha256, checklist_id: HL.startChecks?.recordId(HL.view.robot) ?? null });

  function button(hook, sign, label, act, look = "", line = "") {
    const sub = el("span", { class: "sub" }, line);
    const node = el("button", { type: "button", class: `h-btn op ${look}`.trim(), "data-testid": hook }, icon(sign, look === "pri" ? "f" : ""), el("span", {}, label, sub));
    node.addEventListener("click", async () => {
      if (node.getAttribute("aria-disabled") === "true") return node.dataset.reason && HL.toast(node.dataset.reason, "lock");
      if (node.dataset.state === "pending") return null;
      attr(node, "data-state", "pending");
      text(sub, "Waiting for the robot");
      const reply = await act();
      attr(node, "data-state", reply?.outcome ?? null);
      text(sub, line);
      if (reply && reply.outcome !== "accepted") HL.toast(`${HL.outcomeWords(reply.outcome)}: ${reply.text}`, "block");
      return null;
    });
    return { node, hook, allow: (reason) => { attr(node, "aria-disabled", reason ? "true" : null); attr(node, "data-reason", reason || null); } };
  }

  const slide = (dock, options) => {
    const made = new HL.Slide({ ...options, onopen: (isOpen) => dock.focusOn(isOpen ? made : null) });
    return made;
  };

  const CONTROLS = {
    pause: (dock) => [button("mission-pause", "pause", "Pause", order("pause"), "pri"), "pause"],
    home: (dock) => [slide(dock, { hook: "mission-return-home", icon: "home", label: "Slide to return home", line: "It drives home by itself", button: { icon: "home", label: dock.isShort ? "Home" : "Return home" }, act: order("return_home") }), "return_home"],
    abort: (dock) => [slide(dock, { hook: "mission-abort", icon: "cancel", label: "Slide to abort", line: "It stops here. Cannot be undone", button: { icon: "cancel", label: "Abort" }, act: order("abort") }), "abort"],
    drive: (dock) => [button("drive-open", "sports_esports", "Drive", () => HL.drive.open(HL.view.robot)), "drive"],
    start: (dock) => [slide(dock, { hook: "mission-start", label: "Slide to start", line: motionLine(), seen: shown, act: start("start") }), "start", motionLine],
    checks: () => [checks(), null],
    later: () => [button("mission-later", "history", "Resume later", () => void HL.late("rest").then((rest) => rest?.later(onRobot())), "pri", "Drives back, goes on where it stopped"), "later"],
    fresh: (dock) => [slide(dock, { hook: "mission-fresh", icon: "refresh", label: "Hold to start fresh", line: forgotten(), goal: "refresh", isHold: true, button: { icon: "refresh", label: "Start fresh" }, act: () => HL.rest.fresh(onRobot().id) }), "fresh", forgotten],
    resume: (dock) => [slide(dock, { hook: "mission-resume", label: "Slide to resume", line: motionLine(), seen: shown, act: start("resume") }), "resume", motionLine],
    reset: (dock) => [slide(dock, { hook: "stop-reset", label: "Slide to reset stop", line: "Robot stays still. Check the area is clear.", goal: "lock_open", seen: () => HL.stops.openIds(HL.view.robot), act: reset }), "reset"],
    endManual: (dock) => [button("drive-close", "autoplay", "End manual", () => HL.drive.end() ?? HL.port.command(HL.view.robot, "drive_close"), "pri"), null],
    closeManual: (dock) => [button("drive-close", "autoplay", "End manual", order("drive_close"), "pri"), "drive"],
    resumeOff: (dock) => [resumeOff(), null],
    seen: (dock) => [slide(dock, { hook: "stop-seen", icon: "visibility", label: "I see it standing still", line: "Hold 1.5 s. Logged as seen, not as confirmed", goal: "visibility", isHold: true, waits: "Waiting for the server", act: seen }), null],
    call: (dock) => [call(), null],
    timer: (dock) => [timer(), null],
    gap: (dock) => [{ node: el("span", { class: "h-sp" }), hook: "", allow: () => {} }, null],
  };

  const SETS = {
    running: ["pause", "home", "abort", "gap", "drive"],
    paused: ["resume", "home", "abort", "drive"],
    idle: ["start", "checks", "home", "drive"],
    empty: ["start", "home", "drive"],
    moved: ["later", "fresh", "home", "abort", "drive"],
    interrupted: ["later", "fresh", "home", "drive"],
    done: ["fresh", "home", "drive"],
    ready: ["resume", "checks", "abort", "drive"],
    latched: ["reset", "resumeOff"],
    driving: ["endManual", "gap", "timer"],
    manual: ["closeManual", "drive"],
    lost: ["pause", "home", "abort"],
    unsure: ["call", "seen"],
  };

  function resumeOff() {
    const node = el("div", { class: "h-btn op off h-resumeoff", "aria-disabled": "true", "data-testid": "mission-resume", "data-state": "idle", role: "button" }, icon("play_arrow", "l"), el("span", {}, "Resume mission", el("span", { class: "sub" }, "Reset the stop first")));
    return { node, hook: "mission-resume", allow: () => {} };
  }

  function checks() {
    const made = button("mission-checks", "check", "Checks", () => void HL.late("startChecks").then((list) => list?.open(HL.view.robot)));
    const sub = made.node.querySelector(".sub");
    return { ...made, allow: () => text(sub, HL.startChecks?.summary(HL.view.robot) ?? "") };
  }

  function call() {
    const name = el("span");
    const sub = el("span", { class: "sub" });
    const node = el("a", { class: "h-btn op", "data-testid": "stop-call" }, icon("call", "f"), el("span", {}, name, sub));
    const allow = () => {
      const contact = HL.port.robot(HL.view.robot).body?.contact;
      attr(node, "hidden", !contact?.name);
      text(name, `Call ${contact?.name ?? ""}`);
      text(sub, contact?.phone ?? "");
      attr(node, "href", contact?.phone ? `tel:${contact.phone.replace(/[^+\d]/g, "")}` : null);
    };
    return { node, hook: "stop-call", allow };
  }

  function timer() {
    const left = el("b", { class: "h-t18" });
    return { node: el("span", { class: "h-timer h-t14 h-2", "data-testid": "drive-ends-in" }, "Control ends in", left), hook: "", allow: () => text(left, HL.drive.endsIn()) };
  }

  async function reset(stopIds) {
    const robot = HL.view.robot;
    const why = HL.stopReason.get(robot);
    if (!why) return { outcome: "refused", text: "Tap a reason first." };
    const reply = await HL.port.reset(robot, stopIds, why);
    if (reply.outcome === "accepted") HL.stopReason.clear(robot);
    return reply;
  }

  async function seen() {
    const stop = HL.stops.worst(HL.view.robot);
    if (!stop) return { outcome: "refused", text: "No stop is open." };
    const reply = await HL.port.seen(HL.view.robot, stop.stop_id);
    return reply.ok ? { outcome: "accepted", text: "Logged as seen. The stop is still not confirmed." } : { outcome: "refused", text: reply.text };
  }

  class ActionDock extends LiveElement {
    build() {
      this.reason = el("span", { class: "h-dockreason h-t14 h-2" });
      this.controls = [];
    }
    enter() {
      this.narrow = matchMedia("(max-width: 899.98px)");
      this.onNarrow = () => ((this.shown = null), HL.repaint());
      this.narrow.addEventListener("change", this.onNarrow);
    }
    leave() {
      this.narrow.removeEventListener("change", this.onNarrow);
      this.controls.forEach(([control]) => control.drop?.());
      this.shown = null;
    }
    // one armed slide takes the whole dock
    focusOn(control) {
      toggle(this, "single", Boolean(control));
      for (const [one] of this.controls) toggle(one.node, "chosen", one === control);
    }
    fill(set) {
      this.controls.forEach(([control]) => control.drop?.());
      this.shown = set;
      this.isShort = this.narrow.matches || set === "paused" || set === "moved";
      this.focusOn(null);
      this.controls = SETS[set].map((name) => CONTROLS[name](this));
      attr(this, "data-state", set);
      style(this, "--n", String(SETS[set].filter((name) => name !== "gap").length));
      this.replaceChildren(...this.controls.map(([control]) => control.node), this.reason);
    }
    paint() {
      const set = situation();
      const isBusy = this.controls.some(([control]) => control.isBusy || control.spoken?.sign === "block");
      // a control that waits for its answer, or says why it was refused, stays until it has been read
      if (set !== this.shown && !(isBusy && set !== "unsure" && set !== "latched")) this.fill(set);
      const reasons = new Set();
      const verdicts = [];
      for (const [, action] of this.controls) {
        const why = action ? refusal(action) : "";
        if (why) reasons.add(why);
        verdicts.push(why);
      }
      // one reason for everything is said once, beside the controls
      const isShared = reasons.size === 1 && this.controls.every(([, action], i) => !action || verdicts[i]);
      const [only] = reasons;
      this.controls.forEach(([control, , line], i) => {
        control.isQuiet = isShared;
        control.allow(verdicts[i], line?.());
      });
      text(this.reason, isShared ? only : "");
      attr(this.reason, "hidden", !isShared);
    }
  }

  define("hl-actions", ActionDock);
  Object.assign(HL, { situation });
})();
