// What can be asked about the picture that is chosen: open its robot, skip what it waits at, look at it alone.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement } = HL;

  const ASKS = ["ask_person"]; // why a robot waits that skipping its target clears

  // why skipping is off; empty when it may be tried
  function refusal(robot) {
    if (!HL.config.rights.includes("tool")) return "Skipping needs the operator role.";
    const off = HL.offline(robot);
    return off || HL.port.robot(robot).actions?.skip_target?.reason || HL.lease.obstacle(robot);
  }

  const current = (robot) => HL.port.inside(robot).site?.targets.find((one) => one.status === "current")?.id;

  class CamerasDock extends LiveElement {
    build() {
      this.openWord = el("span");
      this.open = el("a", { class: "h-btn op", "data-testid": "cameras-open" }, icon("open_in_new"), this.openWord);
      this.aloneWord = el("span");
      this.alone = el("button", { type: "button", class: "h-btn op", "data-testid": "cameras-alone", onclick: () => HL.camera.shown?.enlarge(HL.camera.shown.current()) }, icon("videocam"), this.aloneWord);
      this.skip = el("button", { type: "button", class: "h-btn op", "data-testid": "cameras-skip", onclick: () => this.ask() }, icon("keyboard_double_arrow_right"), (this.skipWord = el("span")));
      this.hint = el("span", { class: "h-hint c-hint" }, "Delay is camera to screen. Pictures older than 1 s are marked.", el("br"), "Tap a picture to choose it.");
      this.append(this.open, this.alone, this.skip, el("span", { class: "h-sp" }), this.hint);
      for (const type of ["pointerdown", "focusin"]) this.addEventListener(type, () => HL.camera.shown?.hold());
    }
    robot() {
      const tile = HL.camera.shown?.current();
      return tile && tile.one.robot !== "field" ? tile.one.robot : null;
    }
    // what the button names, and nothing that came after it
    async ask() {
      const { robot, target } = this.offer ?? {};
      if (this.isPending) return null;
      const why = robot && refusal(robot);
      if (!robot || why) return HL.toast(why || "Choose a picture first.", "lock");
      this.isPending = true;
      this.paint();
      const reply = await HL.port.command(robot, "skip_target", target ? { target } : {});
      this.isPending = false;
      this.paint();
      return HL.toast(reply.outcome === "accepted" ? `${HL.port.fleet()[robot]?.name} skips it.` : `${HL.outcomeWords(reply.outcome)}: ${reply.text}`, reply.outcome === "accepted" ? "check" : "block");
    }
    paint() {
      const tile = HL.camera.shown?.current() ?? null;
      const robot = this.robot();
      attr(this.open, "hidden", !robot);
      attr(this.alone, "hidden", !tile);
      text(this.aloneWord, HL.camera.shown?.alone ? "All pictures" : "This one alone");
      attr(this.open, "href", robot ? `/operate/${robot}` : null);
      text(this.openWord, robot ? `Open ${HL.port.fleet()[robot]?.name ?? robot}` : "");
      attr(this.hint, "hidden", Boolean(tile));
      const { actions } = HL.port.robot(robot);
      const { verdict, robot: entry } = HL.camera.wall.items().get(robot) ?? {};
      const isWaiting = verdict?.waits && ASKS.includes(entry.code);
      const isOffered = Boolean(robot && isWaiting && actions?.skip_target?.ok);
      attr(this.skip, "data-state", this.isPending ? "pending" : null);
      attr(this.skip, "aria-disabled", this.isPending || (robot && refusal(robot)) ? "true" : null);
      if (isOffered) HL.camera.shown.offeredAt = performance.now();
      if (this.isPending) return; // it goes on naming what was asked
      this.offer = isOffered ? { robot, target: current(robot) } : null;
      attr(this.skip, "hidden", !isOffered);
      if (isOffered) text(this.skipWord, `Skip at ${HL.port.fleet()[robot]?.name ?? robot}`);
    }
  }

  const isTyping = (target) => target instanceof HTMLElement && target.closest("input:not([type=checkbox]), textarea, select, [contenteditable]");
  const KEYS = {
    j: (wall) => wall.step(1),
    k: (wall) => wall.step(-1),
    s: (wall) => wall.querySelector('[data-testid="camera-snapshot"]').click(),
    Enter: (wall, event) => !event.target.closest?.("button, a") && wall.current()?.one.robot !== "field" && wall.current() && HL.go(`/operate/${wall.current().one.robot}`),
    " ": (wall, event) => event.target.closest?.(".c-tile") && (event.preventDefault(), wall.enlarge(wall.current())),
    Escape: (wall) => (wall.alone ? wall.enlarge(null) : wall.choose(null)),
  };
  const LEADER_MS = 1500;
  let ledAt = -Infinity;
  window.addEventListener("keydown", (event) => {
    const wall = HL.camera.shown;
    const isLed = performance.now() - ledAt < LEADER_MS; // "g s" leads to Supervisor
    ledAt = event.key === "g" ? performance.now() : -Infinity;
    if (isLed || (event.repeat && event.key.toLowerCase() === "s") || !wall || event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented || isTyping(event.target) || document.querySelector(".h-scrim")) return;
    KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key]?.(wall, event);
  });

  HL.superDefine("hl-cameras", HL.camera.Cameras);
  HL.superDefine("hl-cameras-dock", CamerasDock);
})();
