// What stands above the list when it is not simply a list: old, empty, loading, a flood.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const { words } = HL;
  const LATE_MS = 5000;

  class Notes {
    constructor(filter) {
      this.filter = filter;
      this.bornAt = performance.now();
      this.oldWord = el("b", { class: "h-t16 h-b" });
      this.oldLine = el("span", { class: "h-t14" });
      this.old = el("div", { class: "al-note old", role: "alert", hidden: true, "data-testid": "alarm-old" }, icon("warning"), el("span", { class: "words" }, this.oldWord, this.oldLine), el("button", { type: "button", class: "h-btn", onclick: () => this.again() }, icon("refresh", "m"), "Try again"));
      this.floodWord = el("span", { class: "h-t16" });
      this.flood = el("div", { class: "al-note flood", role: "status", hidden: true, "data-testid": "alarm-flood" }, icon("warning", "f"), this.floodWord);
      this.blank = el("div", { class: "al-blank", hidden: true, "data-testid": "alarm-blank" });
      this.lastAt = undefined;
    }

    // asks the server itself: it says whether only this tablet is behind
    async again() {
      text(this.oldLine, "Asking the server …");
      const answer = await HL.alarmActs.call("GET", "/alarms?state=active");
      text(this.oldLine, answer.ok ? "The server answers, but nothing looks for alarms. Tell whoever looks after Headland." : answer.text);
    }

    paint(shown, total, isFiltered) {
      const ageMs = HL.alarms.ageMs();
      const isOld = HL.alarms.isOld();
      attr(this.old, "hidden", !isOld);
      if (isOld) text(this.oldWord, Number.isFinite(ageMs) ? `Alarm list is ${words.since(ageMs)} old. Do not rely on it.` : "Nothing looks for alarms. Do not rely on this list.");
      else text(this.oldLine, "");
      const flood = HL.alarms.summary()?.flood;
      attr(this.flood, "hidden", !flood);
      if (flood) text(this.floodWord, `Flood: ${flood.count} alarms in 10 min. Grouped under what came first; priority 3 and 4 make no sound.`);
      this.paintBlank(shown, total, isFiltered, ageMs === null);
    }

    paintBlank(shown, total, isFiltered, isLoading) {
      attr(this.blank, "hidden", shown > 0);
      const isLate = isLoading && performance.now() - this.bornAt > LATE_MS;
      const key = shown ? "" : isLate ? "late" : isLoading ? "loading" : isFiltered && total ? "filtered" : this.filter.tab === "shelved" ? "shelved" : `none ${this.lastAt}`;
      if (key === this.key) return;
      this.key = key;
      if (key) this.blank.replaceChildren(...this.content(key));
      if (key.startsWith("none") && this.lastAt === undefined) this.findLast();
    }

    content(key) {
      const notice = (sign, head, line, ...more) => [el("div", { class: "h-notice" }, icon(sign, "l"), el("b", { class: "h-t22 h-b" }, head), el("span", { class: "h-2 h-t16" }, line), ...more)];
      if (key === "loading") return [el("div", { class: "h-skeleton al-skeleton" }, ...["100%", "92%", "97%", "88%"].map((width) => { const bar = el("i"); bar.style.width = width; return bar; }), el("b", { class: "h-t18 h-b" }, "Loading alarms"))];
      if (key === "late") return notice("cloud_off", "Alarm list did not load", "The server did not answer in 5 s. STOP still works. Look at the machines.", el("button", { type: "button", class: "h-btn", onclick: () => location.reload() }, "Try again"));
      if (key === "filtered") return notice("filter_list", "No alarm fits the filter", "There are others.", el("button", { type: "button", class: "h-btn", onclick: () => this.filter.clear() }, "Show all"));
      if (key === "shelved") return notice("snooze", "Nothing is shelved.", "");
      return notice("check", "No alarms.", this.lastAt ? `Last one ${words.since(Date.now() - this.lastAt)} ago.` : "");
    }

    async findLast() {
      this.lastAt = null;
      const answer = await HL.port.api("GET", "/alarms/journal?limit=1");
      this.lastAt = answer.last_raised ?? null;
      HL.repaint();
    }
    forgetLast() {
      this.lastAt = undefined;
    }
  }

  HL.AlarmNotes = Notes;
})();
