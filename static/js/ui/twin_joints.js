// Joints and gauges beside the picture: bars with limits, warning beyond the soft ones; ages as everywhere.
(() => {
  "use strict";
  const { el, text, attr, style, toggle } = HL;
  const STALE_MS = 2000;
  const NONE = "––";

  const shown = (value, unit) => {
    if (value === null || value === undefined) return [NONE, ""];
    if (unit === "rad") return [((value * 180) / Math.PI).toFixed(1).replace("-", "−"), "°"];
    return [(Math.abs(value) >= 100 ? value.toFixed(0) : value.toFixed(Math.abs(value) >= 10 ? 1 : 2)).replace("-", "−"), unit];
  };
  const share = (value, lower, upper) => (upper > lower ? Math.min(1, Math.max(0, (value - lower) / (upper - lower))) * 100 : 50);

  class Bar {
    constructor() {
      this.ok = el("span", { class: "ok" });
      this.planned = el("span", { class: "plan", hidden: "" });
      this.low = el("span", { class: "lim" });
      this.high = el("span", { class: "lim" });
      this.pointer = el("span", { class: "ptr" });
      this.node = el("div", { class: "t-rail" }, this.ok, this.low, this.high, this.planned, this.pointer);
    }
    paint(one, okLower, okUpper, value) {
      const from = okLower === null || okLower === undefined ? 0 : share(okLower, one.lower, one.upper);
      const to = okUpper === null || okUpper === undefined ? 100 : share(okUpper, one.lower, one.upper);
      style(this.ok, "left", `${from}%`);
      style(this.ok, "right", `${100 - to}%`);
      for (const [mark, at] of [[this.low, from], [this.high, to]]) {
        attr(mark, "hidden", at <= 0 || at >= 100);
        style(mark, "left", `${at}%`);
      }
      attr(this.pointer, "hidden", value === null || value === undefined);
      if (value !== null && value !== undefined) style(this.pointer, "left", `${share(value, one.lower, one.upper)}%`);
      const isPlanned = one.planned !== null && one.planned !== undefined;
      attr(this.planned, "hidden", !isPlanned);
      if (isPlanned) style(this.planned, "left", `${share(one.planned, one.lower, one.upper)}%`);
    }
  }

  class Row {
    constructor(one) {
      this.sign = el("span", { class: "sign" });
      this.value = el("b", { class: "h-t18 h-b" });
      this.unit = el("span", { class: "h-t13 h-2" });
      this.bar = new Bar();
      this.node = el("div", { class: "t-joint", "data-testid": `joint-${one.name}` }, el("div", { class: "h-row" }, this.sign, el("span", { class: "h-t14 h-b" }, one.label || one.name), el("span", { class: "h-sp" }), el("span", {}, this.value, " ", this.unit)), this.bar.node);
    }
    paint(one, value) {
      const [number, unit] = shown(value, one.unit);
      text(this.value, number);
      text(this.unit, unit);
      attr(this.node, "data-value", value ?? null);
      const isBeyond = value !== null && value !== undefined && ((one.soft_lower !== null && value < one.soft_lower) || (one.soft_upper !== null && value > one.soft_upper));
      attr(this.node, "data-level", isBeyond ? 2 : null);
      if (isBeyond !== this.isBeyond) {
        this.isBeyond = isBeyond;
        this.sign.replaceChildren(...(isBeyond ? [HL.alarm(2, 20)] : []));
      }
      this.bar.paint(one, one.soft_lower, one.soft_upper, value);
    }
  }

  class Gauge {
    constructor(one) {
      this.value = el("b", { class: "h-t22 h-b" });
      this.bar = new Bar();
      this.node = el("div", { class: "h-card t-gauge", "data-testid": `gauge-${one.key}` }, el("div", { class: "h-t13 h-2 t-gaugehead" }, el("span", { class: "h-ell" }, one.label), (this.age = el("span", { class: "h-t12" }))), el("div", {}, this.value, " ", el("span", { class: "h-t13 h-2" }, one.unit)), this.bar.node, el("div", { class: "h-t12 h-2" }, one.limit_text || ""));
    }
    paint(one, ageMs) {
      text(this.value, shown(one.value, one.unit)[0]);
      text(this.age, Number.isFinite(ageMs) ? HL.words.age(ageMs) : "");
      attr(this.node, "data-value", one.value ?? null);
      attr(this.node, "data-level", one.level ?? null);
      this.bar.paint(one, one.ok_lower, one.ok_upper, one.value);
    }
  }

  class TwinSide {
    constructor() {
      this.age = el("span", { class: "h-t12 h-2" });
      this.title = el("b", { class: "h-t16 h-b" }, "Joints");
      this.list = el("div", {});
      this.card = el("section", { class: "h-card t-joints", "aria-label": "Joints", hidden: "" }, el("div", { class: "h-row" }, this.title, el("span", { class: "h-sp" }), this.age), this.list);
      this.gauges = el("div", { class: "t-gauges" });
      this.hint = el("p", { class: "h-t13 h-2 t-hint" }, "Drag turns, two fingers move, pinch zooms. ", el("span", { class: "h-key" }, "Arrows"), " turn, ", el("span", { class: "h-key" }, "+"), " ", el("span", { class: "h-key" }, "−"), " zoom, ", el("span", { class: "h-key" }, "0"), " resets.");
      this.node = el("div", { class: "t-sidelist" }, this.card, this.gauges, this.hint);
      this.rows = new Map();
      this.tiles = new Map();
    }

    // `past`: values of a replayed moment instead of those of now
    paint(robot, past) {
      const inside = HL.port.inside(robot);
      const joints = inside.joints?.joints ?? [];
      this.keep(this.rows, joints, (one) => one.name, (one) => new Row(one), this.list);
      joints.forEach((one) => this.rows.get(one.name).paint(past ? { ...one, planned: null } : one, past ? past[one.name] ?? null : one.value));
      attr(this.card, "hidden", joints.length === 0);
      const ageMs = inside.joints ? HL.port.age(inside.joints.t) : null;
      text(this.age, past ? "replay" : ageMs === null ? "" : HL.words.age(ageMs));
      toggle(this.card, "stale", !past && ageMs !== null && ageMs > STALE_MS);
      attr(this.card, "data-age-ms", ageMs === null || !Number.isFinite(ageMs) ? null : Math.round(ageMs));
      const gauges = past ? [] : inside.gauges?.gauges ?? [];
      this.keep(this.tiles, gauges, (one) => one.key, (one) => new Gauge(one), this.gauges);
      gauges.forEach((one) => this.tiles.get(one.key).paint(one, HL.port.age(inside.gauges.t)));
      const gaugesMs = inside.gauges && !past ? HL.port.age(inside.gauges.t) : null; // a robot without joints has gauges too
      toggle(this.gauges, "stale", gaugesMs !== null && gaugesMs > STALE_MS);
      attr(this.gauges, "data-age-ms", gaugesMs === null || !Number.isFinite(gaugesMs) ? null : Math.round(gaugesMs));
    }

    keep(kept, list, keyOf, make, place) {
      const keys = list.map(keyOf).join();
      if (kept.keys === keys) return;
      kept.clear();
      kept.keys = keys;
      list.forEach((one, i) => kept.set(keyOf(one), make(one, i)));
      place.replaceChildren(...[...kept.values()].map((row) => row.node));
    }
  }

  HL.TwinSide = TwinSide;
})();
