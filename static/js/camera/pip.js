// The picture on Operate: small in a corner of the map, or large with the map in the corner. It stays inside the map's
// part of the screen, so that STOP, dock and banners are never under it.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, style, LiveElement } = HL;
  const GAP = 16;
  const BESIDE_BUTTONS = 88; // the map's own buttons stand at its right edge
  const DRAG_PX = 8;
  const SHARE = 0.46; // of the map's width at most
  const SHARE_OF_MAP = 0.33; // that the map takes of a big picture
  const WIDTH = 312;
  const HEAD = 48; // the small picture stands below its head

  const sizeName = () => (innerWidth < 900 ? "portrait" : innerWidth < 1600 ? "landscape" : "desk");

  class Pip extends LiveElement {
    build() {
      this.choice = el("select", { class: "c-choice", "aria-label": "Camera", "data-testid": "pip-camera", onchange: () => this.show(this.choice.value) });
      this.corner = el("span", { class: "end" });
      this.shut = el("button", { type: "button", class: "c-close", "aria-label": "Close the picture", "data-testid": "pip-close", onclick: () => HL.pip.choose({ isOpen: false, isBig: false }) }, icon("close"));
      this.head = el("div", { class: "c-piphead" }, icon("videocam", "m"), this.choice, this.corner, this.shut);
      this.stage = el("div", { class: "c-stage" });
      this.swap = el("button", { type: "button", class: "c-swap", "aria-label": "Swap map and picture", "data-testid": "pip-swap", onclick: () => this.isDragged || HL.pip.choose({ isBig: !HL.pip.choice.isBig }) });
      this.boxes = el("button", { type: "button", class: "h-btn", "data-testid": "pip-boxes", onclick: () => HL.pip.choose({ hasBoxes: !this.hasBoxes() }) }, "Detections");
      this.line = el("span", { class: "c-line", role: "status" });
      this.tools = el("div", { class: "c-tools" }, this.line, this.boxes, HL.camera.snapshot.button(() => this.one && { ...this.one, label: `${HL.view.name()} ${this.one.label}` }, "pip-snapshot"));
      this.note = el("span", { class: "c-note" });
      this.mapHead = el("div", { class: "c-maphead" }, icon("map", "m"), "Map", el("span", { class: "end" }, "tap to swap"));
      this.append(this.stage, this.note, this.swap, this.head, this.mapHead, this.tools);
      this.head.addEventListener("pointerdown", (event) => this.drag(event));
    }

    hasBoxes() {
      return HL.pip.choice.hasBoxes ?? true;
    }

    enter() {
      this.map = this.closest(".h-map");
      this.robot = HL.view.robot;
      HL.looksInside = true; // joints and detections
      HL.port.watch();
      const known = HL.pip.cameras;
      const choice = known.find((one) => one.camera === HL.pip.choice.camera?.[this.robot]) ?? known.find((one) => one.view === "front") ?? known[0];
      this.choice.replaceChildren(...known.map((one) => el("option", { value: one.camera }, one.label || one.camera)));
      HL.picture = { ageMs: (robot) => this.ageMs(robot), why: (limit) => this.why(limit), slow: () => this.slow(), advice: () => "The picture is too old to drive by. Close it to drive by sight." };
      this.show(choice.camera);
      attr(this, "hidden", null);
    }

    leave() {
      HL.picture = null;
      HL.looksInside = false;
      HL.port.watch();
      this.empty();
      for (const name of ["c-swapped", "c-hasmini"]) this.map.classList.remove(name);
    }

    empty() {
      this.gimbal?.close();
      this.gimbal?.node.remove();
      this.viewer?.close();
      this.stage.replaceChildren();
    }

    show(camera) {
      this.empty();
      this.one = HL.pip.cameras.find((one) => one.camera === camera);
      this.choice.value = camera;
      HL.pip.choose({ camera: { ...HL.pip.choice.camera, [this.robot]: camera } });
      this.viewer = new HL.camera.Viewer({ robot: this.robot, camera, label: this.one.label, told: { judged: () => this.paint() } });
      this.found = new HL.camera.Detections(this.viewer);
      this.none = new HL.camera.NoPicture(this.viewer);
      this.gimbal = new HL.camera.Gimbal(this.one);
      this.stage.append(this.viewer.node, this.found.node, this.none.node);
      this.tools.append(this.gimbal.node);
      this.place(); // a picture without a size would never come into sight
      this.viewer.open();
    }

    // by which a person steers: null where this robot's picture is not open
    ageMs(robot) {
      if (robot !== this.robot || !this.isConnected || !this.viewer) return null;
      const ageMs = this.viewer.ageMs();
      return this.viewer.sight?.isDated === false ? Math.max(ageMs, 501) : ageMs; // how old it really is nobody knows
    }
    why(limitMs) {
      const ageMs = this.viewer.sight?.captured === null ? null : this.viewer.judged?.ageMs;
      return ageMs === null || ageMs === undefined || ageMs < limitMs ? "No picture" : `Picture ${HL.words.since(ageMs) === "0 s" ? "old" : `${HL.words.age(ageMs)} old`}`;
    }
    slow() {
      return this.viewer.sight?.isDated === false ? "This camera tells no time: Creep only. Close it to drive by sight." : `The picture is ${HL.words.age(this.viewer.ageMs())} old: Creep only.`;
    }

    // to the corner where it is dropped
    drag(event) {
      if (event.target.closest("select, button") || HL.pip.choice.isBig || event.button > 0) return;
      const from = { x: event.clientX, y: event.clientY };
      const move = (now) => {
        const [dx, dy] = [now.clientX - from.x, now.clientY - from.y];
        this.isDragged ||= Math.hypot(dx, dy) > DRAG_PX;
        if (this.isDragged) this.style.translate = `${dx}px ${dy}px`;
      };
      const done = () => {
        this.head.removeEventListener("pointermove", move);
        this.style.translate = "";
        if (!this.isDragged) return;
        const [mine, map] = [this.getBoundingClientRect(), this.map.getBoundingClientRect()];
        const last = this.lastBox ?? mine;
        this.put(`${last.top + last.height / 2 < map.top + map.height / 2 ? "top" : "bottom"}-${last.left + last.width / 2 < map.left + map.width / 2 ? "left" : "right"}`);
        setTimeout(() => (this.isDragged = false));
      };
      const keep = () => (this.lastBox = this.getBoundingClientRect());
      this.head.setPointerCapture(event.pointerId);
      this.head.addEventListener("pointermove", move);
      this.head.addEventListener("pointermove", keep);
      for (const type of ["pointerup", "pointercancel"]) this.head.addEventListener(type, () => (this.head.removeEventListener("pointermove", keep), done()), { once: true });
    }
    put(corner) {
      HL.pip.choose({ corners: { ...HL.pip.choice.corners, [sizeName()]: corner } });
    }

    // the pads of driving stand at the bottom: then it is at the top
    place() {
      const { isBig, corners } = HL.pip.choice;
      const wished = corners?.[sizeName()] ?? (isBig ? "top-right" : "bottom-left");
      const corner = HL.drive.isMine() || isBig ? wished.replace("bottom", "top") : wished;
      const at = isBig && corner.endsWith("left") ? "top-right" : corner;
      const map = this.map.getBoundingClientRect();
      const width = Math.round(Math.min(WIDTH, map.width * (isBig ? SHARE_OF_MAP : SHARE)));
      const ratio = isBig ? 9 / 16 : (this.viewer.height || this.one.height_px || 9) / (this.viewer.width || this.one.width_px || 16);
      const height = Math.round(Math.min(width * Math.min(0.75, ratio) + (isBig ? 0 : HEAD), map.height * 0.6));
      const overlay = this.map.querySelector(".h-overlay")?.getBoundingClientRect();
      const below = at === "top-left" && overlay ? overlay.bottom - map.top + 8 : this.map.querySelector(":scope > hl-alarm-strip:not([hidden])") ? 58 + GAP : GAP;
      const box = { left: at.endsWith("left") ? GAP : Math.round(map.width - width - (isBig ? GAP : BESIDE_BUTTONS)), top: at.startsWith("top") ? Math.round(below) : Math.round(map.height - height - GAP), width, height };
      for (const [key, value] of Object.entries(box)) style(this.map, `--pip-${key}`, `${value}px`);
      if (isBig) style(this.map, "--pip-tools", `${this.tools.offsetHeight}px`); // they may need two rows
      attr(this, "data-corner", at);
    }

    paint() {
      if (!this.viewer?.judged || !this.isConnected) return;
      const { isBig } = HL.pip.choice;
      const { judged, how } = this.viewer;
      toggle(this, "big", isBig);
      toggle(this.map, "c-swapped", isBig);
      if (!isBig && HL.jog.isMine()) this.gimbal.close(); // its pads are out of sight
      this.place();
      this.none.paint();
      text(this.corner, HL.camera.says.corner({ ...judged, fps: null }, how)); // the rate has no room here
      text(this.note, HL.camera.says.note(judged, how));
      text(this.line, [HL.camera.says.sentence(this.one.label || this.one.camera, judged, how), isBig && this.gimbal.acts.length && this.gimbal.off()].filter(Boolean).join(". "));
      attr(this, "data-state", HL.camera.says.hook(judged, how));
      attr(this, "data-way", how.way);
      attr(this, "data-delay-ms", judged.delayMs === null ? null : Math.round(judged.delayMs));
      attr(this, "data-fps", judged.fps === null ? null : judged.fps.toFixed(1));
      const found = HL.port.inside(this.robot).detections ?? null;
      this.found.paint(found, this.hasBoxes());
      attr(this.boxes, "hidden", !this.found.of(found));
      attr(this.boxes, "aria-pressed", String(this.hasBoxes()));
      toggle(this.boxes, "on", this.hasBoxes());
      attr(this, "data-boxes", this.found.count);
      this.gimbal.paint();
    }
  }

  HL.superDefine("hl-pip", Pip);
})();
