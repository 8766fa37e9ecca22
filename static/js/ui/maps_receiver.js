// Who tells positions for a walk: a robot over the live lane, or this tablet's own receiver.
(() => {
  "use strict";
  const TABLET = "tablet";
  const STALE_MS = 2000; // of a robot
  const TABLET_STALE_MS = 5000; // receivers of tablets tell once a second, and pause
  const SIGMA = 2; // a browser tells the radius that holds 95 % of the time, two standard deviations
  const WHY = {
    1: "This tablet may not tell its position. Allow it in the browser's settings for this page.",
    2: "This tablet has no position now. Go outside, under open sky.",
    3: "This tablet has no position yet. Wait a moment under open sky.",
  };

  const why = () => {
    if (!window.isSecureContext) return "The tablet's own position needs a secure address (https). This page came by plain http. Lead a robot, or ask for https.";
    return navigator.geolocation ? "" : "This browser tells no position.";
  };

  class TabletReceiver {
    constructor() {
      this.pose = null;
      this.problem = why();
    }

    start() {
      this.stop();
      this.problem = why();
      if (this.problem) return;
      this.problem = "Waiting for this tablet's position.";
      this.watch = navigator.geolocation.watchPosition((found) => this.heard(found), (error) => this.failed(error), { enableHighAccuracy: true, maximumAge: 0, timeout: 20000 });
    }

    heard({ coords, timestamp }) {
      this.problem = "";
      this.at = performance.now();
      this.pose = { lon: coords.longitude, lat: coords.latitude, accuracy_m: coords.accuracy / SIGMA, at_s: timestamp / 1000 };
    }

    failed(error) {
      this.problem = WHY[error.code] ?? "This tablet gives no position.";
    }

    get isFresh() {
      return Boolean(this.pose) && performance.now() - this.at < TABLET_STALE_MS;
    }

    stop() {
      if (this.watch !== undefined) navigator.geolocation?.clearWatch(this.watch);
      this.watch = undefined;
      this.pose = null;
    }
  }

  class RobotReceiver {
    constructor(id) {
      this.id = id;
      this.problem = "";
    }

    start() {
      HL.port.follow(this.id, "walk");
    }

    get pose() {
      const pose = HL.port.robot(this.id).pose;
      return pose && { lon: pose.lon, lat: pose.lat, accuracy_m: pose.accuracy_m, at_s: pose.t / 1000 };
    }

    get isFresh() {
      const pose = HL.port.robot(this.id).pose;
      return Boolean(pose) && HL.port.age(pose.t) < STALE_MS && HL.linkState() !== "server-lost";
    }

    stop() {
      HL.port.follow(null, "walk");
    }
  }

  // where this tablet is, once and roughly: {place: [lon, lat]} or {problem}
  function tabletPlace() {
    const problem = why();
    if (problem) return Promise.resolve({ problem });
    const ask = (found, failed) => navigator.geolocation.getCurrentPosition(found, failed, { maximumAge: 60000, timeout: 20000 });
    return new Promise((done) => ask(({ coords }) => done({ place: [coords.longitude, coords.latitude] }), (error) => done({ problem: WHY[error.code] ?? "This tablet gives no position." })));
  }

  Object.assign(HL.maps, { TABLET, tabletPlace, TabletReceiver, RobotReceiver, tabletWhy: why });
})();
