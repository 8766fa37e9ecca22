// The card of the chart: what it shows, how far back, as drawing or as table.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const C = HL.sensorScale;
  const SPANS = Object.entries(C.SPANS);
  const STEPS = [[86400, "day"], [3600, "hour"]];
  const stepWords = (s) => {
    const [long, name] = STEPS.find(([one]) => s >= one) ?? [60, "minute"];
    const n = Math.round(s / long);
    return n === 1 ? `one value a ${name}` : `one value each ${n} ${name === "minute" ? "min" : `${name}s`}`;
  };

  class Curve {
    constructor() {
      this.chart = new HL.SensorChart();
      this.isTable = false;
      this.title = el("b", { class: "h-t16 h-b h-ell" });
      this.pick = el("select", { class: "h-select sn-pick", "aria-label": "Station", "data-testid": "sensor-chart-station", onchange: () => HL.sensors.show(this.pick.value, HL.sensors.shown.key) });
      this.spans = SPANS.map(([key, { label }]) => el("button", { type: "button", "data-testid": `sensor-span-${key}`, onclick: () => HL.sensors.setSpan(key) }, label));
      this.toggle = el("button", { type: "button", class: "h-btn", "data-testid": "sensor-table", onclick: () => ((this.isTable = !this.isTable), HL.repaint()) }, "Table");
      this.blank = el("div", { class: "sn-blank h-2", role: "status" });
      this.table = el("div", { class: "sn-table", tabindex: "0" });
      this.node = el("section", { class: "h-card sn-chart", "aria-label": "Over time" },
        el("div", { class: "sn-charthead" }, el("span", { class: "sn-names" }, this.title, this.chart.said), this.pick, el("div", { class: "h-seg", role: "group", "aria-label": "How far back" }, ...this.spans), this.toggle),
        this.chart.node, this.table, this.blank);
    }

    paint(stations) {
      const { series, span } = HL.sensors;
      const about = HL.sensors.subject();
      attr(this.node, "hidden", !about);
      if (!about) return;
      const { value, station } = about;
      const label = value.label || HL.sensorRules.QUANTITIES[value.quantity]?.label || value.quantity;
      const { unit } = HL.sensorUnits.of(value.unit);
      text(this.title, `${label}${unit ? `, ${unit}` : ""}`);
      this.paintPick(stations, about);
      this.spans.forEach((button, i) => attr(button, "aria-pressed", String(SPANS[i][0] === span)));
      attr(this.toggle, "aria-pressed", String(this.isTable));
      text(this.toggle, this.isTable ? "Chart" : "Table");
      const isMine = series?.of === about.key;
      const found = isMine ? series.found : null;
      const count = found?.read.filter((one) => one.mean !== null).length ?? 0;
      const words = this.says(isMine ? series : null, count);
      text(this.blank, words);
      attr(this.blank, "hidden", !words);
      attr(this.chart.node, "hidden", !count || this.isTable);
      attr(this.chart.said, "hidden", !count || this.isTable);
      attr(this.table, "hidden", !count || !this.isTable);
      attr(this.node, "data-points", count);
      if (!count) return;
      const old = series.problem ? `Not brought up to date: ${series.problem} ` : "";
      this.chart.show({ found, span, unit: found.unit || value.unit, quantity: value.quantity, title: `${label}, ${station.name}`, note: `${old}${station.name}, ${stepWords(found.step_s)}. Touch to read.` });
      if (this.isTable) this.paintTable(found, value);
    }

    says(series, count) {
      if (!series || (series.isLoading && !series.found)) return "Loading";
      if (!series.found) return `The chart did not load. ${series.problem} It is asked for again.`;
      return count ? "" : "Nothing was measured in this time.";
    }

    paintPick(stations, about) {
      const among = stations.filter((one) => one.is_accepted && one.values.some((value) => value.key === about.value.key));
      const key = among.map((one) => `${one.id}:${one.name}`).join();
      attr(this.pick, "hidden", among.length < 2 || Boolean(HL.sensors.chosen));
      if (key !== this.among) this.pick.replaceChildren(...among.map((one) => el("option", { value: one.id }, one.name)));
      this.among = key;
      if (this.pick.value !== about.station.id) this.pick.value = about.station.id;
    }

    paintTable(found, value) {
      const key = JSON.stringify([found.points?.length, found.points?.at(-1), value.key, HL.preferences.get("speed"), HL.preferences.get("temperature"), HL.sensors.span]);
      if (key === this.tabled) return;
      this.tabled = key;
      const digits = HL.sensorUnits.digits(value.quantity);
      const say = (one) => HL.sensorUnits.words(one, found.unit || value.unit, digits);
      const rows = [...found.read].reverse().map((one) => ({ cells: [HL.words.day(new Date(one.t)), ...(one.mean === null ? ["not measured", "", ""] : [say(one.mean), say(one.low), say(one.high)])] }));
      this.table.replaceChildren(HL.records.table(["From", "Mean", "Lowest", "Highest"], rows));
    }

    destroy() {
      this.chart.destroy();
    }
  }

  HL.SensorCurve = Curve;
})();
