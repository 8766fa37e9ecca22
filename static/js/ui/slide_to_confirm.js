// Slide to confirm: drag past the flag and let go. Armed for 8 s; a second touch cancels.
// Without dragging: hold Enter or Space, or with `Confirm by: hold` the control itself, for 1.5 s.
(() => {
  "use strict";
  const { el, icon, text, attr, style, toggle } = HL;
  const ARM_MS = 8000;
  const HOLD_MS = 1500;
  const SPEAK_MS = 6000; // how long a cancellation or refusal stays before the control is itself again
  const PALM_PX = 48; // wider contacts are palms or rain
  const PAST = 0.9; // share of the way at which the thumb lies on the flag

  class Slide {
    // {hook, icon, label, line, goal, isHold, button: {icon, label} | null, seen: () => any, act: async (seen) => ({outcome, text})}
    // `seen` says what the act is about: the act gets it as it was when the person began, and another one cancels.
    constructor(options) {
      this.options = options;
      this.state = "idle";
      this.reason = "";
      this.isBusy = false;
      this.build();
    }

    build() {
      const { options } = this;
      this.fill = el("div", { class: "fill" });
      this.sign = icon(options.icon || "keyboard_double_arrow_right", "big");
      this.thumb = el("div", { class: "thumb", "data-testid": `${options.hook}-thumb` }, this.sign);
      this.label = el("div", { class: "label" });
      this.line = el("div", { class: "line" });
      this.goal = el("span", { class: "goal" }, icon(options.goal || "flag", "l f"));
      this.face = el("span", { class: "face" }, icon(options.button?.icon || "play_arrow", "l"), el("span", { class: "words" }, (this.faceLabel = el("span")), (this.faceSub = el("span", { class: "sub" }))));
      this.node = el("div", { class: "h-slide", role: "button", tabindex: "0", "data-testid": options.hook, "data-state": "idle" }, this.fill, this.thumb, el("div", { class: "lab" }, this.label, this.line), this.goal, this.face);
      this.node.addEventListener("pointerdown", (event) => this.down(event));
      this.node.addEventListener("click", (event) => this.click(event));
      this.node.addEventListener("keydown", (event) => this.key(event));
      this.node.addEventListener("keyup", () => this.holdBy === "key" && this.cancel());
      this.node.addEventListener("blur", () => this.holdBy === "key" && this.cancel());
      this.isOpen = !options.button;
      this.show();
    }

    isHold() {
      return this.options.isHold || HL.preferences.get("confirm") === "hold";
    }

    // `reason` empty: allowed. A control that becomes refused while armed lets go.
    allow(reason, line) {
      if (line !== undefined) this.options.line = line;
      this.reason = reason;
      if (this.state === "armed") {
        if (reason) this.cancel();
        else if (String(this.options.seen?.()) !== String(this.seen)) this.expire("What you saw has changed");
      }
      this.show();
    }

    click(event) {
      if (this.isOpen || this.isBusy) return;
      if (this.reason) return HL.toast(this.reason, "lock");
      event.stopPropagation();
      this.isOpen = true;
      this.arm();
      this.options.onopen?.(true);
      return undefined;
    }

    fold() {
      if (!this.options.button || !this.isOpen) return;
      this.isOpen = false;
      this.options.onopen?.(false);
    }

    arm() {
      this.state = "armed";
      this.seen = this.options.seen?.();
      clearTimeout(this.armTimer);
      this.armTimer = setTimeout(() => this.expire(), ARM_MS);
      this.show();
    }

    down(event) {
      if (!this.isOpen || this.reason || this.isBusy || event.button > 0) return;
      if (this.drag || this.holdBy) return this.cancel();
      if (event.width > PALM_PX || event.height > PALM_PX) return;
      const isHold = this.isHold();
      if (!isHold && !this.thumb.contains(event.target)) return;
      event.preventDefault();
      this.node.focus({ preventScroll: true });
      this.arm();
      this.listen(event.pointerId);
      if (isHold) this.hold("pointer");
      else this.drag = { id: event.pointerId, x: event.clientX, most: this.node.clientWidth - this.thumb.offsetWidth - 4, at: 0 };
    }

    // one finger only: everything else that touches the glass meanwhile cancels
    listen(id) {
      this.unlisten?.();
      const move = (event) => this.drag && event.pointerId === id && this.move(event);
      const up = (event) => event.pointerId === id && this.up();
      const other = (event) => event.pointerId !== id && this.cancel();
      const drop = () => this.cancel();
      const pairs = [["pointermove", move], ["pointerup", up], ["pointercancel", drop], ["pointerdown", other], ["blur", drop]];
      for (const [name, listener] of pairs) window.addEventListener(name, listener, true);
      document.addEventListener("visibilitychange", drop);
      this.unlisten = () => {
        for (const [name, listener] of pairs) window.removeEventListener(name, listener, true);
        document.removeEventListener("visibilitychange", drop);
        this.unlisten = null;
      };
    }

    move(event) {
      this.drag.at = Math.min(this.drag.most, Math.max(0, event.clientX - this.drag.x));
      this.show();
    }

    up() {
      const isPast = this.drag && this.drag.at >= PAST * this.drag.most;
      const isHolding = Boolean(this.holdBy);
      this.unlisten?.();
      this.drag = null;
      if (isPast) this.confirm();
      else if (isHolding) this.cancel();
      else {
        if (!this.options.button) this.state = "idle";
        this.show();
      }
    }

    key(event) {
      if (event.key === "Escape") return this.cancel();
      if ((event.key !== "Enter" && event.key !== " ") || event.repeat || this.isBusy) return;
      event.preventDefault();
      if (!this.isOpen) return this.click(event);
      if (this.reason || this.holdBy || this.drag) return;
      this.arm();
      this.hold("key");
    }

    hold(by) {
      this.holdBy = by;
      this.holdFrom = performance.now();
      const step = () => {
        if (!this.holdBy) return;
        if (performance.now() - this.holdFrom >= HOLD_MS) return this.confirm();
        this.show();
        requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }

    letGo() {
      this.unlisten?.();
      this.drag = null;
      this.holdBy = null;
      clearTimeout(this.armTimer);
    }

    cancel() {
      if (this.state !== "armed") return;
      this.letGo();
      this.state = "idle";
      this.fold();
      this.show();
    }

    expire(why = "Cancelled after 8 s") {
      this.letGo();
      this.state = "idle";
      this.fold();
      this.say(why, this.options.button ? "Tap the action again" : "Slide again", "timer_off");
    }

    async confirm() {
      this.letGo();
      this.state = "confirmed";
      this.isBusy = true;
      this.show();
      let result;
      try {
        result = await this.options.act(this.seen);
      } catch (error) {
        result = { outcome: "unknown", text: "No answer. It may have taken effect; look at the robot." };
        console.error(error);
      }
      this.isBusy = false;
      if (result.outcome === "accepted") {
        this.fold();
        this.say("Accepted", result.text || "The robot took it", "check", "confirmed", 2500);
      } else {
        this.say(HL.outcomeWords(result.outcome), result.text, "block", "refused");
      }
    }

    say(label, line, sign, state = "idle", ms = SPEAK_MS) {
      this.state = state;
      this.spoken = { label, line, sign };
      clearTimeout(this.spokenTimer);
      this.spokenTimer = setTimeout(() => {
        this.spoken = null;
        if (this.state !== "armed" && !this.isBusy) this.state = "idle";
        if (state === "refused") this.fold();
        this.show();
      }, ms);
      this.show();
    }

    // label and second line of the moment
    wording() {
      const { options } = this;
      if (this.isBusy) return [options.waits || "Sent, waiting for the robot", "Nothing is confirmed yet", "hourglass_top"];
      if (this.holdBy) return [`Hold, ${((performance.now() - this.holdFrom) / 1000).toFixed(1)} s of 1.5 s`, "Let go to cancel", null];
      if (this.drag && this.drag.at >= PAST * this.drag.most) return ["Let go now", "Release past the flag to confirm", "flag"];
      if (this.drag && this.drag.at > 8) return ["Keep sliding", "Let go to cancel", null];
      if (this.spoken && this.state !== "armed") return [this.spoken.label, this.spoken.line, this.spoken.sign];
      if (this.reason) return [options.label, this.isQuiet ? options.line : this.reason, "lock"];
      return [this.isHold() ? options.label.replace(/^Slide/, "Hold") : options.label, options.line, null];
    }

    show() {
      const [label, line, sign] = this.wording();
      const at = this.drag ? this.drag.at : this.isBusy || (this.state === "confirmed" && this.spoken) ? Math.max(0, this.node.clientWidth - this.thumb.offsetWidth - 4) : 0;
      const share = this.holdBy ? (performance.now() - this.holdFrom) / HOLD_MS : 0;
      attr(this.node, "data-state", this.state);
      attr(this.node, "aria-disabled", this.reason ? "true" : null);
      attr(this.node, "aria-label", this.isOpen ? `${label}. ${line}. Or hold Enter for 1.5 s` : `${this.options.button.label}${this.reason ? `. Off: ${this.reason}` : ""}`);
      toggle(this.node, "folded", !this.isOpen);
      toggle(this.node, "off", Boolean(this.reason));
      toggle(this.node, "right", at > this.node.clientWidth / 2);
      style(this.thumb, "transform", `translateX(${at}px)`);
      style(this.fill, "width", this.holdBy ? `${Math.min(100, share * 100)}%` : `${at ? at + 44 : 0}px`);
      text(this.sign, sign || this.options.icon || "keyboard_double_arrow_right");
      text(this.label, label);
      text(this.line, line || "");
      text(this.faceLabel, this.spoken && !this.isOpen ? this.spoken.label : this.options.button?.label || "");
      text(this.faceSub, this.isOpen ? "" : this.spoken ? this.spoken.line : "");
    }

    drop() {
      this.letGo();
      clearTimeout(this.spokenTimer);
    }
  }

  const OUTCOMES = { accepted: "Accepted", rejected: "Robot did not accept", timed_out: "No answer in time", unknown: "Outcome unknown", refused: "Not sent", pending: "Waiting for the robot" };
  Object.assign(HL, { Slide, outcomeWords: (outcome) => OUTCOMES[outcome] || "Not accepted", PALM_PX });
})();
