// What the time went to: a ring by subsystem, or a list by state, of the span that the durations show.
(() => {
  "use strict";
  const { el, svg, text, attr, LiveElement, words } = HL;
  const OUTER = 86, INNER = 52;
  const TONES = [84, 58, 42, 70, 32, 50]; // share of the dark tone: neighbours differ
  const isWaiting = (one) => one.subsystem === "Waiting" || one.subsystem === "Operator";

  function arc(from, to) {
    const a = (share) => share * 2 * Math.PI - Math.PI / 2;
    const p = (r, share) => `${(r * Math.cos(a(share))).toFixed(2)} ${(r * Math.sin(a(share))).toFixed(2)}`;
    const until = Math.min(to, from + 0.9999);
    const big = until - from > 0.5 ? 1 : 0;
    return `M${p(OUTER, from)}A${OUTER} ${OUTER} 0 ${big} 1 ${p(OUTER, until)}L${p(INNER, until)}A${INNER} ${INNER} 0 ${big} 0 ${p(INNER, from)}Z`;
  }

  const tone = (i) => `color-mix(in srgb, var(--hl-sel) ${TONES[i % TONES.length]}%, var(--hl-inset))`;
  // whole percent that add up to a hundred: what was cut off goes where most was cut
  function percents(shares) {
    const whole = shares.map((one) => Math.floor(one * 100));
    const rest = Math.round(shares.reduce((a, b) => a + b, 0) * 100) - whole.reduce((a, b) => a + b, 0);
    shares.map((one, i) => [one * 100 - whole[i], i]).sort((a, b) => b[0] - a[0]).slice(0, Math.max(0, rest)).forEach(([, i]) => (whole[i] += 1));
    return whole;
  }

  class SuperShare extends LiveElement {
    build() {
      this.sub = el("span", { class: "sub h-t13 h-2" });
      this.look = HL.superSeg("Time by", [["subsystem", "Subsystem"], ["state", "State"]], "subsystem", (key) => ((this.by = key), (this.drawn = null), HL.repaint()), "share-by");
      this.body = el("div", { class: "s-sharebody" });
      this.blank = el("div", { class: "s-blank" });
      this.append(el("div", { class: "s-head" }, el("b", {}, "Time share"), this.sub, el("span", { class: "h-sp" }), this.look.node), this.body, this.blank);
      this.by = "subsystem";
    }

    paint() {
      const { data, problem } = HL.superTimes;
      const blank = !data ? problem || "Loading times" : data.share.length ? "" : "No time in states is on record yet.";
      text(this.blank, blank);
      attr(this.blank, "hidden", !blank);
      attr(this.body, "hidden", Boolean(blank));
      text(this.sub, HL.superTimes.word());
      attr(this, "data-state", data ? "shown" : problem ? "error" : "loading");
      if (!data || data === this.drawn) return;
      this.drawn = data;
      attr(this, "data-value", data.share.map((one) => `${one.subsystem}:${one.share}`).join(" "));
      if (this.by === "state") this.states(data);
      else this.ring(data);
    }

    ring(data) {
      const whole = percents(data.share.map((one) => one.share));
      let at = 0;
      const parts = data.share.map((one, i) => {
        const piece = svg("path", { d: arc(at, at + one.share), fill: isWaiting(one) ? "url(#s-hatch)" : tone(i), class: "s-slice" });
        at += one.share;
        return piece;
      });
      const hatch = svg("pattern", { id: "s-hatch", width: 6, height: 6, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" }, svg("rect", { width: 6, height: 6, class: "ground" }), svg("rect", { width: 2, height: 6, class: "ink" }));
      const big = svg("text", { class: "big", y: -2, "text-anchor": "middle" });
      const isMission = HL.superTimes.span === "mission";
      // the robot may have told of less than the span asked for: what is counted here is what it told
      big.textContent = HL.chartFacts.span(isMission ? data.wall_s : data.share.reduce((sum, one) => sum + one.s, 0));
      const small = svg("text", { class: "small", y: 17, "text-anchor": "middle" });
      small.textContent = isMission ? "in mission" : "recorded";
      this.body.replaceChildren(
        svg("svg", { class: "s-ring", viewBox: "-90 -90 180 180", role: "img", "aria-label": `Time by subsystem: ${data.share.map((one, i) => `${one.label} ${whole[i]} %`).join(", ")}` }, svg("defs", {}, hatch), ...parts, big, small),
        el("table", { class: "s-legend" }, el("tbody", {}, ...data.share.map((one, i) => {
          const sign = el("i", { class: isWaiting(one) ? "hatch" : "" });
          if (!isWaiting(one)) sign.style.background = tone(i);
          return el("tr", { title: HL.chartFacts.span(one.s) }, el("td", {}, sign), el("th", { scope: "row" }, one.label), el("td", { class: "num h-2" }, HL.chartFacts.span(one.s)), el("td", { class: "num h-b" }, `${whole[i]} %`));
        }))),
      );
    }

    states(data) {
      const rows = data.per_state.filter((one) => !data.resting.includes(one.state));
      const sum = rows.reduce((total, one) => total + one.total_s, 0) || 1;
      const most = Math.max(...rows.map((one) => one.total_s), 1);
      this.body.replaceChildren(el("table", { class: "s-legend s-bystate" }, el("tbody", {}, ...rows.map((one) => {
        const bar = el("i", { class: "bar" });
        bar.style.width = `${Math.max(1, (one.total_s / most) * 100).toFixed(1)}%`;
        return el("tr", {}, el("th", { scope: "row" }, one.label), el("td", { class: "wide" }, bar), el("td", { class: "num h-2" }, HL.chartFacts.span(one.total_s)), el("td", { class: "num h-b" }, `${Math.round((one.total_s / sum) * 100)} %`));
      }))));
    }
  }

  HL.superDefine("hl-super-share", SuperShare);
})();
