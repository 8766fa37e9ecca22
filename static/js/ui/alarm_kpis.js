// How well the alarms work: per ten minutes, not seen, standing, shelved, mix and answer time, each beside its target.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const W = HL.alarmWords;
  const FLOOD = 10;
  const TARGET = 1;
  const NS = "http://www.w3.org/2000/svg";

  function shape(tag, attributes) {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    return node;
  }

  // bars per ten minutes with the lines of target and flood
  function bars(points, height = 62) {
    const width = Math.max(1, points.length) * 10;
    const top = Math.max(12, ...points.map((one) => one.count));
    const y = (count) => height - 3 - (count / top) * (height - 6);
    const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none", role: "img", class: "al-bars" });
    points.forEach((one, i) => {
      const level = one.count >= FLOOD ? "flood" : one.count > TARGET ? "over" : "";
      const tall = Math.max(one.count ? 2 : 1, height - 3 - y(one.count));
      svg.append(shape("rect", { class: level, x: i * 10 + 1, y: height - 3 - tall, width: 7, height: tall }));
    });
    for (const count of [TARGET, FLOOD]) svg.append(shape("path", { d: `M0 ${y(count)}H${width}`, class: "line" }));
    const most = points.reduce((best, one) => (one.count > best.count ? one : best), { count: 0, at: 0 });
    svg.setAttribute("aria-label", points.length ? `Alarms per 10 minutes. Most: ${most.count}${most.at ? ` at ${W.when(most.at)}` : ""}. Target under ${TARGET}, flood at ${FLOOD}.` : "Nothing counted yet");
    return svg;
  }

  class Card {
    constructor(label, hook) {
      this.value = el("span", { class: "h-t28 h-b", "data-testid": hook });
      this.unit = el("span", { class: "h-t14 h-2" });
      this.line = el("div", { class: "h-t12 h-2 h-ell" });
      this.node = el("div", { class: "h-card al-kpi" }, el("div", { class: "h-h" }, label), el("div", { class: "h-row h-base" }, this.value, this.unit), this.line);
    }
    paint(value, unit, line, level) {
      text(this.value, value ?? "––");
      text(this.unit, value === null ? "" : unit);
      text(this.line, line);
      attr(this.node, "data-level", level);
    }
  }

  // shares of priority 1 and 2, 3, 4 in percent, as the target is told; null: a mix of nothing is no mix
  const mixed = (shares) => (shares && Object.keys(shares).length ? [[1, 2], [3], [4]].map((levels) => Math.round(100 * levels.reduce((sum, level) => sum + (shares[level] ?? 0), 0))).join("/") : null);

  class Kpis {
    constructor() {
      this.chart = el("div");
      this.cards = { ten: new Card("Last 10 min", "alarm-kpi-10min"), unseen: new Card("Not acknowledged", "alarm-kpi-unseen"), old: new Card("Standing over 24 h", "alarm-kpi-24h"), shelved: new Card("Shelved", "alarm-kpi-shelved"), mix: new Card("Priority mix, 7 days", "alarm-kpi-mix"), answer: new Card("Answer time", "alarm-kpi-answer") };
      this.node = el("section", { class: "al-kpis", "aria-label": "Figures" },
        el("div", { class: "h-card al-chart" }, el("div", { class: "h-h" }, "Alarms per 10 minutes, last 8 h", el("span", { class: "h-end h-t12 h-2" }, "target under 1, flood at 10")), this.chart),
        ...Object.values(this.cards).map((card) => card.node));
    }
    // found: what /alarms/statistics said last, or null; live: entries of the lane, which are never older than it
    paint(found, live) {
      const all = Object.values(live);
      const unseen = all.filter(HL.alarmOrder.isUnseen);
      const oldest = Math.max(0, ...unseen.map((one) => HL.port.age(one.t)).filter(Number.isFinite));
      const shelved = all.filter((one) => one.state === "shelved");
      const next = Math.min(...shelved.map((one) => one.shelf?.until ?? Infinity));
      const { ten, mix, answer } = this.cards;
      this.cards.unseen.paint(unseen.length, "", unseen.length ? `oldest ${W.clock(oldest / 1000)}` : "none waits");
      this.cards.shelved.paint(shelved.length, "", Number.isFinite(next) ? `next returns ${W.when(next)}` : "nothing put aside");
      const standing = all.filter((one) => HL.alarmOrder.isActive(one) && HL.port.age(one.t) >= 86400000).length;
      this.cards.old.paint(standing, "", "target under 5", standing >= 5 ? 3 : null);
      ten.paint(found?.last_10min ?? null, found?.last_10min === 1 ? "alarm" : "alarms", "target 1, limit 2", found?.last_10min >= FLOOD ? 2 : null);
      mix.paint(mixed(found?.mix_7d), "%", "target 5/15/80");
      answer.paint(found?.answer_median_s === null || found?.answer_median_s === undefined ? null : W.clock(found.answer_median_s), "median", "target under 2:00", found?.answer_median_s >= 120 ? 3 : null);
      const key = JSON.stringify(found?.per_10min ?? []);
      if (key !== this.drawn) this.chart.replaceChildren(bars(found?.per_10min ?? []));
      this.drawn = key;
    }
  }

  Object.assign(HL, { AlarmKpis: Kpis, alarmBars: bars, alarmMix: mixed });
})();
