// What a camera can be told: pan and tilt while a pad is held, zoom, lamp, trigger; each only where the factsheet says so.
(() => {
  "use strict";
  const { el, icon, attr, text } = HL;
  const STEP = 1.5; // of the zoom
  const TAKEN_MS = 1100; // what is kept is a second old at most

  const mine = (robot) => HL.lease.isMine(robot);
  const PADS = [["pan", 1, "turn_left", "left"], ["pan", -1, "turn_right", "right"], ["tilt", 1, "keyboard_arrow_up", "up"], ["tilt", -1, "keyboard_arrow_down", "down"]];

  class Gimbal {
    // one: the camera of the list
    constructor(one) {
      this.one = one;
      this.zoom = one.ptz?.zoom?.[0] ?? null;
      this.node = el("div", { class: "c-gimbal" });
      this.acts = [];
      const ptz = one.ptz ?? {};
      if (ptz.pan || ptz.tilt) this.node.append(this.moves(ptz));
      if (ptz.zoom) this.acts.push(this.act("remove", "Zoom out", "zoom-out", () => this.zoomBy(1 / STEP)), this.act("add", "Zoom in", "zoom-in", () => this.zoomBy(STEP)));
      if (one.has_lamp) this.acts.push((this.lamp = this.act("flashlight_on", "Lamp", "lamp", () => this.light())));
      if (one.has_trigger) this.acts.push(this.trigger());
      this.node.append(...this.acts);
      if (ptz.zoom || one.has_lamp) this.learn();
    }

    // how the robot says it is set: another person, or this one before, may have zoomed or lit
    async learn() {
      const { robot, camera } = this.one;
      const told = await HL.port.api("GET", `/cameras/${encodeURIComponent(robot)}/${encodeURIComponent(camera)}/control`);
      if (!told.ok) return;
      if (told.zoom !== null) this.zoom = told.zoom;
      if (this.lamp) attr(this.lamp, "aria-pressed", told.lamp === null ? null : String(told.lamp));
    }

    moves(ptz) {
      this.pads = PADS.filter(([axis]) => ptz[axis]).map(([axis, way, sign, word]) => ({ joint: ptz[axis], way, label: `Camera ${word}`, node: HL.jog.pad(ptz[axis], way, { sign, look: "c-movepad", hook: `camera-move-${word}` }) }));
      this.take = el("button", { type: "button", class: "h-btn", "aria-label": "Move camera", title: "Move camera", "data-testid": "camera-move", onclick: () => this.begin() }, icon("open_with"), el("span", { class: "c-word" }, "Move camera"));
      this.end = el("button", { type: "button", class: "h-btn", "data-testid": "camera-move-end", onclick: () => HL.jog.end() }, "End");
      return el("div", { class: "c-moves", role: "group", "aria-label": "Hold to move the camera" }, this.take, ...this.pads.map((pad) => pad.node), this.end);
    }

    trigger() {
      const node = this.act("photo_camera", "Trigger the camera", "trigger", () => this.control({ trigger: true }));
      node.className = "h-btn";
      node.replaceChildren("Trigger");
      return node;
    }

    act(sign, label, hook, act) {
      return el("button", { type: "button", class: "h-btn ico", "aria-label": label, title: label, "data-testid": `camera-${hook}`, onclick: () => (this.off() ? HL.toast(this.off(), "lock") : act()) }, icon(sign));
    }

    // why it takes no orders; the server asks the same again
    off() {
      const { robot } = this.one;
      if (!mine(robot)) return "Take control of the robot first.";
      return HL.port.robot(robot).actions?.camera?.reason ?? "";
    }

    async begin() {
      const { robot } = this.one;
      const why = this.refusal();
      if (why) return HL.toast(why, "lock");
      if (HL.drive.robot === robot) return HL.jog.attach(robot);
      const reply = await HL.jog.open(robot);
      return reply.outcome === "accepted" || HL.toast(`${HL.outcomeWords(reply.outcome)}: ${reply.text}`, "block");
    }

    refusal() {
      const { robot } = this.one;
      if (!HL.config.rights.includes("drive")) return "Moving the camera needs the operator role.";
      const off = HL.offline(robot);
      if (off) return off;
      if (HL.stops.worst(robot)) return "Stopped. Reset the stop first.";
      const verdict = HL.port.robot(robot).actions?.jog;
      if (HL.drive.robot !== robot && verdict && !verdict.ok) return verdict.reason;
      return HL.lease.obstacle(robot);
    }

    async zoomBy(factor) {
      await this.learn();
      const [least, most] = this.one.ptz.zoom;
      const wished = Math.min(most, Math.max(least, (this.zoom ?? least) * factor));
      return this.control({ zoom: Math.round(wished * 10) / 10 });
    }

    async light() {
      await this.learn();
      return this.control({ lamp: this.lamp.getAttribute("aria-pressed") !== "true" });
    }

    async control(wish) {
      const { robot, camera } = this.one;
      const answer = await HL.port.api("POST", `/cameras/${encodeURIComponent(robot)}/${encodeURIComponent(camera)}/control`, wish);
      if (!answer.ok) return HL.toast(`Not done: ${answer.text}`, "block");
      if ("lamp" in wish) attr(this.lamp, "aria-pressed", String(wish.lamp));
      if (wish.trigger) await this.keepTriggered();
      if (wish.zoom) this.zoom = wish.zoom;
      if (wish.zoom) HL.toast(`Zoom ${wish.zoom.toFixed(1)} ×`, "videocam");
      return answer;
    }

    // what it took is kept where people look for it; a picture from before the trigger is too old by then
    async keepTriggered() {
      const { robot, camera, label } = this.one;
      HL.toast("Triggered.", "photo_camera");
      await new Promise((done) => setTimeout(done, TAKEN_MS));
      await HL.camera.snapshot.keep(robot, camera, label);
    }

    paint() {
      const off = this.off();
      for (const node of this.acts) attr(node, "aria-disabled", off ? "true" : null);
      if (!this.pads) return;
      const isMoving = HL.jog.isMine() && HL.jog.check();
      attr(this.take, "hidden", isMoving);
      attr(this.take, "aria-disabled", this.refusal() ? "true" : null);
      attr(this.end, "hidden", !isMoving);
      text(this.end, HL.jog.blockedBy ? `Off: ${HL.jog.blockedBy}` : "End");
      for (const { node, joint, way, label } of this.pads) {
        attr(node, "hidden", !isMoving);
        HL.jog.showPad(node, joint, way, label);
      }
    }

    close() {
      HL.jog.letGo();
    }
  }

  Object.assign(HL.camera, { Gimbal });
})();
