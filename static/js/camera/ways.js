// By which way pictures come: decided from what arrived, on a clock that the caller tells. Pure: no DOM, no sockets.
(() => {
  "use strict";
  const SAID_MS = 2000; // a camera gives pictures and none came directly: a person is told
  const GIVES_MS = 500; // for so long, so that a slow start of the camera is not taken for a closed way
  const TRY_MS = 8000; // a slow tablet may still get there; then trying again later costs less than waiting
  const SILENT_MS = 1000; // direct pictures stopped while the camera goes on
  const STEADY_MS = 10000; // after so long the next trouble counts as the first
  const AGAIN_MS = [5000, 10000, 20000, 40000, 60000];
  const POOR_MS = 1000; // pictures over the server that are older than this
  const POOR_FOR_MS = 3000; // for so long are too many for this line

  const NO_WAY = "No direct way to the camera";

  const later = (now, tries) => now + AGAIN_MS[Math.min(tries, AGAIN_MS.length - 1)];

  // direct: "trying", "live", "off" or "never"; server: "jpeg" or "still"
  class Ways {
    constructor(now, { hasDirect = true, why = "" } = {}) {
      Object.assign(this, { direct: hasDirect ? "trying" : "never", since: now, tries: 0, retryAt: Infinity, hasGivenUp: !hasDirect && Boolean(why), why }); // without a reason it is a choice, not a loss
      Object.assign(this, { server: "jpeg", poorSince: null, goodSince: null, drops: 0, betterAt: Infinity, arrived: null });
      Object.assign(this, { lastDirect: -Infinity, firstCamera: null, lastCamera: -Infinity });
    }

    // a new picture came directly and is on the screen
    directPicture(now) {
      this.lastDirect = now;
      this.cameraPicture(now);
      if (this.direct !== "trying") return;
      Object.assign(this, { direct: "live", since: now, hasGivenUp: false, why: "", server: "jpeg", poorSince: null });
    }

    directFailed(now, why) {
      if (this.direct === "never" || this.direct === "off") return;
      if (this.direct === "live" && now - this.since > STEADY_MS) this.tries = 0;
      Object.assign(this, { direct: "off", since: now, retryAt: later(now, this.tries), hasGivenUp: true, why });
      this.tries += 1;
      this.firstCamera = null;
    }

    // the camera made a picture, whichever way it came or was told
    cameraPicture(now) {
      this.firstCamera ??= now;
      this.lastCamera = now;
    }

    // a picture came over the server; the same once more says nothing new, and a null age nothing about the line
    serverPicture(now, ageMs, seq = null) {
      if (seq !== null && seq === this.arrived) return;
      this.arrived = seq;
      this.cameraPicture(now);
      const isPoor = ageMs !== null && ageMs >= POOR_MS;
      this.poorSince = isPoor ? this.poorSince ?? now : null;
      this.goodSince = isPoor || this.server === "still" ? null : this.goodSince ?? now;
      if (this.goodSince !== null && now - this.goodSince > STEADY_MS) this.drops = 0;
    }

    // everything from the beginning: the camera or the server came back, or somebody asked for it
    again(now) {
      if (this.direct === "off") Object.assign(this, { direct: "trying", since: now, retryAt: Infinity });
      this.firstCamera = null;
    }

    // -> {direct: is it wanted, way: what the socket is asked for, shown: "direct" or "server"}
    look(now) {
      this.#lookDirect(now);
      this.#lookServer(now);
      const isLive = this.direct === "live";
      return { direct: isLive || this.direct === "trying", way: isLive ? "times" : this.server, shown: isLive ? "direct" : "server", hasGivenUp: this.hasGivenUp && !isLive, why: this.why };
    }

    #lookDirect(now) {
      if (this.direct === "off" && now >= this.retryAt) Object.assign(this, { direct: "trying", since: now, retryAt: Infinity, firstCamera: null });
      if (this.direct === "trying") {
        if (this.firstCamera !== null && now - this.firstCamera >= GIVES_MS && now - this.since >= SAID_MS) Object.assign(this, { hasGivenUp: true, why: NO_WAY });
        if (now - this.since >= TRY_MS) this.#waitQuietly(now);
      }
      if (this.direct === "live" && this.lastCamera - this.lastDirect >= SILENT_MS) this.directFailed(now, "The direct pictures stopped");
    }

    // what was said about the way stays; of a silent camera's way nothing is known, and nothing was said
    #waitQuietly(now) {
      const { hasGivenUp, why } = this;
      this.directFailed(now, "");
      Object.assign(this, { hasGivenUp, why });
    }

    #lookServer(now) {
      if (this.server === "jpeg" && this.poorSince !== null && now - this.poorSince >= POOR_FOR_MS) {
        Object.assign(this, { server: "still", poorSince: null, betterAt: later(now, this.drops) });
        this.drops += 1;
      } else if (this.server === "still" && now >= this.betterAt) Object.assign(this, { server: "jpeg", poorSince: null, betterAt: Infinity });
    }
  }

  HL.camera = { Ways };
})();
