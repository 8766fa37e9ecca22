// One picture on a screen: by the best way there is, as old as it says, let go of when nobody can see it.
(() => {
  "use strict";
  const { el, toggle } = HL;
  const LOOK_MS = 100; // a stall is seen within 1.2 s
  const WIDTHS = [320, 640, 1280];

  const pageM = () => window.headland.now();

  class Viewer {
    // told (optional): {judged(viewer)} after each look
    constructor({ robot, camera, label = camera, fps = 15, hasDirect = true, told = {} }) {
      Object.assign(this, { robot, camera, label, fps, told, n: null, direct: null, info: null, problem: "", judged: null, how: null, isOpen: false, isSeen: false });
      this.hasDirect = hasDirect;
      this.canvas = el("canvas", { class: "c-jpeg" });
      this.video = el("video", { class: "c-video", autoplay: true, muted: true, playsinline: true, disablepictureinpicture: true, tabindex: "-1" });
      this.video.muted = true; // the attribute alone does not silence a node that a script made
      this.mark = HL.config.watermark ? el("span", { class: "c-mark", "aria-hidden": "true" }) : "";
      this.node = el("div", { class: "c-view", "data-state": "connecting" }, this.canvas, this.video, this.mark);
      this.hidden = () => this.#follow();
    }

    open() {
      if (this.isOpen) return;
      this.isOpen = true;
      this.sight = new HL.camera.Sight(performance.now());
      this.seen = new IntersectionObserver((entries) => ((this.isSeen = entries.at(-1).intersectionRatio > 0), this.#follow()), { threshold: [0, 0.01] }); // touching the edge is not seen
      this.seen.observe(this.node);
      document.addEventListener("visibilitychange", this.hidden);
      this.#follow();
    }

    close() {
      if (!this.isOpen) return;
      this.isOpen = false;
      this.seen.disconnect();
      document.removeEventListener("visibilitychange", this.hidden);
      this.#stop();
    }

    // the person or a restart asks for it from the beginning
    again() {
      if (this.n === null) return;
      HL.camera.socket.again(this.n);
      this.ways.again(performance.now());
      this.problem = "";
    }

    // how it is wanted from now on; a running stream begins anew only for another way
    want({ hasDirect, fps }) {
      this.fps = fps;
      if (hasDirect === this.hasDirect) return;
      this.hasDirect = hasDirect;
      if (this.n === null) return;
      this.#stop();
      this.#follow();
    }

    isRunning() {
      return this.n !== null;
    }

    #follow() {
      const isWanted = this.isOpen && this.isSeen && !document.hidden;
      if (isWanted && this.n === null) this.#start();
      else if (!isWanted && this.n !== null) this.#stop();
    }

    #start() {
      const lack = this.hasDirect ? HL.camera.lacking() : "";
      const now = performance.now();
      this.ways = new HL.camera.Ways(now, { hasDirect: this.hasDirect && !lack, why: lack });
      this.sight.again(now);
      this.times = new HL.camera.Times();
      Object.assign(this, { retry: new HL.camera.Again(), problem: "", info: null, isDown: true });
      const on = { frame: (one) => this.#frame(one), times: (list) => this.#told(list), state: (info) => this.#state(info), refused: (text) => (this.problem = text), up: () => this.#up(), down: () => this.#down() };
      this.n = HL.camera.socket.watch({ robot: this.robot, camera: this.camera, way: "jpeg", width: this.#width(), fps: this.fps, on });
      if (this.n === null) this.problem = "This page watches as many cameras as it may.";
      else if (HL.camera.socket.watcher()) this.#up();
      this.timer = setInterval(() => this.look(), LOOK_MS);
      this.look();
    }

    #stop() {
      clearInterval(this.timer);
      if (this.n !== null) HL.camera.socket.drop(this.n);
      this.n = null;
      this.#closeDirect();
      this.node.dataset.way = "";
    }

    // whole steps, so that few sizes are made of one camera
    #width() {
      const px = (this.node.clientWidth || 400) * Math.min(2, devicePixelRatio || 1);
      return WIDTHS.find((one) => one >= px * 0.8) ?? WIDTHS.at(-1);
    }

    #up() {
      this.isDown = false;
      this.problem = "";
      this.ways.again(performance.now());
      this.look();
    }

    #down() {
      this.isDown = true;
      if (this.direct) this.#closeDirect();
      this.ways.directFailed(performance.now(), "");
    }

    #state(info) {
      const isBack = this.info && ["failed", "off", "frozen"].includes(this.info.state) && ["live", "starting"].includes(info.state);
      this.info = info;
      this.problem = "";
      if (isBack) this.ways.again(performance.now());
    }

    #openDirect() {
      const told = { picture: (rtp) => this.#directPicture(rtp), failed: (why) => (this.#closeDirect(), this.ways.directFailed(performance.now(), why)) };
      this.direct = new HL.camera.Direct({ robot: this.robot, camera: this.camera, watcher: HL.camera.socket.watcher(), video: this.video, told });
    }

    // the last picture stays, as old as it is
    #closeDirect() {
      const { direct, video } = this;
      this.direct = null;
      if (direct && this.shown === "direct" && video.videoWidth) {
        Object.assign(this.canvas, { width: video.videoWidth, height: video.videoHeight });
        this.canvas.getContext("2d", { alpha: false }).drawImage(video, 0, 0);
        this.#show("server", video.videoWidth, video.videoHeight);
      }
      direct?.close();
    }

    #directPicture(rtp) {
      const now = performance.now();
      if (rtp !== null && rtp === this.lastRtp) return; // shown again, not new
      this.lastRtp = rtp;
      const at = { now, m: pageM(), isCounted: !this.sight.isSilent(now, this.info?.period_s) };
      this.ways.directPicture(now);
      const captured = rtp === null ? null : this.times.shown(rtp, at);
      if (rtp === null || captured !== null || at.isCounted) this.#seen(captured, at);
      this.#show("direct", this.video.videoWidth, this.video.videoHeight);
    }

    #told(list) {
      this.ways.cameraPicture(performance.now());
      for (const { captured, at } of this.times.told(list)) {
        if (at.isCounted) this.sight.dated(captured, at.m, at.now);
        else this.#seen(captured, at);
      }
    }

    #seen(captured, { now, m }) {
      this.sight.picture(now, captured, m, this.info?.is_dated ?? true);
    }

    // one is decoded at a time; of those that come meanwhile only the newest is kept
    #frame(one) {
      const m = pageM();
      const isNoSign = m === null || HL.camera.isSlow(this.info?.period_s); // an old picture of a slow camera is no sign of a poor line
      this.ways.serverPicture(performance.now(), isNoSign ? null : m - one.captured, one.seq);
      this.next = one;
      if (!this.isDecoding) this.#decode();
    }

    async #decode() {
      this.isDecoding = true;
      while (this.next) {
        const one = this.next;
        this.next = null;
        try {
          this.#draw(one, await createImageBitmap(new Blob([one.jpeg], { type: "image/jpeg" })));
        } catch {
          // a broken picture is no picture: the one before grows old and says so
        }
        HL.camera.socket.seen(this.n, one.seq);
      }
      this.isDecoding = false;
    }

    #draw(one, bitmap) {
      const isLate = this.n === null || this.ways.look(performance.now()).shown !== "server";
      if (!isLate) {
        if (this.canvas.width !== bitmap.width) this.canvas.width = bitmap.width;
        if (this.canvas.height !== bitmap.height) this.canvas.height = bitmap.height;
        this.canvas.getContext("2d", { alpha: false }).drawImage(bitmap, 0, 0);
        if (one.seq !== this.lastSeq) this.sight.picture(performance.now(), one.captured, pageM(), one.isDated);
        this.lastSeq = one.seq;
        this.#show("server", bitmap.width, bitmap.height);
      }
      bitmap.close();
    }

    #show(shown, width, height) {
      Object.assign(this, { width, height });
      if (this.shown !== shown) toggle(this.node, "direct", shown === "direct");
      this.shown = shown;
      if (this.judged?.state !== "live" && this.n !== null) this.look(); // somebody waits for it
    }

    // judges, and follows what was judged; called ten times a second while somebody sees it
    look() {
      const now = performance.now();
      const how = this.ways.look(now);
      if (how.direct && !this.direct && !this.isDown && HL.camera.socket.watcher()) this.#openDirect();
      if (!how.direct && this.direct) this.#closeDirect();
      HL.camera.socket.change(this.n, { way: how.way, width: this.#width(), fps: this.fps });
      this.how = { ...how, way: how.shown === "direct" ? "direct" : how.way };
      this.judged = this.sight.judge(now, pageM(), this.info);
      if (this.problem && this.judged.state === "connecting") this.judged.state = "off"; // refused: waiting would change nothing
      if (this.retry.isDue(now, this.judged.state)) this.again();
      this.#tell();
    }

    #tell() {
      const { judged, how, node } = this;
      HL.attr(node, "data-state", judged.state);
      HL.attr(node, "data-way", how.way);
      if (this.mark) HL.text(this.mark, `${HL.config.user?.name ?? ""}  ${new Date().toISOString().slice(0, 16).replace("T", " ")} UTC`);
      if (judged.state !== this.toldState) HL.repaint(); // words follow at once
      this.toldState = judged.state;
      this.told.judged?.(this);
    }

    // camera to screen at this moment, for whoever steers by it: Infinity without a picture, null while nobody looks
    ageMs() {
      if (!this.isOpen || !this.sight) return null;
      if (this.n === null || !this.sight.last || this.sight.captured === null) return Infinity;
      const judged = this.sight.judge(performance.now(), pageM(), this.info, this.how?.way);
      return judged.state === "frozen" || judged.state === "off" ? Infinity : judged.ageMs;
    }
  }

  Object.assign(HL.camera, { Viewer });
})();
