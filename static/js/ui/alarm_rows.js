// The list of alarms: a long one draws only what is in sight, and all hold still under a pointer.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, toggle } = HL;
  const W = HL.alarmWords;
  const ROW_PX = { wide: 57, compact: 68 };
  const WIDE_PX = 900;
  const SPARE = 4; // rows drawn beyond the edge
  const FEW = 120; // so many are all drawn: screen readers and search in the page find them
  const CALM_MS = 1500; // after a finger left

  class Row {
    constructor(id, act) {
      this.id = id;
      this.sign = el("span", { class: "sign", role: "cell" });
      this.raised = el("span", { class: "raised", role: "cell" });
      this.robotName = el("span", { class: "h-ell" });
      this.responsible = el("span", { class: "under h-ell" });
      this.robot = el("span", { class: "robot", role: "cell" }, this.robotName, this.responsible);
      this.fold = el("button", { type: "button", class: "h-btn q ico fold", onclick: (event) => (event.stopPropagation(), act.fold(this.id)) });
      this.below = el("span", { class: "below", hidden: true }, icon("subdirectory_arrow_right", "m"));
      this.name = el("span", { class: "name h-ell" });
      this.under = el("span", { class: "under h-ell" });
      this.stateSign = icon("done", "s");
      this.stateWord = el("span", { class: "h-ell" });
      this.chip = el("span", { class: "h-chip dark" }, icon("looks_one", "s"), el("span"));
      this.after = el("span", { class: "h-2 h-ell" });
      this.lasting = el("span", { class: "for", role: "cell" });
      this.button = el("button", { type: "button", class: "h-btn", "data-testid": `alarm-ack-${id}`, onclick: (event) => (event.stopPropagation(), act.answer(this.id, this.folds)) });
      this.asideSign = icon("snooze");
      this.aside = el("button", { type: "button", class: "h-btn q ico", "data-testid": `alarm-shelve-${id}`, onclick: (event) => (event.stopPropagation(), this.aside.getAttribute("aria-disabled") !== "true" && act.putAside(this.id)) }, this.asideSign);
      this.node = el("div", { class: "al-row", role: "row", tabindex: "-1", "data-testid": `alarm-row-${id}`, onclick: () => act.choose(this.id) },
        this.sign, this.raised, this.robot,
        el("span", { class: "what", role: "cell" }, this.below, this.fold, el("span", { class: "h-ell" }, this.name, this.under)),
        el("span", { class: "state", role: "cell" }, this.stateSign, this.stateWord),
        el("span", { class: "seq", role: "cell" }, this.chip, this.after), this.lasting, el("span", { class: "act", role: "cell" }, act.putAside ? this.aside : "", this.button));
      this.folds = [];
    }

    paint({ one, isKid, folds, follows, isGone }, { isChosen, isCompact, may, firstTitle, isOpen }) {
      this.folds = folds;
      const state = isGone ? "normal" : one.state;
      const key = `${one.priority}/${state}`;
      if (key !== this.drawn) this.sign.replaceChildren(alarm(one.priority, 28, isGone ? "acknowledged" : one.state));
      this.drawn = key;
      attr(this.node, "data-state", state);
      attr(this.node, "data-level", one.priority);
      attr(this.node, "aria-selected", String(isChosen));
      attr(this.node, "title", W.story(one) || null);
      attr(this.below, "hidden", !isKid);
      toggle(this.node, "unseen", one.state === "unacknowledged" && !isGone);
      text(this.raised, W.raised(one.raised));
      text(this.robotName, one.name);
      const responsible = HL.alarmDuty.of(one.source) ?? "";
      text(this.responsible, responsible);
      attr(this.robot, "title", responsible ? `${one.name}, responsible: ${responsible === HL.alarmDuty.NOBODY ? "nobody" : responsible}` : null);
      text(this.name, one.occurrences > 1 ? `${one.title} ×${one.occurrences}` : one.title);
      const said = HL.alarmOrder.sequence(one, firstTitle);
      const pending = HL.alarmActs.pending(this.id);
      const failed = HL.alarmActs.outcome(this.id);
      const words = pending || (failed && !failed.isOk ? failed.text : isGone ? "Normal again" : W.state(one));
      text(this.under, isCompact ? [one.name, words, said.text, responsible].filter(Boolean).join(" · ") : W.now(one));
      text(this.stateSign, failed && !failed.isOk ? "block" : W.sign(state));
      text(this.stateWord, words);
      toggle(this.stateWord, "told", !isGone && HL.alarmOrder.isUnanswered(one) && words === W.state(one));
      this.paintSequence(said, follows, folds, isOpen);
      text(this.lasting, isGone ? "–" : W.lasting(one));
      this.paintButton(isGone ? null : W.answer(one), pending, may);
      this.paintAside(one, isGone, pending);
    }

    paintSequence(said, follows, folds, isOpen) {
      attr(this.chip, "hidden", !said.isFirst);
      text(this.chip.lastChild, said.text);
      text(this.after, said.isFirst ? "" : said.text);
      attr(this.fold, "hidden", !follows);
      if (!follows) return;
      const sign = isOpen ? "keyboard_arrow_up" : "keyboard_arrow_down";
      if (this.fold.dataset.sign !== sign) this.fold.replaceChildren(icon((this.fold.dataset.sign = sign)));
      attr(this.fold, "aria-expanded", String(isOpen));
      attr(this.fold, "aria-label", isOpen ? "Fold what follows" : `Show ${folds.length} that follow`);
    }

    // shelves from the list; where it cannot, it says why
    paintAside(one, isGone, pending) {
      const isShelved = one.state === "shelved";
      attr(this.aside, "hidden", isGone || one.state === "out_of_service");
      const why = pending || (one.priority === 1 && !isShelved ? "not for priority 1" : "");
      const words = isShelved ? "Bring back" : "Shelve";
      text(this.asideSign, isShelved ? "undo" : "snooze");
      attr(this.aside, "aria-disabled", why ? "true" : null);
      attr(this.aside, "aria-label", why ? `${words}: ${why}` : words);
      attr(this.aside, "title", why ? `${words}: ${why}` : words);
    }

    paintButton(answer, pending, may) {
      attr(this.button, "hidden", !answer);
      if (!answer) return;
      const count = this.folds.length;
      text(this.button, count ? `Ack ${count + 1}` : answer[0]);
      attr(this.button, "aria-disabled", pending || !may ? "true" : null);
      attr(this.button, "aria-busy", Boolean(pending));
      attr(this.button, "title", may ? null : "Needs the operator role");
    }
  }

  // act: {choose(id), answer(id, folds), fold(id), putAside(id) for those who may}
  class Rows {
    constructor(act, hook = "alarm-list") {
      this.act = act;
      this.made = new Map();
      this.shown = []; // as they stand on the screen
      this.place = el("div", { class: "al-rows" });
      this.box = el("div", { class: "al-box", role: "table", "aria-label": "Alarms", "data-testid": hook, tabindex: "0", onscroll: () => this.draw() }, this.place);
      this.news = el("button", { type: "button", class: "h-btn pri al-news", hidden: true, onclick: () => this.settle() });
      this.node = el("div", { class: "al-listing" }, this.box, this.news);
      this.heldUntil = 0;
      this.watchPointer();
    }

    // a mouse over the list holds it, a finger for a moment longer than it touches
    watchPointer() {
      const hold = (event) => (this.heldUntil = event.pointerType === "mouse" ? Infinity : performance.now() + CALM_MS);
      for (const kind of ["pointerenter", "pointerdown", "pointermove"]) this.box.addEventListener(kind, hold, { passive: true });
      this.box.addEventListener("pointerleave", (event) => (this.heldUntil = event.pointerType === "mouse" ? 0 : performance.now() + CALM_MS));
      this.box.addEventListener("scroll", () => this.heldUntil === Infinity || (this.heldUntil = performance.now() + CALM_MS), { passive: true });
    }

    isHeld() {
      return performance.now() < this.heldUntil;
    }

    settle() {
      this.heldUntil = 0;
      this.isForced = true;
      HL.repaint();
    }

    // takes over what is wanted now: its order at once, or, under a pointer, only the values
    take(wanted, view, isForced) {
      this.view = view;
      this.wanted = wanted;
      if (isForced || this.isForced || !this.isHeld() || !this.shown.length) {
        this.shown = wanted;
        this.isForced = this.isBehind = false;
      } else {
        this.isBehind = true;
        const now = new Map(wanted.map((row) => [row.id, row]));
        const live = HL.alarms.all(); // one that left this list may be shelved, and says so
        this.shown = this.shown.map((row) => now.get(row.id) ?? { ...row, one: live[row.id] ?? row.one, isGone: !live[row.id], folds: [], follows: 0 });
      }
      const there = new Set(this.shown.map((row) => row.id));
      const fresh = wanted.filter((row) => !there.has(row.id));
      attr(this.news, "hidden", !fresh.length);
      const worst = Math.min(...fresh.map((row) => row.one.priority));
      if (fresh.length) text(this.news, `${fresh.length} new, priority ${worst}. Show`);
      this.draw();
    }

    draw() {
      const { isCompact } = this.view ?? {};
      const px = isCompact ? ROW_PX.compact : ROW_PX.wide;
      const isFew = this.shown.length <= FEW;
      const from = isFew ? 0 : Math.max(0, Math.floor(this.box.scrollTop / px) - SPARE);
      const until = isFew ? this.shown.length : Math.min(this.shown.length, Math.ceil((this.box.scrollTop + this.box.clientHeight) / px) + SPARE);
      HL.style(this.place, "height", `${this.shown.length * px}px`);
      attr(this.box, "aria-rowcount", this.shown.length);
      const live = new Set();
      for (let index = from; index < until; index += 1) {
        const row = this.shown[index];
        live.add(row.id);
        if (!this.made.has(row.id)) this.made.set(row.id, new Row(row.id, this.act));
        const made = this.made.get(row.id);
        HL.style(made.node, "transform", `translateY(${index * px}px)`);
        attr(made.node, "aria-rowindex", index + 1);
        made.paint(row, { ...this.view, isChosen: row.id === this.view.chosen, firstTitle: this.view.titleOf(row.one), isOpen: this.view.open.has(row.id) });
        if (made.node.parentNode !== this.place) this.place.append(made.node);
      }
      for (const [id, made] of this.made) if (!live.has(id)) this.drop(id, made);
    }

    // a row that is only scrolled away keeps the focus; of one that ended it goes to the list
    drop(id, made) {
      const hasFocus = made.node.contains(document.activeElement);
      if (hasFocus && this.shown.some((row) => row.id === id)) return;
      if (hasFocus) this.box.focus({ preventScroll: true });
      made.node.remove();
      this.made.delete(id);
    }

    // rows that a person can see now, wholly or in part
    inSight() {
      const px = this.view?.isCompact ? ROW_PX.compact : ROW_PX.wide;
      const from = Math.floor(this.box.scrollTop / px);
      return this.shown.slice(from, Math.ceil((this.box.scrollTop + this.box.clientHeight) / px));
    }

    reveal(id) {
      const px = this.view?.isCompact ? ROW_PX.compact : ROW_PX.wide;
      const index = this.shown.findIndex((row) => row.id === id);
      if (index < 0) return;
      const [top, height] = [index * px, this.box.clientHeight];
      if (top < this.box.scrollTop) this.box.scrollTop = top;
      else if (top + px > this.box.scrollTop + height) this.box.scrollTop = top + px - height;
    }
  }

  HL.AlarmRows = Rows;
  HL.alarmWide = WIDE_PX;
})();
