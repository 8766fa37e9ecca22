// A walk while it is recorded: it goes on while other screens are shown, and what was heard outlives the page.
(() => {
  "use strict";
  const M = HL.maps;
  const LOOK_MS = 250;
  const KEEP_MS = 5000; // so much of a walk is lost at most when a browser ends without a word
  const STEP_M = 0.5; // closer positions tell nothing new at walking speed
  const UNKNOWN_M = 5; // a receiver that does not say how good it is, is not believed much
  const MOST_HEARD = 100000; // positions; the server takes no more
  const GAP_S = 5; // as the server: longer without a position nobody knows where the edge went
  const GAP_M = 5;
  const MISSED_S = 2; // receivers tell once a second and miss one now and then
  const KEPT_M = 0.25; // positions that are kept lie so far apart, or
  const KEPT_S = 2;
  const MOST_KEPT = 30000; // 1.3 MB of the 5 MB that browsers keep for a whole site
  const OLD_MS = 12 * 3600 * 1000; // nobody goes on with a walk of yesterday

  const far = (a, b) => Math.hypot(...M.plane([a.lon, a.lat]).flat([b.lon, b.lat]));
  const at = ({ lon, lat }) => [lon, lat];
  const packed = ({ lon, lat, accuracy_m: accuracy, at_s: time }) => [Number(lon.toFixed(8)), Number(lat.toFixed(8)), Number(accuracy.toFixed(3)), Number(time.toFixed(2))];

  // what nobody saw between two positions, or null
  function gapBetween(a, b) {
    const seconds = b.at_s - a.at_s;
    const metres = far(a, b);
    return seconds > GAP_S || (metres > GAP_M && seconds > MISSED_S) ? { start: at(a), end: at(b), seconds, metres } : null;
  }

  class Recording {
    constructor() {
      this.source = null;
      this.forget();
    }

    forget() {
      this.heard = []; // every position, for weighing
      this.points = []; // places apart from each other: the picture
      this.breaks = new Set(); // numbers of points before which nobody saw where it went
      this.gaps = [];
      this.kept = []; // for going on after a reload: positions apart from each other
      this.worst = 0;
      this.shift = 0; // from the clock of the source on that of the walk
      this.isOn = HL.isWalking = false;
      this.isPaused = false; // told by an earlier page; nobody said yet that it goes on
    }

    get isFull() {
      return this.heard.length >= MOST_HEARD;
    }

    get key() {
      return `walk-${this.farm}`;
    }

    // whose position is looked at, whether it is recorded or not
    listen(source) {
      this.source?.stop();
      this.source = source;
      source?.start();
    }

    // how: {kind, robot, name}
    begin(how) {
      this.forget();
      Object.assign(this, how);
      this.run();
    }

    goOn() {
      this.isResuming = true;
      this.isPaused = false;
      this.run();
    }

    run() {
      this.isOn = HL.isWalking = true;
      this.lookedAt = null;
      clearInterval(this.timer);
      this.timer = setInterval(() => this.look(), LOOK_MS);
      this.look();
    }

    // takes the newest position when it is fresh and new
    look() {
      if (!this.isOn || !this.source) return;
      const { pose, isFresh } = this.source;
      if (isFresh && pose.at_s !== this.lookedAt) this.add(pose);
      if (Date.now() - (this.keptMs ?? 0) > KEEP_MS) this.keep();
    }

    add(pose) {
      if (this.isFull) return;
      this.lookedAt = pose.at_s;
      const last = this.heard.at(-1);
      if (this.isResuming && last) this.shift = last.at_s + Math.max((Date.now() - this.heardMs) / 1000, 0.1) - pose.at_s; // this page may count from another start
      this.isResuming = false;
      this.heardMs = Date.now();
      this.take({ lon: pose.lon, lat: pose.lat, accuracy_m: pose.accuracy_m ?? UNKNOWN_M, at_s: pose.at_s + this.shift });
      if (pose.accuracy_m === null || pose.accuracy_m === undefined) this.worst = Infinity;
    }

    take(position) {
      const last = this.heard.at(-1);
      const gap = last && gapBetween(last, position);
      this.heard.push(position);
      this.worst = Math.max(this.worst, position.accuracy_m);
      const seen = this.kept.at(-1);
      if (this.kept.length < MOST_KEPT && (!seen || gap || far(seen, position) >= KEPT_M || position.at_s - seen.at_s >= KEPT_S)) this.kept.push(position);
      if (gap) this.gaps.push(gap);
      const point = this.points.at(-1);
      if (point && Math.hypot(...M.plane(point).flat(at(position))) < STEP_M) return;
      if (gap) this.breaks.add(this.points.length);
      this.points.push(at(position));
    }

    // what is missing at the end: the receiver fell silent before somebody said that this is all
    ending(isClosed) {
      const last = this.heard.at(-1);
      const metres = isClosed ? far(last, this.heard[0]) : 0;
      const seconds = this.isPaused ? 0 : (Date.now() - this.heardMs) / 1000;
      if (seconds <= GAP_S && !(this.isPaused && metres > GAP_M)) return [];
      return [{ start: at(last), end: isClosed ? at(this.heard[0]) : null, seconds, metres }];
    }

    keep() {
      this.keptMs = Date.now();
      if (!this.isOn || !this.heard.length) return;
      const { kind, robot, name, heardMs, kept } = this;
      HL.draft.set(this.key, { kind, robot, name, heardMs, heard: kept.map(packed) });
    }

    // brings back what an earlier page of this person heard on this farm; false when there is nothing
    recall() {
      const { kind, robot, name, heardMs, heard } = HL.draft.get(this.key) || {};
      if (this.isOn || !heard?.length) return false;
      if (Date.now() - heardMs > OLD_MS) return HL.draft.clear(this.key), false;
      this.forget();
      Object.assign(this, { kind, robot, name, heardMs });
      for (const [lon, lat, accuracy, time] of heard) this.take({ lon, lat, accuracy_m: accuracy, at_s: time });
      this.isPaused = true;
      return true;
    }

    // it became a feature, or somebody threw it away
    end() {
      clearInterval(this.timer);
      this.listen(null);
      HL.draft.clear(this.key);
      this.forget();
    }
  }

  const recording = new Recording();
  window.addEventListener("pagehide", () => recording.keep());
  document.addEventListener("visibilitychange", () => document.hidden && recording.keep());
  Object.assign(M, { recording, gapBetween });
})();
