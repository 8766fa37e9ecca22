// The tones of STOP, made here so that no file has to load. A browser lets them sound after the first touch.
(() => {
  "use strict";
  const parts = (window.headlandStopParts = window.headlandStopParts || {});
  // state -> how often, and the tones as [start s, frequency Hz, length s]
  const PATTERNS = {
    sent: { everyMs: 1000, tones: [[0, 880, 0.04]] },
    acknowledged: { everyMs: 500, tones: [[0, 880, 0.04]] },
    standstill: { everyMs: 0, tones: [[0, 784, 0.18], [0.2, 523, 0.28]] },
    "not-confirmed": { everyMs: 2000, tones: [[0, 988, 0.15], [0.25, 988, 0.15], [0.5, 988, 0.15]], shake: [150, 100, 150, 100, 150] },
    "no-link": { everyMs: 10000, tones: [[0, 784, 0.15], [0.3, 784, 0.15]] },
    "no-path": { everyMs: 10000, tones: [[0, 784, 0.15], [0.3, 784, 0.15]] },
  };

  class Sound {
    constructor() {
      this.state = "";
      this.nextAt = Infinity;
      this.silentUntil = 0;
      this.endsAt = 0;
      const unlock = () => this.unlock();
      for (const kind of ["pointerdown", "keydown"]) window.addEventListener(kind, unlock, { capture: true, passive: true });
    }

    unlock() {
      try {
        this.context = this.context || new AudioContext();
        if (this.context.state === "suspended") this.context.resume();
      } catch {
        this.context = null; // no sound on this machine; colour, word and sign say it too
      }
    }

    // `isNew`: this state began now, so it may sound; a page that opens on an old one stays quiet until it changes.
    follow(state, now, isNew) {
      if (state !== this.state) {
        this.state = state;
        this.nextAt = PATTERNS[state] && isNew ? now : Infinity;
        if (isNew && state === "not-confirmed") this.silentUntil = 0; // a new one sounds again
      }
      if (now < this.nextAt) return;
      const { everyMs, tones, shake } = PATTERNS[state];
      this.nextAt = everyMs ? now + everyMs : Infinity;
      if (now < this.silentUntil) return;
      this.play(tones);
      this.endsAt = now + Math.max(...tones.map(([start, , length]) => (start + length) * 1000));
      if (shake && navigator.vibrate) navigator.vibrate(shake);
    }

    // what other sounds of the page give way to: the state that makes tones now or will again, and in how many ms
    sounding(now) {
      if (now < this.endsAt) return { state: this.state, inMs: 0 };
      return this.nextAt < Infinity && now >= this.silentUntil ? { state: this.state, inMs: this.nextAt - now } : null;
    }

    silence(now, forMs) {
      this.silentUntil = now + forMs;
    }

    play(tones) {
      if (this.context?.state !== "running") return;
      for (const [start, frequency, length] of tones) {
        const at = this.context.currentTime + start;
        const [tone, volume] = [this.context.createOscillator(), this.context.createGain()];
        tone.frequency.value = frequency;
        volume.gain.setValueAtTime(0, at);
        volume.gain.linearRampToValueAtTime(0.35, at + 0.01);
        volume.gain.setValueAtTime(0.35, at + length - 0.015);
        volume.gain.linearRampToValueAtTime(0, at + length);
        tone.connect(volume).connect(this.context.destination);
        tone.start(at);
        tone.stop(at + length + 0.02);
      }
    }
  }

  parts.Sound = Sound;
})();
