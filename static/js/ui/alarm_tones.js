// Which alarm tone sounds when: only the highest priority that nobody acknowledged. Pure; times in ms of one clock.
(() => {
  "use strict";
  // priority -> how often, and the tones as [start s, frequency Hz, length s]
  const PATTERNS = {
    1: { everyMs: 2000, tones: [[0, 988, 0.15], [0.25, 988, 0.15], [0.5, 988, 0.15]], shake: [150, 100, 150, 100, 150] },
    2: { everyMs: 10000, tones: [[0, 784, 0.15], [0.3, 784, 0.15]] },
    3: { everyMs: 0, tones: [[0, 587, 0.15]] },
  };
  const TEST = { tones: [[0, 587, 0.1]] };
  const GAP_MS = 2000; // many new ones at once are one sound, not a rattle
  const LONGEST_MS = 700;
  // STOP says these itself, louder than any alarm: a person is stopping a machine
  const STOP_ALONE = ["sent", "acknowledged", "standstill", "not-confirmed"];

  // those that ask for an ear: active and not acknowledged; one whose condition is gone asks only if it latches
  const isLoud = (one) => one.state === "unacknowledged" || (one.state === "returned" && one.latching);

  class Tones {
    // play(pattern) makes the sound; stop() -> {state, inMs} of STOP's own tones, or null
    constructor({ play, stop = () => null }) {
      this.play = play;
      this.stop = stop;
      this.known = null; // occurrences heard of; null before the first look
      this.level = null; // priority that sounds now
      this.nextAt = Infinity;
      this.lastAt = -Infinity;
      this.silentUntil = -Infinity;
    }

    // alarms: {id: entry}; isFlood mutes priorities 3 and 4
    follow(alarms, now, isFlood = false) {
      if (alarms !== this.heardOf || isFlood !== this.wasFlood) this.hear(alarms, now, isFlood); // the lane makes a new list of each change
      [this.heardOf, this.wasFlood] = [alarms, isFlood];
      this.ring(now);
    }

    hear(alarms, now, isFlood) {
      const loud = Object.entries(alarms).filter(([, one]) => isLoud(one) && PATTERNS[one.priority] && !(isFlood && one.priority > 2));
      const fresh = this.takeIn(loud);
      const level = loud.length ? Math.min(...loud.map(([, one]) => one.priority)) : null;
      // a new critical one sounds again, and what nobody answered
      if (fresh.some((one) => one.priority === 1 || (one.priority === 2 && one.escalated))) this.silentUntil = -Infinity;
      const isNewHere = fresh.some((one) => one.priority === level);
      if (level !== this.level || isNewHere) this.start(level, now, isNewHere);
      this.level = level;
    }

    // what was not heard of before, or was told on since; a page that opens finds everything old
    takeIn(loud) {
      const key = ([id, one]) => `${id} ${one.raised} ${one.occurrences} ${one.escalated}`;
      const fresh = this.known === null ? [] : loud.filter((entry) => !this.known.has(key(entry))).map(([, one]) => one);
      this.known = new Set(loud.map(key));
      return fresh;
    }

    // 1 and 2 sound as long as they stand, 3 only when it is new
    start(level, now, isNew) {
      const isDue = level !== null && (isNew || PATTERNS[level].everyMs > 0);
      this.nextAt = isDue ? Math.max(now, this.lastAt + (level === 1 ? LONGEST_MS : GAP_MS)) : Infinity;
    }

    ring(now) {
      if (now < this.nextAt || this.level === null) return;
      if (now < this.silentUntil) {
        if (!PATTERNS[this.level].everyMs) this.nextAt = Infinity; // one tone that was silenced is not made up for
        return;
      }
      const stop = this.stop();
      if (stop && STOP_ALONE.includes(stop.state)) return;
      if (stop && this.level > 1) return; // its lost link is this same sound
      if (stop && stop.inMs < LONGEST_MS) return;
      const { everyMs } = PATTERNS[this.level];
      this.nextAt = everyMs ? now + everyMs : Infinity;
      this.lastAt = now;
      this.play(PATTERNS[this.level]);
    }

    silence(now, forMs) {
      this.silentUntil = now + forMs;
    }

    loud() {
      this.silentUntil = -Infinity;
    }

    silentForMs(now) {
      return Math.max(0, this.silentUntil - now);
    }
  }

  HL.alarmTones = { Tones, PATTERNS, TEST };
})();
