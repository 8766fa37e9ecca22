// Statistics: which alarms come most, how many a person has to answer, what stands, and how often it was a flood.
(() => {
  "use strict";
  const { el, icon } = HL;
  const { table, empty } = HL.records;
  const W = HL.alarmWords;
  const DAY_MS = 86400000;
  const percent = (share, digits = 0) => (share === null || share === undefined ? "––" : `${(share * 100).toFixed(digits)} %`);
  const number = (value, digits = 1) => (value === null || value === undefined ? "––" : value.toFixed(digits));

  const mix = (shares) => (HL.alarmMix(shares) ? `${HL.alarmMix(shares)}\u00a0%` : "––");

  const fact = (label, value, line) => el("div", { class: "h-card" }, el("div", { class: "h-h" }, label), el("div", { class: "h-t28 h-b" }, value), el("div", { class: "h-t13 h-2" }, line));

  function actors(top, all) {
    if (!top?.length) return empty("No alarms counted yet", "The ten that come most are listed here.");
    const most = Math.max(...top.map((one) => one.count));
    const rows = top.map((one) => {
      const bar = el("i", { class: "al-share" });
      bar.style.width = `${(one.count / most) * 100}%`;
      return { hook: `alarm-actor-${one.code}`, cells: [one.title, el("span", { class: "al-sharebox" }, bar), one.count, all ? percent(one.count / all) : "––"] };
    });
    return table(["Alarm", "", "Times", "Share"], rows);
  }

  function standing(live) {
    const old = Object.entries(live).filter(([, one]) => HL.alarmOrder.isActive(one) && HL.port.age(one.t) >= DAY_MS);
    if (!old.length) return el("p", { class: "h-t14 h-2" }, "No alarm stands longer than 24 h.");
    return table(["Alarm", "Robot", "Stands for", "State"], old.map(([id, one]) => ({ hook: `alarm-standing-${id}`, cells: [one.title, one.name, W.lasting(one), W.state(one)] })));
  }

  class Statistics {
    constructor() {
      this.isTable = false;
      this.place = el("div", { class: "h-sec" });
      this.node = el("div", { class: "al-page h-scroll", "data-testid": "alarm-statistics" }, this.place);
    }

    draw(found, problem, again) {
      if (!found) {
        if (problem) this.place.replaceChildren(el("div", { class: "h-card h-notice", role: "alert" }, el("b", { class: "h-t18 h-b" }, "Statistics did not load"), el("span", { class: "h-2" }, problem), el("button", { type: "button", class: "h-btn", onclick: again }, icon("refresh", "m"), "Try again")));
        else this.place.replaceChildren(el("div", { class: "h-skeleton", "aria-label": "Loading" }, el("i"), el("i"), el("i")));
        return;
      }
      this.found = found;
      this.place.replaceChildren(
        el("div", { class: "al-facts" },
          fact("Per operator hour", number(found.per_operator_hour), "of who is signed in, 8 h; target 6 or fewer"),
          fact("Time in flood", percent(found.flood_share, 1), "target under 1 %"),
          fact("Answer time", W.clock(found.answer_median_s), "median, target under 2:00"),
          fact("Standing over 24 h", found.standing_24h ?? "––", `target under 5${found.stale ? `; ${found.stale} acknowledged and left` : ""}`),
          fact("Come and go now", found.chattering ?? "––", "three times in a minute"),
          fact("Priority mix, 7 days", mix(found.mix_7d), "priority 1 and 2, 3, 4; target 5/15/80")),
        this.chart(found.per_10min ?? []),
        el("h2", {}, "Ten alarms that come most, 7 days"), actors(found.top, found.raised_7d),
        el("h2", {}, "Standing over 24 h"), standing(HL.alarms.all()),
      );
    }

    chart(points) {
      const toggle = el("button", { type: "button", class: "h-btn", "aria-pressed": String(this.isTable), "data-testid": "alarm-chart-table", onclick: () => ((this.isTable = !this.isTable), this.draw(this.found)) }, this.isTable ? "Show as chart" : "Show as table");
      const body = this.isTable ? el("div", { class: "al-numbers" }, table(["From", "Alarms"], points.map((one) => ({ cells: [W.when(one.at), one.count] })))) : HL.alarmBars(points, 140);
      return el("section", { class: "h-card" }, el("div", { class: "h-row" }, el("b", { class: "h-t16 h-b" }, "Alarms per 10 minutes, last 8 h"), el("span", { class: "h-t13 h-2" }, "target under 1, flood at 10"), el("span", { class: "h-sp" }), toggle), body);
    }
  }

  HL.AlarmStatistics = Statistics;
})();
