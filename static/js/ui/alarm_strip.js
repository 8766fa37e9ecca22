// On Operate: this robot's worst alarm that nobody acknowledged, what to do about it, and Ack.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, LiveElement, define } = HL;
  const { compare, isUnseen } = HL.alarmOrder;
  const steps = new Map(); // alarm and occurrence -> first thing to do

  function firstStep(id, one) {
    const key = `${id} ${one.raised}`;
    if (!steps.has(key)) {
      steps.set(key, "");
      HL.port.api("GET", HL.alarmActs.of(id)).then((answer) => {
        steps.set(key, answer.type?.steps?.[0] ?? "");
        HL.repaint();
      });
    }
    return steps.get(key);
  }

  class Strip extends LiveElement {
    build() {
      this.sign = el("span", { class: "sign" });
      this.head = el("b", { class: "h-t16" });
      this.line = el("span", { class: "h-t14 line" });
      this.more = el("a", { class: "h-btn q", href: "/alarms" });
      this.button = el("button", { type: "button", class: "h-btn", onclick: () => this.id && HL.alarmActs.send(this.id, "acknowledge") }, icon("done", "m"), "Ack");
      this.append(this.sign, el("span", { class: "words" }, this.head, this.line), this.more, this.button);
      this.may = HL.config.rights.includes(this.dataset.right);
    }
    paint() {
      const robot = HL.view.robot;
      const mine = robot ? Object.entries(HL.alarms.all()).filter(([, one]) => one.source === robot && isUnseen(one)).sort(compare) : [];
      attr(this, "hidden", !mine.length);
      if (!mine.length) return void (this.id = null);
      const [id, one] = mine[0];
      this.id = id;
      const key = `${one.priority}/${one.state}`;
      if (key !== this.drawn) this.sign.replaceChildren(alarm(one.priority, 32, one.state));
      this.drawn = key;
      attr(this, "data-level", one.priority);
      attr(this, "data-state", one.state);
      attr(this, "data-value", id);
      text(this.head, one.title);
      const failed = HL.alarmActs.outcome(id);
      text(this.line, failed && !failed.isOk ? failed.text : one.state === "returned" ? "It is gone again. Nobody has acknowledged it." : firstStep(id, one) || one.text);
      text(this.more, mine.length > 1 ? `${mine.length - 1} more` : "All alarms");
      const isWaiting = Boolean(HL.alarmActs.pending(id));
      attr(this.button, "data-testid", `strip-ack-${id}`);
      attr(this.button, "aria-disabled", !this.may || isWaiting ? "true" : null);
      attr(this.button, "disabled", !this.may);
      attr(this.button, "title", this.may ? 'Acknowledge means "I have seen it"' : "Needs the operator role");
      attr(this.button, "aria-busy", isWaiting);
    }
  }

  define("hl-alarm-strip", Strip);
})();
