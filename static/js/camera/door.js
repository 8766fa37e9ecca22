// The way to a robot's cameras on Operate. Small, for it is there whether or not anybody opens a picture; what draws
// pictures is loaded when somebody does.
(() => {
  "use strict";
  const { el, icon, attr, LiveElement, define } = HL;
  const AGAIN_MS = 10000;
  const NONE_MS = 30000; // a robot that was just switched on says later what it has
  const KEY = "headland.pip";
  const door = { cameras: [], choice: { isOpen: false, isBig: false, corners: {}, camera: {}, ...HL.keep.read(KEY, {}) } };

  function choose(change) {
    Object.assign(door.choice, change);
    HL.keep.write(KEY, door.choice);
    HL.repaint();
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
      this.pip?.remove();
      this.pip = null;
      door.cameras = [];
    }
    async load() {
      const { robot } = this;
      const answer = await HL.port.api("GET", `/cameras?robot=${encodeURIComponent(robot)}`);
      if (!this.isConnected || this.robot !== robot) return;
      if (answer.ok) this.has(answer.cameras ?? []);
      if (!door.cameras.length && answer.status !== 403) this.timer = setTimeout(() => this.load(), answer.ok ? NONE_MS : AGAIN_MS);
    }
    has(cameras) {
      door.cameras = cameras;
      const seg = this.querySelector(".h-seg");
      if (cameras.length && this.camera.parentElement !== seg) seg.replaceChildren(this.map, this.camera, this.small);
      this.open();
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
