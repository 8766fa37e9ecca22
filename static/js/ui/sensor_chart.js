// Values over time: mean line, lowest to highest as a band, limits by name, treatments under way; gaps stay gaps.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const { svg } = HL.sensorGlyphs;
  const C = HL.sensorScale;
  const R = HL.sensorRules;
  const LEFT = 52;
  const RIGHT = 14;
  const TOP = 22; // names of treatments stand above the values
  const FOOT = 26;
  const LEAST = [240, 120];
  const DOT_PX = 3;
  const LABEL_PX = 17;
  const LETTER_PX = 6.6;
  const LIMIT_PX = 7.4; // of a name in bold

  class Chart {
    constructor() {
      this.root = svg("svg", { class: "sn-plot", tabindex: "0", role: "img", "data-testid": "sensor-chart" });
      this.said = el("div", { class: "sn-readout", "aria-live": "polite", "data-testid": "sensor-readout" });
      this.box = el("div", { class: "sn-plotbox" }, this.root);
      this.node = this.box;
      this.sized = new ResizeObserver(() => this.draw());
      this.sized.observe(this.box);
      this.root.addEventListener("pointermove", (event) => this.point(event));
      this.root.addEventListener("pointerdown", (event) => this.point(event));
      this.root.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && this.cursor(null)); // a touch leaves its reading
      this.root.addEventListener("keydown", (event) => this.key(event));
    }

    // found: the series with its points read; words(value) with its unit
    show({ found, span, unit, quantity, title, note }) {
      const key = [span, unit, title, note, HL.preferences.get("speed"), HL.preferences.get("temperature")].join("|");
      if (key === this.shown && found === this.about.found) return;
      const isOther = title !== this.title || span !== this.about?.span;
      Object.assign(this, { shown: key, title, about: { found, span, unit, quantity, note } });
      if (isOther) this.at = null;
      this.draw();
    }

    draw() {
      const { width, height } = this.box.getBoundingClientRect();
      if (!this.about || !width || !height) return;
      const [w, h] = [Math.max(LEAST[0], Math.round(width)), Math.max(LEAST[1], Math.round(height))];
      const { found, span, quantity } = this.about;
      const own = HL.sensorUnits.of(this.about.unit);
      const points = found.read.map((one) => (one.mean === null ? one : { ...one, mean: own.from(one.mean), low: own.from(one.low), high: own.from(one.high) }));
      const bound = (value) => (HL.sensorUnits.isNumber(value) ? own.from(value) : null);
      const limits = { low: bound(found.limits?.low), high: bound(found.limits?.high) };
      const [from, to] = C.reach(points, span, HL.sensors.now());
      const scale = C.scale(points, limits, { isFloored: Boolean(R.QUANTITIES[quantity]?.isFloored) && this.about.unit !== "°C", count: Math.max(2, Math.floor((h - TOP - FOOT) / 36)) });
      const x = (t) => LEFT + ((t - from) / (to - from)) * (w - LEFT - RIGHT);
      const y = (value) => h - FOOT - ((value - scale.low) / (scale.high - scale.low)) * (h - TOP - FOOT);
      Object.assign(this, { points, plot: { w, h, x, y, from, to, stepS: found.step_s, unit: own.unit, digits: HL.sensorUnits.digits(quantity) } });
      attr(this.root, "viewBox", `0 0 ${w} ${h}`);
      this.mark = svg("g", { class: "cursor" });
      const inside = points.filter((one) => one.t >= from - found.step_s * 1000 && one.t <= to);
      this.inside = inside;
      this.root.replaceChildren(...this.bands(found.treatments), ...this.grid(scale), ...this.feet(), ...C.runs(inside, found.step_s).flatMap((run) => this.run(run)), ...this.limits(limits, scale), this.mark);
      attr(this.root, "aria-label", this.summary(inside));
      this.cursor(this.at);
    }

    words(value) {
      const { unit, digits } = this.plot;
      return `${value.toFixed(digits)} ${unit}`.trim();
    }

    summary(points) {
      const drawn = points.filter((one) => one.mean !== null);
      if (!drawn.length) return `${this.title}: no values`;
      return `${this.title}: ${this.words(Math.min(...drawn.map((one) => one.low)))} to ${this.words(Math.max(...drawn.map((one) => one.high)))}, last ${this.words(drawn[drawn.length - 1].mean)}. Arrow keys read single values.`;
    }

    bands(treatments) {
      const { x, w, h, from, to } = this.plot;
      const all = C.bands(treatments, from, to).map((one) => ({ ...one, left: x(one.from), right: Math.max(x(one.to), x(one.from) + 2) }));
      return all.flatMap((one, i) => {
        const words = `${one.text}${one.isOpen ? ", now" : ""}`;
        const full = svg("title", {});
        full.textContent = words;
        return [svg("rect", { class: "treatment", x: one.left, y: TOP, width: one.right - one.left, height: h - TOP - FOOT }, full), svg("path", { class: "treatmentedge", d: `M${one.left} ${TOP - 4}V${h - FOOT}M${one.right} ${TOP - 4}V${h - FOOT}` }), this.named(words, one, all[i - 1]?.right ?? LEFT, all[i + 1]?.left ?? w - RIGHT)];
      });
    }

    // the name over a band, to the side that has more room, never into the next one
    named(words, { left, right }, before, after) {
      const isRight = right - before > after - left;
      const room = Math.floor(((isRight ? right - before : after - left) - 8) / LETTER_PX);
      const name = svg("text", { class: "treated", y: TOP - 7, ...(isRight ? { x: right - 4, "text-anchor": "end" } : { x: left + 4 }) });
      name.textContent = words.length <= room ? words : room > 8 ? `${words.slice(0, room - 1).trimEnd()}…` : "";
      return name;
    }

    grid(scale) {
      const { w, y } = this.plot;
      const digits = C.digits(scale.step);
      return scale.ticks.flatMap((value) => {
        const label = svg("text", { class: "tick", x: LEFT - 8, y: y(value) + 4, "text-anchor": "end" });
        label.textContent = value.toFixed(digits);
        return [svg("path", { class: value === 0 ? "grid zero" : "grid", d: `M${LEFT} ${y(value).toFixed(1)}H${w - RIGHT}` }), label];
      });
    }

    feet() {
      const { w, h, x, from, to } = this.plot;
      return C.times(from, to, w - LEFT - RIGHT).filter(({ t }) => x(t) < w - RIGHT - 10).flatMap(({ t, text: words, isDay }) => {
        const label = svg("text", { class: "tick", x: x(t), y: h - 8, "text-anchor": "middle" });
        label.textContent = words;
        return [svg("path", { class: isDay ? "foot day" : "foot", d: `M${x(t).toFixed(1)} ${isDay ? TOP : h - FOOT}V${h - FOOT + 4}` }), label];
      });
    }

    // one stroke between two gaps; a point that stands alone is a dot
    run(run) {
      const { x, y } = this.plot;
      const at = (one, key) => `${x(one.t).toFixed(1)} ${y(one[key]).toFixed(1)}`;
      if (run.length === 1) return [svg("path", { class: "spread alone", d: `M${at(run[0], "low")}L${at(run[0], "high")}` }), svg("circle", { class: "alone", cx: x(run[0].t), cy: y(run[0].mean), r: DOT_PX })];
      const up = run.map((one) => at(one, "high")).join("L");
      const down = [...run].reverse().map((one) => at(one, "low")).join("L");
      return [svg("path", { class: "spread", d: `M${up}L${down}Z` }), svg("path", { class: "mean", d: `M${run.map((one) => at(one, "mean")).join("L")}` })];
    }

    limits(limits, scale) {
      const { w, x, y } = this.plot;
      const dots = this.inside.filter((one) => one.mean !== null).map((one) => ({ x: x(one.t), y: y(one.mean) }));
      for (const one of C.bands(this.about.found.treatments, this.plot.from, this.plot.to)) for (let at = x(one.from); at <= x(one.to); at += LETTER_PX) dots.push({ x: at, y: TOP - 7 }); // their names
      return C.limitLines(limits, scale, (value) => this.words(value)).flatMap((one) => {
        const [over, below] = [y(one.at) - 5, y(one.at) + LABEL_PX - 3];
        const feet = y(one.at) < TOP + LABEL_PX ? [below, over] : [over, below];
        const { x: left, foot } = C.freest(dots, { feet, left: LEFT + 4, right: w - RIGHT - 4, wide: one.text.length * LIMIT_PX, high: LABEL_PX - 4 });
        const name = svg("text", { class: "limitname", x: left, y: foot });
        name.textContent = one.text;
        return [svg("path", { class: one.beyond ? "limit beyond" : "limit", d: `M${LEFT} ${y(one.at).toFixed(1)}H${w - RIGHT}` }), name];
      });
    }

    point(event) {
      if (!this.plot) return;
      const frame = this.root.getBoundingClientRect();
      const share = ((event.clientX - frame.left) / frame.width * this.plot.w - LEFT) / (this.plot.w - LEFT - RIGHT);
      const { from, to } = this.plot;
      this.cursor(from + Math.min(1, Math.max(0, share)) * (to - from));
    }

    key(event) {
      const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!this.plot || !this.inside?.length) return;
      const drawn = this.inside.filter((one) => one.mean !== null);
      if (!drawn.length) return;
      if (way) this.cursor((C.beyond(drawn, this.at ?? (way > 0 ? -Infinity : Infinity), way) ?? drawn[way > 0 ? drawn.length - 1 : 0]).t);
      else if (event.key === "Home") this.cursor(drawn[0].t);
      else if (event.key === "End") this.cursor(drawn[drawn.length - 1].t);
      else if (event.key === "Escape" && this.at !== null) this.cursor(null);
      else return;
      event.preventDefault();
      event.stopPropagation();
    }

    // what lies at a time; without one, the newest value and how to read others
    cursor(t) {
      this.at = t;
      if (!this.mark) return;
      const { x, y, h, stepS } = this.plot;
      const hit = t === null ? null : C.under(this.inside, t, stepS);
      this.mark.replaceChildren();
      if (!hit) return text(this.said, this.about.note);
      const at = hit.point?.t ?? hit.t;
      this.mark.append(svg("path", { d: `M${x(at).toFixed(1)} ${TOP}V${h - FOOT}` }));
      const when = HL.words.day(new Date(at));
      if (!hit.point) return text(this.said, `${when}: nothing was measured`);
      const { mean, low, high } = hit.point;
      this.mark.append(svg("circle", { cx: x(at), cy: y(mean), r: 5 }));
      const spread = low < mean || high > mean ? `, lowest ${this.words(low)}, highest ${this.words(high)}` : "";
      return text(this.said, `${when}: ${this.words(mean)}${spread}`);
    }

    destroy() {
      this.sized.disconnect();
    }
  }

  HL.SensorChart = Chart;
})();
