// The way to a robot's cameras on Operate. Small, for it is there whether or not anybody opens a picture; what draws
// pictures is loaded when somebody does.
(() => {
  "use strict";
  const { el, icon, attr, LiveElement, define } = HL;
  const AGAIN_MS = 10000;
  const STARTS_MS = 2000; // the camera process comes up after the console
  const NONE_MS = 30000; // a robot that was just switched on says later what it has
  const FETCH_MS = 1000; // after the values are there: what the first tap needs comes beside, not before them
  const KEY = "headland.pip";
  const door = { cameras: [], choice: { isOpen: false, isBig: false, corners: {}, camera: {}, ...HL.keep.read(KEY, {}) } };

  function choose(change) {
    Object.assign(door.choice, change);
    HL.keep.write(KEY, door.choice);
    HL.repaint();
  }

  const fetched = new Set();
  function fetchAhead(address, kind) {
    if (fetched.has(address)) return;
    fetched.add(address);
    document.head.append(el("link", { rel: "prefetch", as: kind, href: address }));
  }

  class Door extends LiveElement {
    build() {
      this.map = el("button", { type: "button", "data-testid": "view-map", onclick: () => choose({ isBig: false }) }, icon("map", "m"), "Map");
      this.camera = el("button", { type: "button", "data-testid": "view-camera", onclick: () => choose({ isOpen: true, isBig: true }) }, icon("videocam", "m"), "Camera");
      this.small = el("button", { type: "button", class: "c-small", "data-testid": "pip-toggle", onclick: () => choose(door.choice.isOpen && !door.choice.isBig ? { isOpen: false } : { isOpen: true, isBig: false }) }, icon("picture_in_picture_alt", "m"));
    }
    enter() {
      this.robot = HL.view.robot;
      this.load();
    }
    leave() {
      clearTimeout(this.timer);
      clearTimeout(this.ahead);
      this.pip?.remove();
      this.pip = null;
      door.cameras = [];
    }
    async load() {
      const { robot } = this;
      const answer = await HL.port.api("GET", `/cameras?robot=${encodeURIComponent(robot)}`);
      if (!this.isConnected || this.robot !== robot) return;
      const isStarting = answer.code === "cameras_down";
      this.note ??= this.appendChild(el("span", { class: "h-t14 h-2 c-wait", role: "status", "data-testid": "cameras-starting" }, "Cameras are starting"));
      attr(this.note, "hidden", !isStarting);
      if (answer.ok) this.has(answer.cameras ?? []);
      if (!door.cameras.length && answer.status !== 403) this.timer = setTimeout(() => this.load(), answer.ok ? NONE_MS : isStarting ? STARTS_MS : AGAIN_MS);
    }
    has(cameras) {
      door.cameras = cameras;
      const seg = this.querySelector(".h-seg");
      if (cameras.length && this.camera.parentElement !== seg) seg.replaceChildren(this.map, this.camera, this.small);
      this.open();
      if (cameras.length) this.getReady();
    }
    async getReady() {
      await HL.port.firstPicture();
      this.ahead = setTimeout(() => {
        for (const address of this.dataset.camera.split(" ")) fetchAhead(address, "script");
        for (const address of (document.querySelector("[data-screen-style]")?.dataset.screenStyle ?? "").split(" ").filter(Boolean)) fetchAhead(address, "style");
      }, FETCH_MS);
    }
    // the picture comes with its own script and style
    open() {
      if (!door.cameras.length || !door.choice.isOpen || this.pip) return;
      for (const src of this.dataset.camera.split(" ")) HL.load(src);
      this.pip = el("hl-pip", { class: "c-pip", "data-testid": "pip", hidden: true });
      this.closest(".h-map").append(this.pip);
    }
    paint() {
      const { isOpen, isBig } = door.choice;
      if (isOpen) this.open();
      else if (this.pip) {
        this.pip.remove();
        this.pip = null;
      }
      attr(this.map, "aria-pressed", String(!isOpen || !isBig));
      attr(this.camera, "aria-pressed", String(isOpen && isBig));
      attr(this.small, "aria-pressed", null);
      attr(this.small, "aria-label", isOpen && !isBig ? "Close the small picture" : "Open a small picture");
      attr(this.small, "title", isOpen && !isBig ? "Close the small picture" : "Open a small picture");
      attr(this.small, "data-state", isOpen && !isBig ? "open" : "closed");
    }
  }

  HL.pip = Object.assign(door, { choose });
  define("hl-camera-door", Door);
})();
