// One tile for each thing that is measured: its value, how old it is, where it stands within its limit, and who says so.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, style, toggle, words } = HL;
  const R = HL.sensorRules;
  const U = () => HL.sensorUnits;
  const TRENDS = { up: ["arrow_upward", "rising"], down: ["arrow_downward", "falling"] };
  const hookOf = (key) => `sensor-value-${key.toLowerCase().replace(/[^a-z0-9]+/g, "-")}`;

  class Tile {
    constructor(key, chosen) {
      this.glyph = el("span", { hidden: true }, alarm(3, 20));
      this.name = el("span", { class: "h-ell" });
      this.age = el("span");
      this.figure = el("span");
      this.unit = el("small");
      this.trend = icon("arrow_upward", "s");
      this.wind = new HL.sensorGlyphs.WindArrow();
      this.band = el("span", { class: "ok" });
      this.pointer = el("span", { class: "ptr" });
      this.bar = el("div", { class: "h-bar", "aria-hidden": "true" }, this.band, this.pointer);
      this.line = el("div", { class: "sub" });
      this.node = el("button", { type: "button", class: "h-tile sn-tile", "data-testid": hookOf(key), onclick: () => chosen(this.one) },
        el("span", { class: "lab" }, el("span", { class: "name" }, this.glyph, this.name), el("span", { class: "h-age" }, icon("schedule", "s"), this.age)),
        el("span", { class: "val" }, this.wind.node, this.figure, this.unit, this.trend),
        this.bar, this.line);
    }

    paint(one, isAll, isShown) {
      this.one = one;
      const { value, station } = one;
      const isGone = value.state === "never" || !U().isNumber(value.value);
      const isOld = value.state === "silent" || isGone;
      attr(this.node, "data-state", value.state);
      attr(this.node, "data-value", isGone ? "" : value.value);
      attr(this.node, "data-station", station.id);
      attr(this.node, "data-age-ms", value.age === null ? null : Math.round(value.age * 1000));
      attr(this.node, "aria-pressed", String(isShown));
      toggle(this.node, "stale", isOld);
      toggle(this.node, "late", value.state === "late");
      const isOver = (Boolean(value.is_over) || value.is_plausible === false) && !isOld;
      attr(this.node, "data-level", isOver ? 3 : null);
      this.glyph.hidden = !isOver;
      text(this.name, value.label || R.QUANTITIES[value.quantity]?.label || value.quantity);
      text(this.age, value.age === null ? "never" : words.age(value.age * 1000));
      const shown = U().shown(isGone ? null : value.value, value.unit, U().digits(value.quantity));
      text(this.figure, shown.text);
      text(this.unit, shown.unit);
      this.paintTrend(isOld || value.quantity === "wind_speed" ? null : value.trend); // the arrow on wind is its direction
      this.paintWind(one, isOld);
      this.paintBar(isGone ? null : R.bar(value));
      text(this.line, this.under(one, isAll, isGone));
      attr(this.node, "title", `${station.name}: ${this.line.textContent}`);
    }

    paintTrend(trend) {
      attr(this.trend, "hidden", !TRENDS[trend]);
      if (!TRENDS[trend]) return;
      text(this.trend, TRENDS[trend][0]);
      attr(this.trend, "title", TRENDS[trend][1]);
    }

    paintWind(one, isOld) {
      const from = one.value.quantity === "wind_speed" ? R.beside(one, "wind_bearing") : null;
      const isKnown = !isOld && U().isNumber(from?.value) && from.state !== "silent";
      attr(this.wind.node, "hidden", !isKnown);
      if (isKnown) this.wind.paint(from.value);
    }

    paintBar(bar) {
      attr(this.bar, "hidden", !bar);
      if (!bar) return;
      style(this.band, "left", `${bar.ok[0]}%`);
      style(this.band, "right", `${100 - bar.ok[1]}%`);
      style(this.pointer, "left", `${bar.ptr}%`);
      const key = bar.limits.join();
      if (key === this.limits) return;
      this.limits = key;
      this.bar.querySelectorAll(".lim").forEach((mark) => mark.remove());
      for (const at of bar.limits) {
        const mark = el("span", { class: "lim" });
        mark.style.left = `${at}%`;
        this.bar.append(mark);
      }
    }

    // its limit first, for what is too long is cut off at its end; whose word it is where there are several, what belongs to it
    under(one, isAll, isGone) {
      const { value, station } = one;
      if (isGone) return value.state === "never" ? "never measured" : `${station.name}: not measured`;
      if (value.is_plausible === false) return `${station.name}: this cannot be true`;
      const parts = [this.limit(value), isAll && one.all.length > 1 ? station.name : ""];
      const beside = (quantity, say) => {
        const other = R.beside(one, quantity);
        if (U().isNumber(other?.value)) parts.push(say(other.value, other.unit, U().digits(quantity)));
      };
      if (value.quantity === "wind_speed") {
        beside("wind_bearing", (from) => `from ${R.compass(from)}`);
        if (isAll) beside("wind_gust", (gusts, unit, digits) => `gusts ${U().shown(gusts, unit, digits).text}`);
      }
      if (value.quantity === "soil_moisture" && isAll) beside("soil_temperature", U().words);
      if (isAll) parts.push(this.spread(one));
      return parts.filter(Boolean).map((part) => part.replaceAll(" ", "\u00a0")).join(" · ") || station.name; // a line breaks between them
    }

    limit({ limit, unit, quantity }) {
      const say = (value) => U().shown(value, unit, U().digits(quantity)).text;
      const [low, high] = [limit?.low, limit?.high].map(U().isNumber);
      if (low && high) return `limits ${say(limit.low)} to ${say(limit.high)}`;
      return high ? `limit ${say(limit.high)}` : low ? `least ${say(limit.low)}` : "";
    }

    // where several stations measure the same, how far apart they are
    spread({ all }) {
      const fresh = all.filter(({ value }) => R.rank(value.state) < R.rank("silent") && U().isNumber(value.value)).map(({ value }) => value);
      if (fresh.length < 2) return all.length > 1 ? `1 of ${all.length} reports` : "";
      const { unit, quantity } = fresh[0];
      const of = (value) => U().shown(value, unit, U().digits(quantity)).text;
      return `all ${of(Math.min(...fresh.map((one) => one.value)))}–${of(Math.max(...fresh.map((one) => one.value)))}`;
    }
  }

  class Tiles {
    constructor() {
      this.tiles = new Map();
      this.node = el("div", { class: "sn-tiles", role: "group", "aria-label": "Values" });
    }

    paint(stations, chosen, shown) {
      const wanted = R.tiles(stations, chosen);
      const keys = wanted.map(({ value }) => value.key);
      if (keys.join() !== this.keys) {
        this.keys = keys.join();
        for (const key of [...this.tiles.keys()]) if (!keys.includes(key)) this.tiles.delete(key);
        for (const key of keys) if (!this.tiles.has(key)) this.tiles.set(key, new Tile(key, (one) => HL.sensors.show(one.station.id, one.value.key)));
        this.node.replaceChildren(...keys.map((key) => this.tiles.get(key).node));
      }
      for (const one of wanted) this.tiles.get(one.value.key).paint(one, !chosen, shown?.key === one.value.key);
      return wanted.length;
    }
  }

  HL.SensorTiles = Tiles;
})();
