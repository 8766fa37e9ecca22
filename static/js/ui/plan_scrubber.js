// Plays a plan: a slider over its time, by finger, keys or by itself.
(() => {
  "use strict";
  const { el, icon, attr, text } = HL;
  const WHOLE_S = 60; // a whole plan plays in a minute
  const CALM_MS = 1000; // with reduced motion it goes on in steps

  const pad = (number) => String(number).padStart(2, "0");
  // h:mm for hours, m:ss below one hour
  function clock(s, whole) {
    if (whole >= 3600) return `${Math.floor(s / 3600)}:${pad(Math.floor((s % 3600) / 60))}`;
    return `${Math.floor(s / 60)}:${pad(Math.floor(s % 60))}`;
  }

  class Scrubber {
    // moved(t) is called with each new time and answers {row, isBack} or null
    constructor(moved) {
      this.moved = moved;
      this.duration = 0;
      this.sign = icon("play_arrow");
      this.button = el("button", { type: "button", class: "h-btn ico", "aria-label": "Play the plan", "data-testid": "plan-play", onclick: () => (this.isPlaying ? this.pause() : this.play()) }, this.sign);
      this.input = el("input", { type: "range", class: "p-range", min: "0", max: "1000", step: "1", value: "0", "aria-label": "Time in the plan", "data-testid": "plan-scrubber" });
      this.words = el("span", { class: "h-t14 h-b p-when", "data-testid": "plan-when" });
      this.node = el("div", { class: "p-scrub h-card", hidden: true }, this.button, this.input, this.words);
      this.input.addEventListener("input", () => {
        this.pause();
        this.to(this.path ? this.path.timeAt(Number(this.input.value) / 1000) : 0);
      });
    }

    // a Path of plan_path.js
    load(path) {
      this.path = path;
      this.duration = path.duration;
      this.node.hidden = !(path.duration > 0);
      this.pause();
      this.to(0);
    }

    to(t) {
      this.t = Math.min(Math.max(t, 0), this.duration);
      const share = this.duration ? this.path.shareAt(this.t) : 0;
      this.input.value = String(Math.round(1000 * share));
      this.input.style.setProperty("--share", `${(100 * share).toFixed(1)}%`);
      const pose = this.moved(this.t);
      const unit = this.duration >= 3600 ? "h" : "min";
      const words = `${clock(this.t, this.duration)} of ${clock(this.duration, this.duration)} ${unit}, ${pose?.row ? `row ${pose.row}` : "on the way"}${pose?.isBack ? ", backing up" : ""}`;
      text(this.words, `Preview ${words}`);
      attr(this.input, "aria-valuetext", words);
      attr(this.node, "data-value", Math.round(this.t));
    }

    play() {
      if (this.t >= this.duration) this.to(0);
      this.isPlaying = true;
      this.face();
      const isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;
      let last = performance.now();
      const step = (now) => {
        if (!this.isPlaying || !this.node.isConnected) return;
        if (!isCalm || now - last >= CALM_MS) {
          this.to(this.path.timeAt(this.path.shareAt(this.t) + (now - last) / 1000 / WHOLE_S));
          last = now;
        }
        if (this.t >= this.duration) this.pause();
        else requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    }

    pause() {
      this.isPlaying = false;
      this.face();
    }

    face() {
      text(this.sign, this.isPlaying ? "pause" : "play_arrow");
      attr(this.button, "aria-label", this.isPlaying ? "Pause" : "Play the plan");
      attr(this.node, "data-state", this.isPlaying ? "playing" : "paused");
    }
  }

  HL.planner.Scrubber = Scrubber;
})();
