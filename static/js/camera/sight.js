// What is on the screen and how old it is: delay, rate, frozen or not. Pure: the caller tells both clocks.
(() => {
  "use strict";
  const FROZEN_MS = 1000; // of streams of 2 Hz and more, still pictures among them
  const SLOW_PERIODS = 3;
  const LOADING_MS = 5000; // then it is said what is wrong
  const GONE_MS = 30000; // a picture this old tells nothing about now
  const AGAIN_MS = [3000, 5000, 10000, 20000, 30000];
  const FPS_MS = 2000;
  const DELAYS = 9;
  const MOST_TIMES = 256;

  const isSlow = (periodS) => periodS > 0.5; // its pictures are old when the next one comes

  const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

  // capture times of direct pictures by their RTP time stamp; either may come first
  class Times {
    constructor() {
      this.known = new Map();
      this.waiting = new Map();
    }
    // -> [{captured, at}] of pictures that were shown before their time was told
    told(list) {
      const found = [];
      for (const [rtp, captured] of list) {
        if (this.waiting.has(rtp)) found.push({ captured, at: this.waiting.get(rtp) });
        this.waiting.delete(rtp);
        this.known.set(rtp, captured);
      }
      this.#trim(this.known);
      return found;
    }
    // at: when it is shown -> capture time of that picture, null while nobody told it
    shown(rtp, at) {
      const captured = this.known.get(rtp);
      if (captured !== undefined) return captured;
      this.waiting.set(rtp, at);
      this.#trim(this.waiting);
      return null;
    }
    #trim(map) {
      while (map.size > MOST_TIMES) map.delete(map.keys().next().value);
    }
  }

  class Sight {
    constructor(now) {
      Object.assign(this, { began: now, last: null, captured: null, isDated: true, delays: [], shown: [] });
    }

    // a picture is on the screen; captured and m on the console's clock, null while unknown
    picture(now, captured, m, isDated = true) {
      if (captured !== null && captured === this.captured) return; // the same once more
      this.before = this.last;
      this.last = now;
      this.isDated = isDated;
      this.shown.push(now);
      while (this.shown.length > 2 && this.shown[0] < now - FPS_MS) this.shown.shift();
      if (captured !== null) this.dated(captured, m);
    }

    // when the picture that was shown at now was taken; older news changes nothing, and the same once more is no new picture
    dated(captured, m, now = null) {
      if (captured === this.captured && now === this.last) this.last = this.before;
      if (this.captured !== null && captured <= this.captured) return;
      this.captured = captured;
      if (m === null) return;
      this.delays.push(Math.max(0, m - captured));
      if (this.delays.length > DELAYS) this.delays.shift();
    }

    // begins to wait anew; the last picture stays, as old as it is
    again(now) {
      Object.assign(this, { began: now, delays: [], shown: [] });
    }

    delayMs() {
      return this.delays.length ? median(this.delays) : null;
    }

    fps(now) {
      const [first] = this.shown;
      if (this.shown.length < 2) return null;
      return ((this.shown.length - 1) * 1000) / Math.max(1, Math.max(this.last - first, now - this.last > FPS_MS ? now - first : 0));
    }

    // after a silence a camera's last picture may be sent once more: only its time tells
    isSilent(now, periodS) {
      return this.last !== null && now - this.last > this.limitMs(periodS);
    }

    // without a new picture for longer than this it is frozen
    limitMs(periodS) {
      return isSlow(periodS) ? SLOW_PERIODS * 1000 * periodS : FROZEN_MS;
    }

    // camera: what the server says of it, or null
    judge(now, m, camera) {
      const limit = this.limitMs(camera?.period_s);
      const hasSlow = isSlow(camera?.period_s);
      const silentMs = now - (this.last ?? this.began);
      const ageMs = this.captured !== null && m !== null ? Math.max(0, m - this.captured) : this.last === null ? null : silentMs;
      const isDown = camera !== null && ["failed", "off"].includes(camera.state);
      const facts = { silentMs, ageMs, delayMs: this.delayMs(), fps: this.fps(now), isDated: this.isDated, isSlow: hasSlow, hasPicture: this.last !== null };
      if (this.last === null) return { ...facts, state: isDown || silentMs > LOADING_MS ? "off" : "connecting" };
      if (silentMs > limit || (ageMs > limit && isDown)) return { ...facts, state: ageMs > Math.max(GONE_MS, limit) ? "off" : "frozen" };
      return { ...facts, state: (hasSlow ? ageMs > limit : facts.delayMs > FROZEN_MS) ? "late" : "live" };
    }
  }

  // when a frozen camera is asked for anew: ever more rarely, from the beginning after it was live
  class Again {
    constructor() {
      this.rest();
    }
    rest() {
      Object.assign(this, { tries: 0, at: null });
    }
    // is it due now? told at each look
    isDue(now, state) {
      if (state === "live") this.rest();
      if (!["frozen", "off"].includes(state)) return false;
      this.at ??= now + AGAIN_MS[Math.min(this.tries, AGAIN_MS.length - 1)];
      if (now < this.at) return false;
      this.tries += 1;
      this.at = null;
      return true;
    }
  }

  Object.assign(HL.camera, { Times, Sight, Again, isSlow });
})();
