// Live or replay: the last minutes as they were recorded, shown to this page alone.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle } = HL;
  const SPAN_MIN = 10;
  const SPEEDS = [1, 4, 16];
  const STEP_MS = 100;
  const LAG_MS = 2000; // what is shown is told twice a second; at speed the record moves on meanwhile
  const MOST_UNDONE = 200;
  const LONGEST_NAME = 80;

  const clock = (ms) => new Date(ms).toLocaleTimeString("en-GB");
  const isMissing = (value) => value === null || value === undefined;
  // beside a value that was not recorded only the nearer one counts
  const mix = (a, b, share) => (isMissing(a) || isMissing(b) ? (share < 0.5 ? a : b) ?? null : a + (b - a) * share);
  const turn = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
  const mixAngle = (a, b, share) => turn(a + turn(b - a) * share);

  // the sample at a moment, between two recorded ones; null in a gap of the record
  function at(samples, ms) {
    const times = samples.t;
    if (!times.length || ms < times[0] - 1500 || ms > times[times.length - 1] + 1500) return null;
    let high = times.findIndex((t) => t >= ms);
    if (high === -1) high = times.length - 1;
    const low = Math.max(0, high - 1);
    if (times[high] - times[low] > 5000 && ms - times[low] > 1500 && times[high] - ms > 1500) return null;
    const share = times[high] === times[low] ? 0 : Math.min(1, Math.max(0, (ms - times[low]) / (times[high] - times[low])));
    const joints = {};
    for (const [name, values] of Object.entries(samples.joints)) {
      const value = mix(values[low], values[high], share);
      if (value !== null) joints[name] = value;
    }
    return { lat_deg: mix(samples.lat[low], samples.lat[high], share), lon_deg: mix(samples.lon[low], samples.lon[high], share), theta_rad: mixAngle(samples.theta[low] ?? 0, samples.theta[high] ?? 0, share), joints, height_m: mix(samples.height?.[low], samples.height?.[high], share), at: ms };
  }

  class TwinReplay {
    constructor(link, robot, refusal) {
      Object.assign(this, { link, robot, refusal, isReplay: false, isPlaying: false, speed: 1, past: null });
      this.play = el("button", { type: "button", class: "h-btn ico", "data-testid": "twin-play", "aria-label": "Play", onclick: () => this.setPlaying(!this.isPlaying) }, icon("play_arrow", "f"));
      this.mode = el("div", { class: "h-seg", role: "group", "aria-label": "Live or replay" }, ...[["live", "Live"], ["replay", "Replay"]].map(([key, word]) => el("button", { type: "button", "data-key": key, "data-testid": `twin-${key}`, onclick: () => this.choose(key) }, word)));
      this.scrub = el("input", { type: "range", class: "t-scrub", min: 0, max: 1000, step: 1, "aria-label": "Moment", "data-testid": "twin-scrub", oninput: () => this.seek(this.from + (this.scrub.value / 1000) * (this.to - this.from)) });
      this.marks = el("div", { class: "t-marks", "aria-hidden": "true" });
      this.fast = el("button", { type: "button", class: "h-btn", "data-testid": "twin-speed", onclick: () => this.faster() }, "× 1");
      this.said = el("span", { class: "h-t14 h-b t-moment" });
      this.node = el("div", { class: "h-card t-replay", role: "group", "aria-label": "Time" }, this.mode, this.play, el("div", { class: "t-line" }, this.marks, this.scrub), this.fast, this.said);
      this.timer = setInterval(() => this.step(), STEP_MS);
      this.choose("live");
    }

    async choose(mode) {
      if (mode === "replay" && this.refusal) return HL.toast(this.refusal, "lock");
      if (this.isReplay !== (mode === "replay")) this.onturn?.();
      this.isReplay = mode === "replay";
      for (const button of this.mode.children) attr(button, "aria-pressed", button.dataset.key === mode ? "true" : "false");
      for (const node of [this.play, this.scrub, this.fast]) attr(node, "disabled", !this.isReplay);
      toggle(this.node, "off", !this.isReplay);
      this.setPlaying(false);
      if (!this.isReplay) {
        this.past = this.samples = this.loading = null;
        this.link.wish("replay", { k: "live" });
        return HL.repaint();
      }
      return this.load();
    }

    async load() {
      this.samples = null;
      const loading = (this.loading = {});
      HL.repaint();
      // by the console's clock: this machine's may be minutes apart
      const answer = await HL.port.api("GET", `/robots/${encodeURIComponent(this.robot)}/replay?minutes=${SPAN_MIN}`);
      if (this.loading !== loading) return;
      if (!answer.ok || !answer.data.t.length) {
        this.choose("live");
        HL.toast(answer.ok ? "Nothing was recorded in the last 10 minutes." : answer.text || "The record cannot be read.", "error");
        return;
      }
      this.samples = answer.data;
      this.from = this.samples.t[0];
      this.to = this.samples.t[this.samples.t.length - 1];
      this.drawMarks();
      this.seek(this.from);
      this.setPlaying(true);
    }

    drawMarks() {
      const where = (ms) => ((ms - this.from) / Math.max(1, this.to - this.from)) * 100;
      const events = (this.samples.events ?? []).filter((one) => one.t >= this.from && one.t <= this.to).slice(-24);
      this.marks.replaceChildren(...events.map((one) => el("i", { style: `left:${where(one.t)}%`, title: `${clock(one.t)} ${one.name}`, class: one.kind })));
    }

    seek(ms) {
      if (!this.samples?.t.length) return;
      this.moment = Math.min(this.to, Math.max(this.from, ms));
      this.scrub.value = ((this.moment - this.from) / Math.max(1, this.to - this.from)) * 1000;
      this.past = at(this.samples, this.moment);
      if (this.past) {
        const { lat_deg, lon_deg, theta_rad, height_m, joints } = this.past;
        this.link.wish("replay", { k: "replay", lat_deg, lon_deg, theta_rad, height_m, joints, undone: this.undone(), at_ms: Math.round(this.past.at) });
      }
      HL.repaint();
    }

    // places that were worked at after this moment; what ended after the record was read is known where it is drawn
    undone() {
      return (this.samples.events ?? []).filter((one) => one.target && one.target.length <= LONGEST_NAME && one.t > this.moment).map((one) => one.target).slice(-MOST_UNDONE);
    }

    // the moment that was asked for is the one in the picture
    isShown() {
      const shownMs = this.link.isPast() ? this.link.status.past_ms : null;
      return this.isReplay && Boolean(this.samples) && !isMissing(shownMs) && (!this.past || Math.abs(this.past.at - shownMs) <= LAG_MS * this.speed);
    }

    // the stretch of the record without any sample that the moment lies in, in words; the picture is that from before it
    gap() {
      if (!this.isReplay || !this.samples || this.past) return "";
      const next = this.samples.t.findIndex((t) => t > this.moment);
      return next > 0 ? `Nothing recorded from ${clock(this.samples.t[next - 1])} to ${clock(this.samples.t[next])}` : "Nothing recorded";
    }

    step() {
      if (!this.isPlaying) return;
      this.seek(this.moment + STEP_MS * this.speed);
      if (this.moment >= this.to) this.setPlaying(false);
    }

    setPlaying(isOn) {
      if (isOn && this.moment >= this.to) this.seek(this.from);
      this.isPlaying = isOn;
      this.play.replaceChildren(icon(isOn ? "pause" : "play_arrow", "f"));
      attr(this.play, "aria-label", isOn ? "Pause replay" : "Play");
    }

    faster() {
      this.speed = SPEEDS[(SPEEDS.indexOf(this.speed) + 1) % SPEEDS.length];
      text(this.fast, `× ${this.speed}`);
    }

    paint() {
      attr(this.node, "data-state", this.isReplay ? "replay" : "live");
      if (this.isReplay) {
        const word = !this.past ? "nothing recorded" : this.link.status?.past_unheard?.length ? "joints not recorded" : "recorded";
        text(this.said, this.isShown() ? `${clock(this.moment)}, ${word}` : "Loading the record");
        return;
      }
      if (this.link.isPast()) {
        text(this.said, "Going back to live");
        return;
      }
      const age = this.link.poseAge();
      text(this.said, age === null ? "––" : `${clock(Date.now())}, ${HL.words.age(age * 1000)} behind`);
    }

    close() {
      clearInterval(this.timer);
    }
  }

  HL.TwinReplay = TwinReplay;
  HL.replaySampleAt = at;
})();
