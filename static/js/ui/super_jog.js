// All joints of a machine by hand, in one sheet; the rules are those of jog.js.
(() => {
  "use strict";
  const { el, text, attr, style, toggle, LiveElement, words, jog } = HL;

  class Jog extends LiveElement {
    build() {
      this.promise = el("p", { class: "h-2 h-t14" });
      this.steps = jog.STEPS.map(([key, label, share]) => el("button", { type: "button", "data-testid": `jog-speed-${key}`, onclick: () => ((jog.share = share), HL.repaint()) }, label));
      this.left = el("b");
      this.list = el("div", { class: "s-joints" });
      this.rows = new Map();
      this.append(this.promise, el("div", { class: "s-jogbar" }, el("div", { class: "h-seg", role: "group", "aria-label": "Speed" }, ...this.steps), el("span", { class: "h-t14 h-2" }, "Control ends in ", this.left)), this.list);
    }
    leave() {
      jog.letGo();
    }
    paint() {
      if (!jog.isMine() || !jog.check()) return;
      text(this.promise, jog.blockedBy ? `Off: ${jog.blockedBy}.` : `Hold a pad to move. Let go and it stops. ${HL.view.name()} stays where it is.`);
      attr(this, "data-state", jog.held.size ? "held" : jog.blockedBy ? "off" : "idle");
      this.steps.forEach((button, i) => attr(button, "aria-pressed", String(jog.STEPS[i][2] === jog.share)));
      text(this.left, words.clock(jog.endsInMs() / 1000));
      this.keep(jog.joints());
      const ageMs = HL.port.age(HL.port.inside(jog.robot).joints?.t);
      for (const one of jog.joints()) this.rows.get(one.name).paint(one, ageMs);
    }
    keep(list) {
      const names = list.map((one) => one.name).join();
      if (names === this.names) return;
      this.names = names;
      for (const one of list) if (!this.rows.has(one.name)) this.rows.set(one.name, this.row(one));
      this.list.replaceChildren(...list.map((one) => this.rows.get(one.name).node));
    }
    row({ name }) {
      const [minus, plus] = [jog.pad(name, -1, { sign: "remove" }), jog.pad(name, 1, { sign: "add" })];
      const label = el("b", { class: "h-t16" });
      const value = el("span", { class: "h-t18 h-b" });
      const soft = el("span", { class: "soft" });
      const pointer = el("span", { class: "ptr" });
      const node = el("div", { class: "s-joint", "data-testid": `jog-${name}` }, minus, el("div", { class: "mid" }, el("div", { class: "h-row" }, label, el("span", { class: "h-sp" }), value), el("div", { class: "s-jointbar", "aria-hidden": "true" }, soft, pointer)), plus);
      const paint = (joint, ageMs) => {
        const isOld = joint.value === null || joint.value === undefined || ageMs > HL.STALE_MS;
        text(label, joint.label);
        text(value, joint.value === null || joint.value === undefined ? "––" : isOld ? `${measure(joint, joint.value)}, ${words.age(ageMs)} old` : measure(joint, joint.value));
        toggle(node, "stale", isOld);
        attr(node, "data-level", isOld ? null : joint.level);
        const at = (x) => Math.min(100, Math.max(0, ((x - joint.lower) / (joint.upper - joint.lower)) * 100));
        style(soft, "left", `${at(joint.soft_lower ?? joint.lower)}%`);
        style(soft, "right", `${100 - at(joint.soft_upper ?? joint.upper)}%`);
        attr(pointer, "hidden", joint.value === null || joint.value === undefined);
        style(pointer, "left", `${at(joint.value ?? joint.lower)}%`);
        for (const [pad, way] of [[minus, -1], [plus, 1]]) {
          jog.showPad(pad, name, way, `${joint.label} ${way < 0 ? "back" : "forward"}`);
        }
      };
      return { node, paint };
    }
  }

  const measure = (joint, value) => (joint.unit === "rad" ? `${((value * 180) / Math.PI).toFixed(0)}°` : `${value.toFixed(2)} m`);

  HL.superDefine("hl-super-jog", Jog);

  // the sheet with a pad for each way of each joint
  function open(robot) {
    return jog.open(robot, () => {
      const { verb, name } = jog.what(robot);
      return HL.sheet({ title: `${verb} the ${name} by hand`, hook: "jog-sheet", body: [el("hl-super-jog")], buttons: [["End manual", () => jog.end(), true]] });
    });
  }

  HL.jogSheet = { open };
})();
