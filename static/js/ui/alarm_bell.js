// The bell: alarm tones on every screen, and new alarms said to who cannot see them. Loaded after STOP is ready.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define } = HL;
  const { Tones, TEST } = HL.alarmTones;
  const { isNews, isUnanswered } = HL.alarmOrder;
  const SILENCE_MS = 120000;
  const LOOK_MS = 200; // a tone is not late by what anybody hears
  const SAY_MS = 3000; // a screen reader is not told faster
  const TESTED_KEY = `headland.bell.${HL.config.session}`;
  let context = null;
  let played = 0;

  const isRunning = () => context?.state === "running";

  function play({ tones, shake }) {
    played += 1;
    if (shake && navigator.vibrate && navigator.userActivation?.hasBeenActive) navigator.vibrate(shake);
    if (!isRunning()) return;
    for (const [start, frequency, length] of tones) {
      const at = context.currentTime + start;
      const [tone, volume] = [context.createOscillator(), context.createGain()];
      tone.frequency.value = frequency;
      volume.gain.setValueAtTime(0, at);
      volume.gain.linearRampToValueAtTime(0.3, at + 0.01);
      volume.gain.setValueAtTime(0.3, at + length - 0.015);
      volume.gain.linearRampToValueAtTime(0, at + length);
      tone.connect(volume).connect(context.destination);
      tone.start(at);
      tone.stop(at + length + 0.02);
    }
  }

  // the first touch lets a page sound; once a sign-in it is heard that it does
  async function unlock() {
    try {
      context ||= new AudioContext();
      if (context.state === "suspended") await context.resume();
    } catch {
      context = null; // no sound on this machine; colour, shape and words say it too
    }
    if (!isRunning()) return;
    for (const kind of TOUCHES) window.removeEventListener(kind, unlock, true);
    if (!sessionStorage.getItem(TESTED_KEY)) {
      sessionStorage.setItem(TESTED_KEY, "1");
      play(TEST);
    }
    HL.repaint();
  }
  const TOUCHES = ["pointerdown", "keydown"];
  for (const kind of TOUCHES) window.addEventListener(kind, unlock, { capture: true, passive: true });
  if (navigator.userActivation?.hasBeenActive) unlock();

  const tones = new Tones({ play, stop: () => window.headlandStop?.sounding() ?? null });
  // the slab sounds a lost link like an alarm of priority 2; once that alarm was seen here, it has been heard
  function quietSeenLink() {
    const robot = HL.view.robot;
    if (!robot || HL.linkState() !== "robot-lost") return;
    const isSeen = Object.values(HL.alarms.all()).some((one) => one.source === robot && one.code === "link-lost" && !HL.alarms.isUnseen(one));
    const stop = isSeen && window.headlandStop?.state();
    if (stop && stop.state === "no-link" && !stop.failing.length) window.headlandStop.silence(2 * LOOK_MS);
  }

  function look() {
    quietSeenLink();
    const said = HL.alarms.summary();
    if (said) tones.follow(HL.alarms.all(), performance.now(), Boolean(said.flood));
  }

  const bell = {
    // blocked: the browser lets nothing sound before a touch
    state: () => (!isRunning() ? "blocked" : tones.silentForMs(performance.now()) ? "silenced" : "on"),
    level: () => tones.level,
    silentMs: () => tones.silentForMs(performance.now()),
    silence() {
      tones.silence(performance.now(), SILENCE_MS);
      window.headlandStop?.silence(SILENCE_MS);
      HL.repaint();
    },
    turnOn() {
      tones.loud();
      window.headlandStop?.silence(0);
      if (isRunning()) play(TEST);
      else unlock();
      HL.repaint();
    },
  };

  // in the top bar: only where a person has to do something, about what nobody answered or about the sound
  class Sound extends LiveElement {
    build() {
      this.style.display = "contents"; // what is hidden leaves no gap
      this.many = el("b");
      this.unanswered = el("a", { class: "h-btn h-soundoff", href: "/alarms", "data-testid": "alarm-unanswered", hidden: true }, icon("notifications_active", "m"), this.many, el("span", { class: "wide" }, "not answered"));
      Object.assign(this.unanswered.style, { flex: "none", gap: "4px", padding: "0 8px", borderStyle: "solid", borderColor: "var(--hl-p2)", color: "var(--hl-p2-text)" });
      this.word = el("span", { class: "wide" });
      this.button = el("button", { type: "button", class: "h-btn h-soundoff", onclick: () => bell.turnOn() }, icon("volume_off"), this.word);
      this.append(this.unanswered, this.button);
    }
    paint() {
      this.paintUnanswered();
      const state = bell.state();
      attr(this, "data-state", state);
      attr(this, "data-value", bell.level() ?? 0);
      attr(this, "data-count", played);
      attr(this.button, "hidden", state === "on" || HL.view.screen === "alarms"); // that screen has its own
      const words = state === "silenced" ? `Silent ${HL.words.clock(bell.silentMs() / 1000)}` : "Sound is off. Tap to turn on.";
      text(this.word, words);
      attr(this.button, "aria-label", state === "silenced" ? `${words}. Tap to turn on.` : words);
    }
    paintUnanswered() {
      const count = Object.values(HL.alarms.all()).filter(isUnanswered).length;
      attr(this.unanswered, "hidden", !count || HL.view.screen === "alarms");
      attr(this.unanswered, "data-value", count);
      attr(this.unanswered, "aria-label", `${count} not answered. Go to Alarms`);
      text(this.many, count);
    }
  }

  // new alarms in words: at once for priority 1, the others as they come, many as a number
  class Voice extends LiveElement {
    build() {
      this.alert = el("div", { role: "alert", "data-testid": "alarm-voice-alert" });
      this.polite = el("div", { role: "status", "aria-live": "polite", "data-testid": "alarm-voice" });
      this.append(this.alert, this.polite);
      this.waiting = [];
      this.saidAt = -Infinity;
    }
    enter() {
      this.off = window.headland.on("event", (event) => event?.kind === "alarm" && this.hear(event));
    }
    leave() {
      this.off?.();
    }
    hear(event) {
      if (!isNews(event)) return;
      const words = `Priority ${event.priority}. ${event.name}: ${event.title}.`;
      if (event.priority === 1) text(this.alert, this.alert.hlText === words ? `${words} Again.` : words);
      else this.waiting.push(words);
      HL.repaint();
    }
    paint() {
      if (!this.waiting.length || performance.now() - this.saidAt < SAY_MS) return;
      text(this.polite, this.waiting.length > 2 ? `${this.waiting.length} new alarms. ${this.waiting[0]}` : this.waiting.join(" "));
      this.waiting = [];
      this.saidAt = performance.now();
    }
  }

  HL.bell = bell;
  define("hl-alarm-sound", Sound);
  define("hl-alarm-voice", Voice);
  setInterval(look, LOOK_MS);
})();
