// State durations: a row for each region and subsystem, live; or as a table with the usual time beside the real one.
(() => {
  "use strict";
  const { el, icon, svg, text, attr, toggle, LiveElement, words } = HL;
  const LEFT = 118, RIGHT = 16, MOST_ROW = 40, LEAST_ROW = 28, FOOT = 26, TOP = 4;
  const REDRAW_MS = { 10: 1000, 60: 5000, mission: 5000 }; // about a pixel

  class SuperGantt extends LiveElement {
    build() {
      this.sub = el("span", { class: "sub h-t14 h-2 h-ell" });
      this.look = HL.superSeg("Show as", [["bars", "Bars"], ["table", "Table"]], "bars", (key) => this.show(key), "gantt-look");
      this.span = HL.superSeg("Time", [["10", "10 min"], ["60", "1 h"], ["mission", "Mission"]], HL.superTimes.span, (key) => HL.superTimes.choose(key), "gantt-span");
      this.save = el("button", { type: "button", class: "h-btn ico", "aria-label": "Take it away", title: "Take it away", "data-testid": "gantt-export", onclick: () => this.offer() }, icon("download"));
      this.drawing = svg("svg", { class: "s-gantt-drawing", role: "img" });
      this.stage = el("div", { class: "s-ganttstage" }, this.drawing);
      this.list = el("div", { class: "s-lists", hidden: true });
      this.blank = el("div", { class: "s-blank" });
      this.append(el("div", { class: "s-head wrap" }, el("b", {}, "State durations"), this.sub, el("span", { class: "h-sp" }), this.look.node, this.span.node, this.save), this.stage, this.list, this.blank);
      this.drawing.addEventListener("click", (event) => {
        const state = event.target.closest?.("[data-state]")?.dataset.state;
        if (state && HL.superChart?.facts?.byId.has(state)) HL.superChart.open(state);
      });
      this.view = "bars";
    }

    enter() {
      HL.superTimes.begin(HL.view.robot, this.closest("hl-screen").dataset.mission);
      this.span.mark(HL.superTimes.span);
      this.drawnAt = -Infinity;
      this.seen = HL.ganttRows.memory();
      this.resized = new ResizeObserver(() => (this.drawnAt = -Infinity));
      this.resized.observe(this.stage);
    }

    leave() {
      this.resized.disconnect();
    }

    show(key) {
      this.view = key;
      attr(this.stage, "hidden", key !== "bars");
      attr(this.list, "hidden", key !== "table");
      this.drawnAt = -Infinity;
      HL.repaint();
    }

    paint() {
      const times = HL.superTimes;
      times.refresh();
      const { data } = times;
      const { active } = HL.port.inside(HL.view.robot);
      if (active) HL.ganttRows.follow(this.seen, active);
      attr(this.save, "disabled", !data);
      attr(this, "data-state", data ? "shown" : times.problem ? "error" : "loading");
      const blank = data ? (data.intervals.length || active?.states.length ? "" : "No change of state is on record for this time.") : times.problem || "Loading durations";
      text(this.blank, blank);
      attr(this.blank, "hidden", !blank);
      if (!data) {
        this.drawing.replaceChildren();
        this.drawnData = null;
        this.drawnAt = -Infinity;
        return;
      }
      const now = performance.now();
      if (data === this.drawnData && now - this.drawnAt < REDRAW_MS[HL.superTimes.span]) return;
      this.drawnAt = now;
      this.drawnData = data;
      if (this.view === "bars") this.draw(data);
      else this.table(data);
      this.words(data);
    }

    // what is shown: from when to when, and the stays, carried on to now while it is live
    scene(data) {
      const isLive = HL.superTimes.isLive();
      const { active } = HL.port.inside(HL.view.robot);
      const ageMs = active ? HL.port.age(active.t) : Infinity;
      const isFresh = isLive && ageMs <= HL.STALE_MS;
      const now = data.now + HL.port.age(data.now_m);
      const end = isLive ? (isFresh ? now : Math.max(data.to, active ? now - ageMs : data.to)) : data.to;
      const start = HL.superTimes.span === "mission" ? data.from : end - (data.to - data.from > 0 ? HL.superTimes.span * 60000 : 1);
      const since = HL.ganttRows.onRecord(this.seen, data);
      return { start, end, isLive, intervals: HL.ganttRows.withActive(data.intervals, HL.superChart?.facts, isLive && active ? since.active : null, since.ended) };
    }

    draw(data) {
      const { width, height: room } = this.stage.getBoundingClientRect();
      if (width < 100) return;
      const scene = this.scene(data);
      this.end = scene.end;
      const wide = width - LEFT - RIGHT;
      const rows = HL.ganttRows.rows(scene.intervals, HL.superChart?.facts, data.resting ?? [], { ...scene, width: wide });
      HL.style(this.closest("section") ?? this, "--lanes", String(rows.length)); // on a tablet the card is as high as it has lanes
      const high = Math.max(LEAST_ROW, Math.min(MOST_ROW, Math.floor((room - TOP - FOOT) / Math.max(1, rows.length))));
      const height = TOP + rows.length * high + FOOT;
      for (const [name, value] of [["width", width], ["height", height], ["viewBox", `0 0 ${width} ${height}`], ["aria-label", this.said(rows)]]) attr(this.drawing, name, value);
      const x = (at) => LEFT + ((at - scene.start) / (scene.end - scene.start)) * wide;
      const drawn = svg("svg", {}, ...this.axisLines(scene, x, height, width), ...rows.map((row, i) => this.row(row, TOP + i * high, width, high)));
      if (scene.isLive) drawn.append(svg("path", { class: "s-now", "data-key": "now", d: `M${width - RIGHT} 0V${height - FOOT}` }));
      HL.svgInto(this.drawing, drawn); // what is under a finger or the mouse stays the same node
    }

    // words that would run into each other are left out
    axisLines(scene, x, height, width) {
      let free = Infinity;
      const marks = HL.ganttRows.axis(scene.start, scene.end, scene.isLive, (at) => words.wall(new Date(at)));
      const newest = scene.isLive ? marks : marks.toReversed();
      return newest.map(([at, word], i) => {
        const fits = free - x(at) > (i > 1 ? 64 : 46);
        if (fits) free = x(at);
        return this.axisLine(x(at), fits ? word : "", height, width);
      });
    }

    axisLine(x, word, height, width) {
      const anchor = x > width - 40 ? "end" : x < LEFT + 30 ? "start" : "middle";
      const label = svg("text", { class: "s-axis", x, y: height - 8, "text-anchor": anchor });
      label.textContent = word;
      return svg("g", { "data-key": "axis" }, svg("path", { class: "s-axisline", d: `M${x} 0V${height - FOOT}` }), label);
    }

    row({ lane, bars }, y, width, high) {
      const name = svg("text", { class: "s-lane", "data-key": "name", x: 14, y: y + high / 2 + 3 });
      name.textContent = lane;
      return svg("g", { "data-key": `lane ${lane}` }, svg("path", { class: "s-laneline", "data-key": "line", d: `M0 ${y + high - 2}H${width}` }), ...bars.map((bar) => this.bar(bar, y + 4, high - 11)), svg("rect", { class: "s-lanemask", "data-key": "mask", x: 0, y, width: LEFT - 2, height: high - 3 }), name);
    }

    bar({ key, x, w, tone, label, isOver, isOpen, planned, one }, y, high) {
      const node = svg("g", { class: `s-bar t${tone}${isOver ? " over" : ""}${isOpen ? " open" : ""}`, "data-key": key, "data-state": one.state });
      node.append(svg("rect", { x: (LEFT + x).toFixed(1), y, width: w.toFixed(1), height: high, rx: 2 }));
      if (planned !== null && (isOver || w > 40)) node.append(svg("path", { class: "planned", d: `M${(LEFT + planned).toFixed(1)} ${y}v${high}` }));
      const said = isOver && one.normal_s ? `${label}: ${HL.chartFacts.span(((one.end ?? this.end) - one.start) / 1000)}, normal ${HL.chartFacts.span(one.normal_s)}` : label;
      const fits = [said, label].find((word) => word && w > word.length * 6.9 + 10);
      if (fits) {
        const written = svg("text", { x: (LEFT + x + 6).toFixed(1), y: y + high / 2 + 4 });
        written.textContent = fits;
        node.append(written);
      }
      const title = svg("title", {});
      title.textContent = `${label}, ${words.wallSeconds(new Date(one.start))}, ${one.end === null ? "still active" : HL.chartFacts.span((one.end - one.start) / 1000)}${one.result ? `, ${one.result}` : ""}${one.is_guessed ? ", end not told" : ""}`;
      node.append(title);
      return node;
    }

    said(rows) {
      return `State durations, ${HL.superTimes.word()}. ${rows.map((row) => `${row.lane}: ${row.bars.length}`).join(", ")}. The table says the same in numbers.`;
    }

    // the state that lasts longest beyond its usual time, in the line above
    words(data) {
      const { active } = HL.port.inside(HL.view.robot);
      const facts = HL.superChart?.facts;
      let worst = null;
      if (HL.superTimes.isLive() && active && facts) {
        for (const [id, since] of active.states) {
          const state = facts.byId.get(id);
          const s = HL.chartFacts.seconds(since, active.t, HL.port.age(active.t), HL.STALE_MS);
          if (state && HL.chartFacts.isOver(state.normal_s, s) && (!worst || s / state.normal_s > worst.s / worst.state.normal_s)) worst = { state, s };
        }
      }
      const mean = worst && data.per_state.find((one) => one.state === worst.state.id)?.mean_s;
      const drifting = data.per_state.filter((one) => one.is_drifting);
      const more = worst
        ? `. ${worst.state.label} has run ${words.clock(worst.s)}, ${mean ? `its mean is ${HL.chartFacts.span(mean)}` : `normal is ${HL.chartFacts.span(worst.state.normal_s)}`}`
        : drifting.length ? `. ${drifting[0].label} takes ${HL.chartFacts.span(drifting[0].mean_s)}, normal ${HL.chartFacts.span(drifting[0].normal_s)}` : "";
      const count = (number) => number.toLocaleString("en-GB");
      const thinned = data.is_thinned ? `, the ${count(data.intervals.length)} longest of ${count(data.stays)} stays; the table has all` : "";
      text(this.sub, `${HL.superTimes.word()}${thinned}${more}`);
      attr(this.sub, "title", this.sub.textContent);
    }

    table(data) {
      const on = new Set(data.intervals.filter((one) => one.end === null).map((one) => one.state)); // counts in the total, not in the mean
      const drift = (one) => (one.drift === null ? "–" : `${one.drift > 0 ? "+" : "−"}${Math.abs(Math.round(one.drift * 100))} %`);
      const cell = (value) => el("td", { class: "num" }, value === null || value === undefined ? "–" : HL.chartFacts.span(value));
      this.list.replaceChildren(
        el("table", { class: "h-table s-times", "data-testid": "gantt-table" },
          el("thead", {}, el("tr", {}, ...["State", "Subsystem", "Times", "Total", "Mean", "Longest", "Normal", "Drift"].map((word, i) => el("th", { scope: "col", class: i > 1 ? "num" : "" }, word)))),
          el("tbody", {}, ...data.per_state.map((one) => el("tr", { "data-drift": one.is_drifting ? "yes" : null }, el("th", { scope: "row" }, one.label), el("td", {}, one.subsystem || "–"), el("td", { class: "num" }, on.has(one.state) ? `${one.count} + now` : String(one.count)), cell(one.total_s), cell(one.mean_s), cell(one.longest_s), cell(one.normal_s), el("td", { class: "num" }, one.is_drifting ? icon("warning", "s") : "", drift(one)))))),
        el("p", { class: "h-2 h-t14" }, `Sum of states ${HL.chartFacts.span(data.total_s)}, time by the clock ${HL.chartFacts.span(data.wall_s)}. Regions run at once, and a region that rests is not counted.`),
      );
    }

    offer() {
      const name = `state-times-${HL.view.robot}`;
      const png = async (close) => {
        close();
        if (this.view !== "bars") (this.look.choose("bars"), this.paint());
        const blob = await HL.superExport.png(this.drawing, `${HL.view.name()}, state durations, ${HL.superTimes.word()}, ${words.wallSeconds(new Date())}`);
        HL.superExport.save(blob, `${name}.png`);
      };
      const csv = (close) => {
        close();
        const link = el("a", { href: HL.superTimes.csvUrl(), download: `${name}.csv` });
        document.body.append(link);
        link.click();
        link.remove();
      };
      HL.sheet({ title: "Take the durations away", hook: "gantt-export-sheet", body: [el("p", { class: "h-2 h-t16" }, `What is shown now: ${HL.superTimes.word()}. The table has every stay with start, end and result.`)], buttons: [["Cancel", (close) => close()], ["Picture (PNG)", png], ["Table (CSV)", csv, true]] });
    }
  }

  HL.superDefine("hl-super-gantt", SuperGantt);
})();
