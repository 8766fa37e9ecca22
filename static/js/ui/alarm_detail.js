// One alarm: what to do, what happens if nobody acts, what it came from, and what can be done about it here.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, toggle } = HL;
  const W = HL.alarmWords;
  const Acts = HL.alarmActs;
  const LATE_MS = 5000;
  const WHO = { operator: "An operator can do it.", supervisor: "A supervisor can do it.", admin: "An admin can do it." };

  const button = (look, sign, label, hook, onclick) => {
    const word = el("span", {}, label);
    const sub = el("span", { class: "sub" });
    const node = el("button", { type: "button", class: `h-btn ${look}`, "data-testid": hook, onclick: () => node.getAttribute("aria-disabled") !== "true" && onclick() }, icon(sign), el("span", {}, word, sub));
    return { node, word, sub };
  };
  // off stays where it is, dashed, and says why
  function allow(one, reason, label) {
    attr(one.node, "aria-disabled", reason ? "true" : null);
    text(one.sub, reason || "");
    if (label) text(one.word, label);
  }

  class Detail {
    // may: {ack, shelve}; act: {close}
    constructor(may, act) {
      this.may = may;
      this.id = null;
      this.sign = el("span");
      this.title = el("h2", { class: "h-t28 h-hv", tabindex: "-1" });
      this.where = el("div", { class: "h-t14 h-2" });
      this.lasting = el("span", { class: "h-t36 h-hv al-for" });
      this.close = el("button", { type: "button", class: "h-btn ico q al-close", "aria-label": "Close", "data-testid": "alarm-close", onclick: () => act.close() }, icon("close"));
      this.now = el("div", { class: "h-t16 h-b" });
      this.story = el("div", { class: "h-t14 h-2" });
      this.body = el("div", { class: "al-body" });
      this.said = el("div", { class: "h-t14 h-b al-said", role: "status", "data-testid": "alarm-said" });
      this.scroll = el("div", { class: "al-scroll", tabindex: "-1" }, this.now, this.story, this.body);
      this.scroll.addEventListener("scroll", () => this.edge(), { passive: true });
      const watch = new ResizeObserver(() => this.edge());
      [this.scroll, this.body].forEach((node) => watch.observe(node));
      this.makeActs();
      this.node = el("aside", { class: "h-card al-detail", "aria-label": "Alarm in detail", "data-testid": "alarm-detail", hidden: true },
        el("div", { class: "al-head" }, this.sign, el("div", { class: "al-titles" }, this.title, this.where), this.lasting, this.close),
        this.scroll, this.said, this.acts);
    }

    // what goes on below fades out: a line cut in half looks like a mistake, and one cut between lines like the end
    edge() {
      const { scrollTop, scrollHeight, clientHeight } = this.scroll;
      toggle(this.scroll, "more", scrollHeight - scrollTop - clientHeight > 4);
    }

    makeActs() {
      this.ack = button("op pri", "done", "Acknowledge", "alarm-acknowledge", () => this.answer());
      this.call = el("a", { class: "h-btn op", "data-testid": "alarm-call" }, icon("call", "f"), el("span"));
      this.open = el("a", { class: "h-btn op ico", "aria-label": "Open robot", title: "Open robot", "data-testid": "alarm-open" }, icon("open_in_new"));
      this.shelve = button("op", "snooze", "Shelve", "alarm-shelve", () => this.putAside());
      this.check = button("", "troubleshoot", "Diagnose", "alarm-diagnose", () => HL.alarmDiagnose(this.id, this.one));
      this.out = button("", "do_not_disturb_on", "Out of service", "alarm-out-of-service", () => this.service());
      this.acts = el("div", { class: "al-acts" }, this.ack.node, this.call, el("i", { class: "narrow" }), this.open, this.shelve.node, el("i", { class: "broad" }), this.check.node, this.out.node);
    }

    answer() {
      const found = W.answer(this.one);
      if (found) Acts.send(this.id, found[1]);
    }
    putAside() {
      HL.alarmShelving.toggle(this.id, this.one);
    }
    service() {
      if (this.one.state === "out_of_service") Acts.send(this.id, "in-service");
      else HL.alarmShelving.takeOut(this.id, this.one);
    }

    async show(id, one) {
      this.id = id;
      this.one = one;
      this.loaded = null;
      this.key = "";
      if (!this.may.shelve) attr(this.shelve.node, "data-testid", `alarm-shelve-${id}`); // else the row has this name
      this.body.replaceChildren(HL.el("div", { class: "h-skeleton" }, ...["100%", "80%", "92%"].map((width) => { const bar = el("i"); bar.style.width = width; return bar; })));
      await this.load();
    }

    async load() {
      const id = this.id;
      const answer = await HL.port.api("GET", Acts.of(id), null, LATE_MS);
      if (id !== this.id) return;
      if (!answer.ok && this.loaded) return; // what is shown stays; its state comes from the lane
      if (!answer.ok) return void this.body.replaceChildren(el("div", { class: "h-col" }, el("b", { class: "h-t16" }, "What to do did not load."), el("span", { class: "h-2" }, answer.text), el("button", { type: "button", class: "h-btn", onclick: () => this.load() }, icon("refresh", "m"), "Try again")));
      this.loaded = answer;
      this.body.replaceChildren(...this.parts(answer));
      HL.repaint();
    }

    parts({ type = {}, sequence = [], seen_before: before }) {
      const steps = (type.steps ?? []).map((words) => el("li", {}, words));
      const seen = before > 1 ? ` Seen here ${before} times in 30 days.` : before === 1 ? " Seen here once in 30 days." : "";
      return [
        el("h3", { class: "h-t16 h-b" }, "What to do"),
        el("ol", { class: "al-steps", "data-testid": "alarm-steps" }, ...steps),
        WHO[type.who] || type.who ? el("p", { class: "h-t14 h-2" }, WHO[type.who] ?? `Who can: ${type.who}.`) : "",
        el("div", { class: "al-two" }, el("div", {}, el("div", { class: "h-h" }, "If nobody acts"), el("p", { class: "h-t14" }, type.consequence ?? "–")), el("div", {}, el("div", { class: "h-h" }, "Likely cause"), el("p", { class: "h-t14" }, `${type.cause ?? "–"}${seen}`))),
        el("div", { class: "al-events" }, el("div", { class: "h-row h-base" }, el("h3", { class: "h-t16 h-b" }, "Sequence of events"), el("span", { class: "h-t13 h-2" }, "first cause on top, 10 ms resolution")),
          sequence.length ? el("ol", { class: "al-seq", "data-testid": "alarm-sequence" }, ...sequence.map((one) => el("li", { class: one.is_alarm ? "alarm" : "" }, el("time", {}, W.precise(one.at)), el("i"), el("span", {}, one.text, one.is_first ? el("b", { class: "h-chip dark" }, "First out") : "")))) : el("p", { class: "h-t14 h-2" }, "Nothing was noted around it.")),
      ];
    }

    // the newest entry of the lane; null when it is normal again
    paint(one) {
      attr(this.node, "hidden", !this.id);
      if (!this.id) return;
      const isGone = !one;
      if (one) this.one = one;
      const now = this.one;
      const state = isGone ? "normal" : now.state;
      const key = `${this.id}/${now.priority}/${state}/${now.occurrences}/${now.group}/${now.escalated}`;
      if (key !== this.key) {
        this.sign.replaceChildren(alarm(now.priority, 52, isGone ? "acknowledged" : now.state));
        if (this.key && this.loaded) this.load();
        this.key = key;
      }
      attr(this.node, "data-level", now.priority);
      attr(this.node, "data-state", state);
      text(this.title, now.title);
      text(this.where, `${now.name}, raised ${W.raised(now.raised)}`);
      text(this.lasting, isGone ? "" : W.lasting(now));
      text(this.now, W.now(now));
      const known = HL.alarmDuty.of(now.source) ?? this.loaded?.responsible;
      const responsible = known === HL.alarmDuty.NOBODY ? "nobody" : known;
      text(this.story, isGone ? "Normal again. It left the list." : [W.state(now), W.story(now), now.chattering ? "It comes and goes: it is held until it was quiet for a minute." : "", now.escalated ? `${HL.alarmOrder.isUnanswered(now) ? "Told" : "Nobody answered: told"} on at ${W.raised(now.escalated)}.` : "", responsible ? `Responsible: ${responsible}.` : ""].filter(Boolean).join(". ").replaceAll("..", "."));
      this.paintActs(now, isGone);
    }

    paintActs(one, isGone) {
      const pending = Acts.pending(this.id);
      const failed = Acts.outcome(this.id);
      text(this.said, pending || (failed && !failed.isOk ? failed.text : ""));
      toggle(this.said, "failed", Boolean(failed && !failed.isOk && !pending));
      const answer = isGone ? null : W.answer(one);
      const wait = pending ? "one moment" : "";
      const word = answer?.[1] === "clear" ? "Clear" : "Acknowledge";
      allow(this.ack, wait || (!this.may.ack ? "needs the operator role" : isGone ? "it is normal again" : !answer ? (one.state === "acknowledged" ? "it is acknowledged" : "it is not shown now") : ""), word);
      const contact = this.loaded?.contact;
      attr(this.call, "hidden", !contact?.phone);
      if (contact?.phone) {
        attr(this.call, "href", `tel:${contact.phone.replace(/[^+\d]/g, "")}`);
        text(this.call.lastChild, `Call ${(contact.name || "contact").split(" ")[0]}`);
        attr(this.call, "title", `${contact.name ?? ""} ${contact.phone}`.trim());
      }
      const isRobot = Boolean(HL.port.fleet()[one.source]);
      attr(this.open, "hidden", !isRobot);
      if (isRobot) attr(this.open, "href", `/operate/${one.source}`);
      const isShelved = one.state === "shelved";
      const noShelf = !this.may.shelve ? "needs the supervisor role" : one.priority === 1 ? "not for priority 1" : isGone ? "it is normal again" : one.state === "out_of_service" ? "it is out of service" : "";
      allow(this.shelve, wait || noShelf, isShelved && !isGone ? "Bring back" : "Shelve");
      const isOut = one.state === "out_of_service";
      allow(this.out, wait || (!this.may.shelve ? "needs the supervisor role" : isGone ? "it is normal again" : one.priority === 1 && !isOut && HL.config.user.role !== "admin" ? "priority 1: admin only" : ""), isOut ? "Put into service" : "Out of service");
      attr(this.check.node, "hidden", !this.loaded?.type?.has_diagnosis);
      allow(this.check, isGone ? "it is normal again" : "");
    }
  }

  HL.AlarmDetail = Detail;
})();
