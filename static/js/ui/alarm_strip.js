// On Operate: this robot's worst alarm that nobody acknowledged, what to do about it, and Ack.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, LiveElement, define } = HL;
  const { compare, isUnseen, isUnanswered } = HL.alarmOrder;
  const asked = new Map(); // alarm, occurrence and step of its life -> {step: first thing to do, who: responsible}

  function advice(id, one) {
    const key = `${id} ${one.raised} ${one.escalated}`;
    if (!asked.has(key)) {
      asked.set(key, { step: "", who: "" });
      HL.port.api("GET", HL.alarmActs.of(id)).then((answer) => {
        asked.set(key, { step: answer.type?.steps?.[0] ?? "", who: answer.responsible ?? "" });
        HL.repaint();
      });
    }
    return asked.get(key);
  }

  class Strip extends LiveElement {
    build() {
      this.sign = el("span", { class: "sign" });
      this.head = el("b", { class: "h-t16" });
      this.told = el("b");
      this.say = el("span");
      this.line = el("span", { class: "h-t14 line" }, this.told, this.say);
      this.more = el("a", { class: "h-btn q", href: "/alarms" });
      this.button = el("button", { type: "button", class: "h-btn", onclick: () => this.id && HL.alarmActs.send(this.id, "acknowledge") }, icon("done", "m"), "Ack");
      this.append(this.sign, el("span", { class: "words" }, this.head, this.line), this.more, this.button);
      this.may = HL.config.rights.includes(this.dataset.right);
    }
    paint() {
      const robot = HL.view.robot;
      const said = window.headlandStop?.banner();
      const isSaid = said?.state === "not-confirmed" && said.robots.includes(robot); // the banner above says it larger
      const mine = robot ? Object.entries(HL.alarms.all()).filter(([, one]) => one.source === robot && isUnseen(one) && !(isSaid && one.code === "stop-not-confirmed")).sort(compare) : [];
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
      const { step, who } = advice(id, one);
      text(this.told, isUnanswered(one) ? `Nobody answered${who ? `, responsible: ${who}` : ""}. ` : "");
      text(this.say, failed && !failed.isOk ? failed.text : one.state === "returned" ? "It is gone again. Nobody has acknowledged it." : step || one.text);
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
