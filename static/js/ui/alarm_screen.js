// Alarms: figures, list, one in detail, and what can be done about those that are shown.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement, define } = HL;
  const Order = HL.alarmOrder;
  const Acts = HL.alarmActs;
  const STATISTICS_MS = 30000;
  const SOON_MS = 2000; // alarms come close together
  const LEADER_MS = 1500; // `g a` moves here and acknowledges nothing
  const DESK = matchMedia("(min-width: 1600px)");

  class Alarms extends LiveElement {
    build() {
      this.may = { ack: this.dataset.mayAck === "yes", shelve: this.dataset.mayShelve === "yes" };
      this.open = new Set();
      this.chosen = "";
      this.filter = new HL.AlarmFilter(() => this.refresh(true));
      this.kpis = new HL.AlarmKpis();
      this.notes = new HL.AlarmNotes(this.filter);
      this.rows = new HL.AlarmRows({ choose: (id) => this.choose(id), answer: (id, folds) => this.answer(id, folds), fold: (id) => this.fold(id), putAside: this.may.shelve && ((id) => this.putAside(id)) });
      toggle(this, "can-shelve", this.may.shelve);
      this.detail = new HL.AlarmDetail(this.may, { close: () => this.choose("") });
      this.journal = new HL.AlarmJournal(() => this.filter.value());
      this.statistics = new HL.AlarmStatistics();
      this.head = el("div", { class: "al-row al-th", role: "row", id: "al-head" }, ...["Prio", "Raised", "Robot", "Alarm", "State", "Sequence", "For", ""].map((name, i) => el("span", { role: "columnheader", class: ["sign", "raised", "robot", "what", "state", "seq", "for", "act"][i] }, name)));
      this.rights = el("p", { class: "h-t13 h-2 al-rights", "data-testid": "alarm-rights" }, !this.may.ack ? this.dataset.noAck : this.may.shelve ? "" : this.dataset.noShelve);
      this.list = el("section", { class: "al-list h-card", "aria-label": "Alarms" }, this.filter.node, this.rights, this.notes.old, this.notes.flood, this.head, this.rows.node, this.notes.blank, this.journal.node, this.statistics.node);
      this.append(this.kpis.node, this.list, this.detail.node, this.makeDock());
      attr(this.rows.box, "aria-owns", "al-head"); // it stands still above what scrolls, and names its columns
      this.counted = null;
    }

    makeDock() {
      const button = (sign, label, hook, onclick) => el("button", { type: "button", class: "h-btn op", "data-testid": hook, onclick }, icon(sign), el("span", {}, el("span", {}, label), el("span", { class: "sub" })));
      this.ackShown = button("done_all", "Acknowledge shown", "alarm-ack-shown", () => this.acknowledgeShown());
      this.silence = button("volume_off", "Silence 2 min", "alarm-silence", () => HL.bell?.silence());
      this.shelve = button("snooze", "Shelve", "alarm-shelve-chosen", () => this.shelve.getAttribute("aria-disabled") !== "true" && this.detail.putAside());
      this.exportButton = button("download", "Export journal", "alarm-export", () => this.journal.export());
      const hint = el("span", { class: "h-hint al-hint" }, "Acknowledge means “I have seen it”. ", el("br"), "It does not reset or move a robot.");
      return el("div", { class: "h-dockbar al-dock", role: "group", "aria-label": "Actions" }, this.ackShown, this.silence, this.shelve, this.exportButton, el("span", { class: "h-sp" }), hint);
    }

    enter() {
      this.offs = [window.headland.on("alarms", () => this.refresh()), window.headland.on("event", (event) => event?.kind === "alarm" && this.countSoon()), HL.alarmDuty.begin()];
      this.timer = setInterval(() => this.count(), STATISTICS_MS);
      this.sizes = new ResizeObserver(() => this.refresh(true));
      this.sizes.observe(this.list);
      this.onKey = (event) => this.key(event);
      window.addEventListener("keydown", this.onKey);
      this.count();
      this.refresh(true);
    }

    leave() {
      for (const off of this.offs) off?.();
      clearInterval(this.timer);
      clearTimeout(this.counting);
      this.sizes.disconnect();
      window.removeEventListener("keydown", this.onKey);
    }

    countSoon() {
      clearTimeout(this.counting);
      this.counting = setTimeout(() => this.count(), SOON_MS);
    }

    async count() {
      const answer = await HL.port.api("GET", "/alarms/statistics");
      this.problem = answer.ok ? "" : answer.text;
      if (answer.ok) this.counted = { data: answer, at: performance.now() };
      if (this.filter.tab === "statistics") this.statistics.draw(this.figures(), this.problem, () => this.count());
      HL.repaint();
    }

    // figures that could not be renewed are not shown as if they were of now
    figures() {
      return this.counted && performance.now() - this.counted.at < 3 * STATISTICS_MS ? this.counted.data : null;
    }

    isFlood() {
      return Boolean(HL.alarms.summary()?.flood) && this.filter.tab === "active";
    }

    // sorts anew; in between only values are painted
    refresh(isForced = false) {
      const tab = this.filter.tab;
      const isList = tab === "active" || tab === "shelved";
      attr(this, "data-tab", tab); // the detail of one makes room for what is about all
      const wide = this.list.clientWidth >= HL.alarmWide;
      toggle(this, "compact", !wide);
      for (const [node, isOn] of [[this.head, isList && wide], [this.rows.node, isList], [this.journal.node, tab === "journal"], [this.statistics.node, tab === "statistics"]]) attr(node, "hidden", !isOn);
      HL.style(this.head, "padding-right", `${8 + this.rows.box.offsetWidth - this.rows.box.clientWidth}px`); // above a scroll bar columns would shift
      const alarms = HL.alarms.all();
      this.wanted = Order.rows(alarms, { isWanted: tab === "shelved" ? Order.isAside : Order.isActive, filter: this.filter.value(), isFlood: this.isFlood(), open: this.open });
      toggle(this, "no-seq", !this.wanted.some(({ one }) => one.group > 1)); // a column for nothing would cut the words beside it
      if (isList) this.rows.take(this.wanted, this.view(!wide), isForced);
      if (isForced && tab === "journal") this.journal.load();
      if (isForced && tab === "statistics") this.statistics.draw(this.figures(), this.problem, () => this.count());
      if (Object.keys(alarms).length) this.notes.forgetLast();
      if (!this.hasChosen && DESK.matches && this.wanted.length) this.choose(this.wanted[0].id);
      HL.repaint();
    }

    view(isCompact) {
      const alarms = HL.alarms.all();
      return { isCompact, chosen: this.chosen, may: this.may.ack, open: this.open, titleOf: (one) => alarms[one.first]?.title ?? "" };
    }

    paint() {
      const all = Object.entries(HL.alarms.all());
      const active = all.filter(([, one]) => Order.isActive(one)).length;
      const aside = all.filter(([, one]) => Order.isAside(one)).length;
      this.filter.paint(active, aside, sources(all));
      this.kpis.paint(this.figures(), HL.alarms.all());
      const isList = this.filter.tab === "active" || this.filter.tab === "shelved";
      this.notes.paint(isList ? this.wanted?.length ?? 0 : 1, this.filter.tab === "active" ? active : aside, this.filter.isOn());
      attr(this, "data-state", HL.alarms.ageMs() === null ? "loading" : HL.alarms.isOld() ? "stale" : "ok");
      attr(this, "data-detail", this.chosen ? "open" : null);
      if (isList && this.rows.isBehind && !this.rows.isHeld()) this.refresh();
      else if (isList) this.rows.draw();
      this.detail.paint(HL.alarms.all()[this.chosen]);
      this.paintDock(isList);
    }

    paintDock(isList) {
      const count = isList && this.filter.tab === "active" ? this.unseenShown().length : 0;
      const off = (button, reason, line = "") => (attr(button, "aria-disabled", reason ? "true" : null), text(button.querySelector(".sub"), reason || line));
      off(this.ackShown, !this.may.ack ? "needs the operator role" : count ? "" : "none waits here", count === 1 ? "1 alarm" : `${count} alarms`);
      off(this.silence, "", HL.bell?.state() === "silenced" ? `${HL.words.clock(HL.bell.silentMs() / 1000)} left` : "the list stays");
      const one = HL.alarms.all()[this.chosen];
      off(this.shelve, !this.may.shelve ? "needs the supervisor role" : !one ? "choose an alarm first" : one.priority === 1 ? "not for priority 1" : one.state === "out_of_service" ? "out of service" : "", one?.state === "shelved" ? "bring it back" : one?.title ?? "");
      text(this.exportButton.querySelector(".sub"), "CSV, as filtered");
    }

    unseenShown() {
      return this.rows.inSight().filter((row) => !row.isGone && Order.isUnseen(HL.alarms.all()[row.id] ?? {}));
    }

    acknowledgeShown() {
      if (this.ackShown.getAttribute("aria-disabled") !== "true") Acts.acknowledge(this.unseenShown().map((row) => row.id));
    }

    // a cause with what is folded below it is one answer
    answer(id, folds) {
      const all = HL.alarms.all();
      const found = all[id] && HL.alarmWords.answer(all[id]);
      if (!found || !this.may.ack) return;
      const below = folds.filter((kid) => all[kid] && Order.isUnseen(all[kid]));
      if (below.length) Acts.acknowledge([id, ...below]);
      else Acts.send(id, found[1]);
    }

    putAside(id) {
      const one = HL.alarms.all()[id];
      if (one) HL.alarmShelving.toggle(id, one);
    }

    fold(id) {
      if (!this.open.delete(id)) this.open.add(id);
      this.refresh(true);
    }

    choose(id) {
      this.hasChosen = true;
      const one = HL.alarms.all()[id];
      this.chosen = one ? id : "";
      if (one && this.detail.id !== id) this.detail.show(id, one);
      if (!one) this.detail.id = null;
      this.rows.view = this.view(this.list.clientWidth < HL.alarmWide);
      HL.repaint();
    }

    // J and K walk, Enter opens, A acknowledges
    key(event) {
      const isLed = performance.now() - (this.ledAt ?? -Infinity) < LEADER_MS;
      this.ledAt = event.key === "g" ? performance.now() : -Infinity;
      if (isLed || event.ctrlKey || event.altKey || event.metaKey || event.target.closest?.("input, select, textarea, .h-sheet")) return;
      const at = this.rows.shown.findIndex((row) => row.id === this.chosen);
      const move = { j: 1, k: -1 }[event.key.toLowerCase()];
      if (move && this.rows.shown.length) {
        const next = this.rows.shown[Math.min(this.rows.shown.length - 1, Math.max(0, at + move))];
        this.choose(next.id);
        this.rows.reveal(next.id);
      } else if (event.key.toLowerCase() === "a" && this.chosen && !event.repeat) this.answer(this.chosen, []);
      else if (event.key === "Enter" && this.chosen && !event.target.closest?.("button, a")) this.detail.title.focus();
      else if (event.key === "Escape" && this.chosen && !DESK.matches) this.choose("");
    }
  }

  function sources(all) {
    const names = new Map(Object.entries(HL.port.fleet()).map(([id, robot]) => [id, robot.name]));
    for (const [, one] of all) if (!names.has(one.source)) names.set(one.source, one.name);
    return [...names.entries()].sort((a, b) => a[1].localeCompare(b[1], "en", { numeric: true }));
  }

  // its style comes with it, before it shows itself
  const href = document.querySelector("hl-alarm-screen")?.dataset.style ?? "";
  const sheet = el("link", { rel: "stylesheet", href });
  sheet.onload = () => define("hl-alarm-screen", Alarms);
  sheet.onerror = () => HL.toast("This screen did not load. Open it again.", "cloud_off");
  document.head.append(sheet);
})();
