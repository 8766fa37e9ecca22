// The dock of Supervisor and Twin: pause at once, retract by slide, joints by hand, skip, and why one of them is off.
(() => {
  "use strict";
  const { el, icon, text, attr, style, toggle, LiveElement } = HL;
  const RIGHT_OF = { pause: "pause", return_home: "return_home", tool_retract: "tool", tool_go_to: "tool", go_to: "go_to", skip_target: "tool", stock_refilled: "tool", jog: "drive" };
  const NEEDS = { pause: "Pausing", return_home: "Sending it home", tool: "Moving its tool", go_to: "Sending it somewhere", drive: "Driving" };
  const NO_CONTROL = new Set(["pause"]);
  const STOPPED = "Stopped. Reset the stop on Operate first."; // this page may know before the robot or the console says so

  // why an action is off; empty when it may be tried
  function refusal(action) {
    const robot = HL.view.robot;
    const groups = HL.port.robot(robot);
    const right = RIGHT_OF[action];
    if (!HL.config.rights.includes(right)) return `You can watch ${HL.view.name()}. ${NEEDS[right]} needs the operator role.`;
    if (groups.id && groups.id.is_registered === false) return "New robot. An admin must accept it first.";
    const off = HL.offline(robot);
    if (off) return off;
    if (HL.stops.worst(robot)) return STOPPED;
    const verdict = groups.actions?.[action];
    if (verdict && !verdict.ok) return verdict.reason;
    if (action === "skip_target" && HL.port.inside(robot).site && !current()) return "There is no tree to skip now.";
    return NO_CONTROL.has(action) ? "" : HL.lease.obstacle(robot);
  }

  // stopped or paused it goes on from Operate, where the reasons and the checks before a start are
  function elsewhere() {
    const { mode, safety } = HL.port.robot(HL.view.robot);
    if (HL.stops.worst(HL.view.robot) || safety?.latched || mode?.mode === "stopped") return "reset";
    return mode?.mode === "paused" ? "resume" : "";
  }
  const operate = (hook, sign, label) => () => {
    const node = el("a", { class: "h-btn op pri", href: `/operate/${HL.view.robot}`, "data-testid": hook }, icon(sign), el("span", {}, label));
    return [{ node, allow() {} }, null];
  };

  const order = (action) => () => HL.port.command(HL.view.robot, action);
  const tool = () => HL.port.robot(HL.view.robot).body?.tool_label?.toLowerCase() || "tool";

  const current = () => HL.port.inside(HL.view.robot).site?.targets.find((one) => one.status === "current");

  // "Skip tree 147": what is worked at now, by the words of the robot
  function target() {
    const number = /\d+$/.exec(current()?.id ?? "")?.[0];
    return number ? `Skip tree ${Number(number)}` : "Skip tree";
  }

  // the tree that the button named when it was tapped; the robot may be at the next one by then
  const skip = (dock) => () => HL.port.command(HL.view.robot, "skip_target", dock.at ? { target: dock.at } : {});

  function button(hook, sign, label, act, look = "") {
    const word = el("span", {}, label);
    const sub = el("span", { class: "sub" });
    const node = el("button", { type: "button", class: `h-btn op ${look}`.trim(), "data-testid": hook }, icon(sign, look === "pri" ? "f" : ""), el("span", {}, word, sub));
    node.addEventListener("click", async () => {
      if (node.getAttribute("aria-disabled") === "true") return node.dataset.reason && HL.toast(node.dataset.reason.replace(" on Supervisor", ""), "lock");
      if (node.dataset.state === "pending") return null;
      attr(node, "data-state", "pending");
      text(sub, "Waiting for the robot");
      const reply = await act();
      attr(node, "data-state", reply?.outcome ?? null);
      text(sub, "");
      if (reply && reply.outcome !== "accepted") HL.toast(`${HL.outcomeWords(reply.outcome)}: ${reply.text}`, "block");
      return null;
    });
    return { node, word, allow: (reason) => { attr(node, "aria-disabled", reason ? "true" : null); attr(node, "data-reason", reason || null); } };
  }

  const slide = (dock, options) => {
    const made = new HL.Slide({ ...options, onopen: (isOpen) => dock.focusOn(isOpen ? made : null) });
    return made;
  };

  const jogWords = () => { const { verb, name } = HL.jog.what(HL.view.robot); return `${verb} ${name}`; };

  const CONTROLS = {
    pause: () => [button("mission-pause", "pause", "Pause", order("pause"), "pri"), "pause"],
    reset: operate("reset-on-operate", "lock_open", "Reset on Operate"),
    resume: operate("resume-on-operate", "play_arrow", "Resume on Operate"),
    home: (dock) => [slide(dock, { hook: "mission-return-home", icon: "home", label: "Slide to return home", line: "It drives home by itself", button: { icon: "home", label: "Return home" }, act: order("return_home") }), "return_home"],
    retract: (dock) => [slide(dock, { hook: "tool-retract", icon: "undo", label: `Slide to retract the ${tool()}`, line: `The ${tool()} moves. Check that nobody is near it`, button: { icon: "undo", label: `Retract ${tool()}` }, act: order("tool_retract") }), "tool_retract"],
    jog: () => [button("jog-open", "sports_esports", jogWords(), () => HL.jogSheet.open(HL.view.robot)), "jog"],
    skip: (dock) => [button("target-skip", "keyboard_double_arrow_right", target(), skip(dock)), "skip_target", target],
    refilled: (dock) => [slide(dock, { hook: "stock-refilled", icon: "done_all", label: "Slide: trays are full", line: "It may go on by itself. Keep clear", button: { icon: "done_all", label: "Trays full" }, act: order("stock_refilled") }), "stock_refilled"],
  };
  const isWaitingForStock = () => HL.port.robot(HL.view.robot).why?.code === "tray_empty" || (HL.port.inside(HL.view.robot).active?.states ?? []).some(([id]) => id === "refill");

  const BY_HAND = ["manual-tool", "manual-crane", "move-tool", "move-crane"];
  const movesByHand = () => (HL.port.inside(HL.view.robot).functions?.functions ?? []).some((one) => BY_HAND.includes(one.name));

  // which controls fit: a planter's crane has its own; elsewhere joints are moved by hand where the robot says that it can
  function set() {
    const { id } = HL.port.robot(HL.view.robot);
    const first = elsewhere() || "pause";
    if (!id) return [first];
    if (id.family === "planter") return [first, "retract", "jog", isWaitingForStock() ? "refilled" : "skip"];
    return [first, "home", ...(movesByHand() ? ["jog"] : [])];
  }

  class SuperDock extends LiveElement {
    build() {
      this.hint = el("span", { class: "s-dockhint h-t13 h-2", role: "status" });
      this.controls = [];
    }
    leave() {
      this.controls.forEach(([control]) => control.drop?.());
      this.shown = "";
      if (HL.jog.robot) HL.jog.end();
    }
    // one armed slide takes the whole dock
    focusOn(control) {
      toggle(this, "single", Boolean(control));
      for (const [one] of this.controls) toggle(one.node, "chosen", one === control);
    }
    fill(names) {
      this.controls.forEach(([control]) => control.drop?.());
      this.shown = names.join();
      this.focusOn(null);
      this.controls = names.map((name) => CONTROLS[name](this));
      style(this, "--n", String(names.length));
      attr(this, "data-state", names.includes("retract") ? "planter" : "generic");
      this.replaceChildren(...this.controls.map(([control]) => control.node), el("span", { class: "h-sp" }), this.hint);
    }
    // one reason for everything stands alone, else the first names its control; the others say theirs when they are tapped
    said(reasons) {
      const first = reasons.findIndex(Boolean);
      const reason = (reasons[first] ?? "").replace(" on Supervisor", "");
      if (!reason || this.controls.every(([, action], i) => !action || reasons[i] === reasons[first])) return reason;
      const [control] = this.controls[first];
      return `${control.options?.button.label ?? control.word.textContent}: ${reason}`;
    }
    paint() {
      const names = set();
      const isBusy = this.controls.some(([control]) => control.isBusy || control.spoken || control.state === "armed" || control.node.dataset.state === "pending");
      if (names.join() !== this.shown && !isBusy) this.fill(names);
      const reasons = this.controls.map(([, action]) => (action ? refusal(action) : ""));
      this.at = current()?.id;
      this.controls.forEach(([control, , word], i) => {
        control.isQuiet = true;
        control.allow(reasons[i]);
        if (word) text(control.word, word());
      });
      const off = this.said(reasons);
      const isPlanter = names.includes("retract");
      toggle(this.hint, "off", Boolean(off));
      text(this.hint, off || (isPlanter ? `Retract moves the ${tool()}. It asks for a slide first.` : ""));
    }
  }

  HL.superDefine("hl-super-dock", SuperDock);
  Object.assign(HL, { superDock: { refusal } });
})();
