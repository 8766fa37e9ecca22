// The journal: every step of every alarm, newest first, with filters; exported as it is filtered.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr } = HL;
  const { table, empty } = HL.records;
  const W = HL.alarmWords;
  const PAGE = 100;
  const WORDS = { raised: "Raised", acknowledged: "Acknowledged", returned: "Returned", cleared: "Cleared", shelved: "Shelved", unshelved: "Back from the shelf", suppressed: "Suppressed", unsuppressed: "No longer suppressed", out_of_service: "Out of service", in_service: "Back in service", escalated: "Told on" };
  const SPANS = [["8 h", 8], ["24 h", 24], ["7 days", 168], ["30 days", 720], ["All", 0]];
  const HOUR_MS = 3600000;

  class Journal {
    constructor(filter) {
      this.filter = filter; // () -> {robot, priority, q}
      this.span = 24;
      this.entries = [];
      this.place = el("div", { class: "h-col" });
      this.more = el("button", { type: "button", class: "h-btn", hidden: true, onclick: () => this.load(true) }, "Older");
      this.spans = el("div", { class: "h-seg", role: "radiogroup", "aria-label": "Time" }, ...SPANS.map(([name, hours]) => el("button", { type: "button", role: "radio", "data-hours": hours, onclick: () => ((this.span = hours), this.load()) }, name)));
      this.node = el("div", { class: "al-page al-journal h-scroll", "data-testid": "alarm-journal" }, el("div", { class: "h-row" }, this.spans), this.place, this.more);
    }

    query(extra = {}) {
      const { robot, priority, q } = this.filter();
      const wanted = { robot, q, priority: priority || "", from: this.span ? new Date(Date.now() - this.span * HOUR_MS).toISOString() : "", ...extra };
      return new URLSearchParams(Object.entries(wanted).filter(([, value]) => value !== "" && value !== undefined)).toString();
    }

    async load(isMore = false) {
      for (const one of this.spans.children) attr(one, "aria-checked", String(Number(one.dataset.hours) === this.span));
      if (!isMore) this.place.replaceChildren(el("div", { class: "h-skeleton", "aria-label": "Loading" }, el("i"), el("i"), el("i")));
      const asked = (this.asked = this.query(isMore ? { limit: PAGE, before: this.next } : { limit: PAGE }));
      const answer = await HL.port.api("GET", `/alarms/journal?${asked}`);
      if (asked !== this.asked) return;
      if (!answer.ok) return void this.fail(answer);
      const found = answer.lines ?? [];
      this.entries = isMore ? [...this.entries, ...found] : found;
      this.next = answer.next_before;
      attr(this.more, "hidden", !this.next);
      this.draw();
    }

    fail(answer) {
      this.place.replaceChildren(el("div", { class: "h-card h-notice", role: "alert" }, el("b", { class: "h-t18 h-b" }, "Journal did not load"), el("span", { class: "h-2" }, answer.text), el("button", { type: "button", class: "h-btn", onclick: () => this.load() }, icon("refresh", "m"), "Try again")));
    }

    draw() {
      if (!this.entries.length) return void this.place.replaceChildren(empty("Nothing in this time", "Choose a longer time, or another filter."));
      this.place.replaceChildren(table(["Time", "Prio", "Robot", "Alarm", "What", "By", "Text"], this.entries.map((one) => ({ hook: `alarm-journal-${one.seq}`, cells: [W.stamp(one.at), alarm(one.priority, 24, one.what === "raised" ? "unacknowledged" : "acknowledged"), one.name, one.title, WORDS[one.what] ?? one.what, one.by || "–", one.text ?? ""] }))));
    }

    // the file has the same filters as the list
    async export() {
      const answer = await fetch(`${HL.config.apiPath}/alarms/journal.csv?${this.query()}`, { credentials: "same-origin", cache: "no-store" }).catch(() => null);
      const file = answer?.ok ? await answer.blob().catch(() => null) : null; // null too where the link broke midway
      if (!file) return HL.toast("Journal not exported: the server did not give all of it. Try again.", "block");
      const link = el("a", { href: URL.createObjectURL(file), download: `alarms-${new Date().toISOString().slice(0, 10)}.csv` });
      document.body.append(link);
      link.click();
      link.remove();
      setTimeout(() => URL.revokeObjectURL(link.href), 60000);
      return HL.toast("Journal saved as a CSV file.", "download");
    }
  }

  HL.AlarmJournal = Journal;
})();
