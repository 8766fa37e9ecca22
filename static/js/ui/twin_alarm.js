// Beside the picture: this robot's worst alarm, and Ack.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, LiveElement } = HL;

  class TwinAlarm extends LiveElement {
    build() {
      this.sign = el("span", { class: "sign" });
      this.head = el("b", { class: "h-t16 h-b" });
      this.line = el("span", { class: "h-t13 h-2" });
      this.ack = el("button", { type: "button", class: "h-btn", onclick: () => this.send() }, icon("done", "m"), "Ack");
      this.more = el("a", { class: "h-btn q", href: "/alarms" });
      this.card = el("section", { class: "h-card t-alarm", "aria-label": "Alarm" }, el("div", { class: "h-row" }, this.sign, el("div", { class: "words" }, this.head, this.line)), el("div", { class: "h-row" }, this.ack, this.more));
      this.append(this.card);
    }
    worst() {
      if (!HL.alarmOrder || !HL.alarmActs) return []; // they load after STOP
      const { isActive, compare } = HL.alarmOrder;
      return Object.entries(HL.alarms.all()).filter(([, one]) => one.source === HL.view.robot && isActive(one)).sort(compare);
    }
    said(id, one) {
      if (HL.alarms.isOld()) return `The alarm list is ${HL.words.since(HL.alarms.ageMs())} old.`;
      const outcome = HL.alarmActs.outcome(id);
      if (outcome && !outcome.isOk) return outcome.text;
      return one.state === "returned" ? "It is gone again. Nobody has acknowledged it." : one.text;
    }
    send() {
      if (this.ack.getAttribute("aria-disabled") === "true") return HL.toast(this.ack.title, "lock");
      return HL.alarmActs.send(this.id, "acknowledge");
    }
    paint() {
      const all = this.worst();
      attr(this, "hidden", !all.length);
      if (!all.length) return;
      const [[id, one]] = all;
      this.id = id;
      const key = `${one.priority}/${one.state}`;
      if (key !== this.drawn) this.sign.replaceChildren(alarm(one.priority, 32, one.state));
      this.drawn = key;
      attr(this, "data-level", one.priority);
      attr(this, "data-state", one.state);
      attr(this, "data-value", id);
      text(this.head, one.title);
      text(this.line, this.said(id, one));
      text(this.more, all.length > 1 ? `${all.length - 1} more` : "All alarms");
      const may = HL.config.rights.includes(this.dataset.right);
      attr(this.ack, "hidden", !HL.alarmOrder.isUnseen(one));
      attr(this.ack, "data-testid", `twin-ack-${id}`);
      attr(this.ack, "title", may ? 'Acknowledge means "I have seen it"' : "Needs the operator role");
      attr(this.ack, "aria-disabled", !may || HL.alarmActs.pending(id) ? "true" : null);
    }
  }

  HL.superDefine("hl-twin-alarm", TwinAlarm);
})();
