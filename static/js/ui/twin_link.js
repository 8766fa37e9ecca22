// The page's ends of the twin: the frame with the picture, and a socket for wishes and ages. Both may come back at any time.
(() => {
  "use strict";
  const BACKOFF_MS = [200, 400, 800, 1200];
  const STALE_S = 2;
  const PICTURE_STALE_MS = 2500; // the media process moves something once a second
  const PATIENCE_MS = 15000; // viser's client and a first scene on a slow tablet
  const LOST_MS = 1500; // graphics that a device took away and does not give back by itself
  const AWAY_MS = 5000; // this long without the media process, and the map is shown
  const TOLD_MS = 3000; // told twice a second; what was said before that may have changed
  const MOST_WAITING = 65536; // bytes the line has not taken yet

  class TwinLink {
    constructor(robot, frame) {
      Object.assign(this, { robot, frame, key: window.headland.uuid(), status: null, statusAt: 0, isTold: false, wishes: new Map(), untold: new Set(), attempt: 0 });
      this.awayAt = performance.now();
      this.handlers = {};
      this.onMessage = (event) => event.source === this.frame.contentWindow && event.origin === location.origin && event.data?.from === "headland-twin" && this.fromFrame(event.data);
      addEventListener("message", this.onMessage);
      this.load();
      this.connect();
    }

    // the picture from its beginning
    load() {
      this.picture = { isConnected: false, ageMs: null, at: performance.now(), frames: 0, hasModel: false, hasWebgl: true, wasConnected: false, isLost: false };
      this.bornAt = performance.now();
      this.frame.src = `/viser/?viewer=${this.key}&robot=${encodeURIComponent(this.robot)}`;
    }

    lose() {
      this.picture.isLost = true;
      setTimeout(() => !this.isClosed && this.picture.isLost && this.load(), LOST_MS);
    }

    on(kind, handler) {
      this.handlers[kind] = handler;
    }

    // wishes are told again when the socket comes back, and until it takes them; `slot` names what replaces what
    wish(slot, message) {
      this.wishes.set(slot, message);
      this.tell(slot);
    }

    tell(slot) {
      if (this.send(this.wishes.get(slot))) this.untold.delete(slot);
      else this.untold.add(slot);
    }

    // whether the socket took it
    send(message) {
      if (this.socket?.readyState !== 1 || this.socket.bufferedAmount >= MOST_WAITING) return false;
      this.socket.send(JSON.stringify(message));
      return true;
    }

    connect() {
      if (this.isClosed) return;
      const scheme = location.protocol === "https:" ? "wss:" : "ws:";
      const socket = (this.socket = new WebSocket(`${scheme}//${location.host}/viser/control?viewer=${this.key}&robot=${encodeURIComponent(this.robot)}`));
      socket.onmessage = (event) => {
        const said = JSON.parse(event.data);
        if (said.k === "status") {
          Object.assign(this, { status: said, statusAt: performance.now(), isTold: true, attempt: 0 });
          this.awayAt = null;
          this.untold.forEach((slot) => this.tell(slot));
        }
        this.handlers[said.k]?.(said);
        HL.repaint();
      };
      socket.onopen = () => this.wishes.forEach((_message, slot) => this.tell(slot));
      socket.onclose = () => {
        if (socket !== this.socket || this.isClosed) return;
        this.awayAt ??= performance.now();
        this.isTold = false;
        setTimeout(() => this.connect(), BACKOFF_MS[Math.min(this.attempt++, BACKOFF_MS.length - 1)]);
        HL.repaint();
      };
    }

    fromFrame(said) {
      if (said.kind === "beat") {
        Object.assign(this.picture, { isConnected: said.isConnected, ageMs: said.ageMs, frames: said.frames, hasModel: said.hasModel, at: performance.now() });
        this.picture.wasConnected ||= said.isConnected;
      } else if (said.kind === "no-webgl") this.picture.hasWebgl = false;
      else if (said.kind === "lost") this.lose();
      else if (said.kind === "restored") this.picture.isLost = false;
      else if (said.kind === "hold") this.send({ k: "hold", on: said.isOn });
      this.handlers[said.kind]?.(said);
      HL.repaint();
    }

    close() {
      this.isClosed = true;
      removeEventListener("message", this.onMessage);
      this.socket?.close();
      this.frame.removeAttribute("src");
    }

    // seconds since the shown pose was true; null before the first
    poseAge() {
      const said = this.status?.pose_age_s;
      if (said === null || said === undefined) return null;
      return said + (performance.now() - this.statusAt) / 1000;
    }

    ageOf(layer) {
      const said = this.status?.ages_s?.[layer];
      return said === null || said === undefined ? null : said + (performance.now() - this.statusAt) / 1000;
    }

    // why the pose has no age: a joint that was not heard is drawn at rest
    unheard() {
      const { unheard = [], joints = [] } = this.status ?? {};
      if (!unheard.length) return "";
      return unheard.length < joints.length ? `Joint ${unheard[0]} not heard` : "Joints not heard";
    }

    isPoseFresh() {
      const age = this.poseAge();
      return age !== null && age <= STALE_S;
    }

    // whether the picture shows the record, as who draws it says: a wish is not yet a picture
    isPast() {
      return this.isTold && performance.now() - this.statusAt < TOLD_MS && Boolean(this.status.is_past);
    }

    pictureAgeMs() {
      return this.picture.ageMs === null ? null : this.picture.ageMs + performance.now() - this.picture.at;
    }

    // {state: connecting|live|stale|unavailable, text}; where the record is shown the pose of now does not count, the picture does
    judge(isPast = this.isPast()) {
      const now = performance.now();
      if (!this.picture.hasWebgl) return { state: "unavailable", text: "3D is not available here. Showing the map." };
      if (this.picture.isLost) return { state: "connecting", text: "This device took the graphics away. Loading the picture again" };
      if (this.awayAt !== null && now - this.awayAt > AWAY_MS) return { state: "unavailable", text: "3D is not available now. Showing the map until it is back." };
      if (HL.port.robot(this.robot).id?.is_registered === false) return { state: "unavailable", text: "New robot. An admin must accept it first." };
      if (!this.picture.wasConnected || !this.status?.is_drawn || !this.picture.hasModel) {
        const isLate = now - this.bornAt > PATIENCE_MS;
        if (this.status && !this.status.is_drawn && isLate) return { state: "unavailable", text: "The robot has not said where it is. Showing the map." };
        return isLate && !this.picture.wasConnected ? { state: "unavailable", text: "3D did not load. Showing the map." } : { state: "connecting", text: "Loading model" };
      }
      const pose = this.poseAge();
      if (!isPast && pose === null) return { state: "stale", text: this.unheard() || "The age of this pose is not known" };
      if (!isPast && pose > STALE_S) return { state: "stale", text: `Pose is ${HL.words.age(pose * 1000)} old` };
      const picture = this.pictureAgeMs();
      if (!this.picture.isConnected || picture === null || picture > PICTURE_STALE_MS) return { state: "stale", text: `Picture is ${HL.words.age(picture ?? 0)} old` };
      return { state: "live", text: "" };
    }
  }

  HL.TwinLink = TwinLink;
})();
