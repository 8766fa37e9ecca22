// The live state chart: laid out once, then only what is active, since when, and the last change are written.
(() => {
  "use strict";
  const { el, icon, svg, text, attr, toggle, LiveElement, words } = HL;
  const RETRY_MS = 5000;
  const OTHER_SHAPE = 0.3;
  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const NO_CHART = "This robot sends no chart";

  class SuperChart extends LiveElement {
    build() {
      this.classList.add("s-charthost");
      this.path = el("div", { class: "s-crumbs sub", role: "navigation", "aria-label": "Active states" });
      this.age = el("span", { class: "h-age" });
      this.tabs = HL.superSeg("View", [["chart", "Chart"], ["tree", "Tree"], ["moves", "Transitions"]], "chart", (key) => this.tab(key), "chart-tab");
      this.full = el("button", { type: "button", class: "h-btn ico", "data-testid": "chart-full", "aria-pressed": "false", "aria-label": "Whole window", onclick: () => this.whole() }, icon("fullscreen"));
      this.root = svg("svg", { class: "s-drawing", role: "group", "aria-label": "State chart. Arrow keys move, Enter opens a state." });
      this.view = new HL.SuperView(this.root, (target) => this.tapped(target));
      this.view.isFull = () => this.isFull;
      this.note = el("div", { class: "s-note", role: "status", hidden: true });
      this.stage = el("div", { class: "s-stage" }, this.root);
      this.lists = el("div", { class: "s-lists", hidden: true });
      this.blank = el("div", { class: "s-blank" });
      this.zooms = this.view.buttons();
      this.append(el("div", { class: "s-head wrap" }, el("b", {}, "State"), this.path, el("span", { class: "h-sp" }), this.age, el("div", { class: "h-row s-tools" }, this.tabs.node, el("span", { class: "h-sp" }), this.zooms, this.full)), this.note, this.stage, this.lists, this.blank);
      this.root.addEventListener("focusin", (event) => this.drawing?.near(event.target.closest?.("[data-id]")?.dataset.id));
      this.root.addEventListener("keydown", (event) => this.key(event));
      this.shown = "chart";
      HL.superChart = this;
    }

    enter() {
      this.resized = new ResizeObserver(() => this.lay());
      this.resized.observe(this.stage);
      this.onKey = (event) => event.key === "Escape" && this.isFull && !document.querySelector(".h-scrim") && this.whole();
      window.addEventListener("keydown", this.onKey);
    }

    leave() {
      this.resized.disconnect();
      clearTimeout(this.layTimer);
      window.removeEventListener("keydown", this.onKey);
      if (this.isFull) this.whole();
    }

    // ---- the chart itself

    async load(hash) {
      if (this.isLoading || performance.now() < (this.retryAt ?? 0)) return;
      this.isLoading = true;
      const answer = await HL.port.api("GET", `/robots/${HL.view.robot}/chart`);
      this.isLoading = false;
      this.retryAt = performance.now() + RETRY_MS;
      if (!answer.ok) return void (this.problem = answer.status === 404 ? "" : answer.text);
      this.problem = "";
      this.take({ hash: answer.hash ?? hash, states: answer.data.states, transitions: answer.data.transitions });
    }

    take(chart) {
      this.chart = chart;
      this.facts = HL.chartFacts.index(chart);
      this.layoutKey = "";
      this.tree = new HL.ChartTree(this.facts, (id) => this.open(id));
      this.moves = new HL.ChartMoves(this.facts, (id) => this.open(id));
      this.lay();
      this.tab(this.shown);
    }

    lay() {
      const { width, height } = this.stage.getBoundingClientRect();
      if (!this.chart || width < 50 || height < 50) return;
      // a scroll bar or a line of text more is no other shape: the states stay where they are
      const shape = Math.log(width / height);
      if (this.layoutKey && Math.abs(shape - this.laidShape) < OTHER_SHAPE) return;
      this.laidShape = shape;
      const isCurrent = () => key === this.layoutKey;
      const { key, layout } = HL.chartLayouts.of(this.chart, { w: width, h: height }, (placed) => isCurrent() && this.draw(placed));
      if (isCurrent()) return;
      this.layoutKey = key;
      layout.then((done) => isCurrent() && this.connect(done), (error) => isCurrent() && this.failed(error));
    }

    // a worker that did not load may load the next time
    failed(error) {
      this.problem = `The chart could not be laid out: ${error.message}`;
      this.layoutKey = "";
      this.layTimer = setTimeout(() => this.lay(), RETRY_MS);
      HL.repaint();
    }

    draw(layout) {
      this.root.replaceChildren();
      this.drawing = new HL.ChartDrawing(this.root, this.facts, layout);
      this.view.fit([layout.w, layout.h]);
      this.marked = null;
      this.focusOn(this.focused && this.drawing.nodes.has(this.focused) ? this.focused : [...this.drawing.nodes.keys()][0], false);
      HL.repaint();
    }

    // lines that came after the states; without states drawn before, both
    connect(layout) {
      this.problem = "";
      if (!this.drawing?.connect(layout)) return void this.draw(layout);
      this.marked = null;
      HL.repaint();
    }

    // ---- what a person does

    tab(key) {
      this.shown = key;
      attr(this.stage, "hidden", key !== "chart");
      attr(this.lists, "hidden", key === "chart");
      attr(this.zooms, "hidden", key !== "chart");
      if (key === "tree") this.lists.replaceChildren(this.tree?.node ?? "");
      if (key === "moves") this.lists.replaceChildren(this.moves?.node ?? "");
      this.marked = null;
      HL.repaint();
    }

    whole() {
      this.isFull = !this.isFull;
      toggle(this.closest("section"), "s-whole", this.isFull);
      attr(this.full, "aria-pressed", String(this.isFull));
      attr(this.full, "aria-label", this.isFull ? "Back to the screen" : "Whole window");
      this.full.replaceChildren(this.isFull ? icon("fullscreen_exit") : icon("fullscreen"));
    }

    tapped(target) {
      const id = target?.closest?.("[data-id]")?.dataset.id;
      if (!id) return;
      this.focusOn(id, true);
      this.open(id);
    }

    open(id) {
      HL.stateSheet(this.chart, this.facts, id, HL.port.inside(HL.view.robot).active);
    }

    key(event) {
      if (!this.focused || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.key in ARROWS) this.focusOn(this.drawing.beside(this.focused, ...ARROWS[event.key]), true);
      else if (event.key === "Enter" || event.key === " ") this.open(this.focused);
      else if (event.key === "+" || event.key === "=") this.view.zoom(0.66);
      else if (event.key === "-") this.view.zoom(1.5);
      else if (event.key === "0") this.view.fit();
      else return;
      event.preventDefault();
    }

    focusOn(id, isReal) {
      const node = this.drawing.nodes.get(id);
      if (!node) return;
      this.drawing.nodes.get(this.focused)?.group.setAttribute("tabindex", "-1");
      node.group.setAttribute("tabindex", "0");
      this.focused = id;
      if (isReal) {
        node.group.focus({ preventScroll: true });
        this.view.show(node);
      }
    }

    // ---- what is so now

    paint() {
      const { active, chart } = HL.port.inside(HL.view.robot);
      const { supervisor, link } = HL.port.robot(HL.view.robot);
      if (chart?.hash && chart.hash !== this.chart?.hash) this.load(chart.hash);
      const t = active?.t ?? supervisor?.t ?? null;
      const ageMs = t === null ? Infinity : HL.port.age(t);
      const isStale = ageMs > HL.STALE_MS;
      toggle(this, "stale", isStale && t !== null);
      text(this.age, t === null ? "" : `data ${words.age(ageMs)} old`);
      attr(this, "data-age-ms", Number.isFinite(ageMs) ? Math.round(ageMs) : null);
      this.say(t, ageMs, link, chart);
      if (this.chart && active) this.mark(active, ageMs, supervisor?.path ?? []);
      else this.bare(supervisor);
    }

    // the states a screen can be in besides its usual one; in words
    say(t, ageMs, link, chart) {
      const isOff = t !== null && link?.is_off;
      const last = t === null ? "" : `${this.lastName ?? "unknown"}, ${words.wall(HL.wallOf(t))}`;
      const note = isOff ? `Robot is off. Last state: ${last}` : t !== null && ageMs > HL.STALE_MS ? `State data stopped ${words.since(ageMs)} ago` : "";
      text(this.note, note);
      attr(this.note, "hidden", !note);
      const blank = this.problem ? this.problem : t === null ? "Waiting for first state" : this.chart ? (this.drawing || this.shown !== "chart" ? "" : "Drawing the chart") : chart === null ? NO_CHART : chart === undefined ? "Waiting for its chart" : "Loading its chart";
      if (blank !== this.blankText) {
        this.blankText = blank;
        this.blank.replaceChildren(blank ? el("b", { class: "h-t18 h-b" }, blank) : "", this.bareLine ?? "");
      }
      attr(this.blank, "hidden", !blank);
      attr(this.root, "aria-hidden", blank ? "true" : null);
    }

    mark(active, ageMs, told) {
      const key = JSON.stringify([active.states, active.last, told]);
      if (key !== this.marked) {
        this.marked = key;
        const last = active.last && { ...active.last, wall: words.wallSeconds(HL.wallOf(active.last.at)) };
        this.drawing?.mark(active.states, last);
        attr(this, "data-state", active.states.map(([id]) => this.facts.byId.get(id)?.label ?? id).join(", "));
        attr(this, "data-active", active.states.map(([id]) => id).join(" "));
        this.crumbs(active, told);
        if (this.shown === "tree") this.tree.mark(active.states);
        if (this.shown === "moves") this.moves.load(active.last);
      }
      for (const [id, since] of active.states) {
        const state = this.facts.byId.get(id);
        if (!state) continue;
        const s = HL.chartFacts.seconds(since, active.t, ageMs, HL.STALE_MS);
        const isOver = HL.chartFacts.isOver(state.normal_s, s);
        const said = isOver ? `${words.clock(s)}, normal ${HL.chartFacts.span(state.normal_s)}` : words.clock(s);
        this.drawing?.time(id, said, isOver);
        if (this.shown === "tree") this.tree.time(id, said, isOver);
      }
    }

    crumbs(active, told) {
      if (!active.states.some(([id]) => this.facts.byId.has(id))) return this.unknown(active, told);
      const trail = HL.chartFacts.crumbs(this.facts, active.states, active.last).filter((one) => one.kind !== "region");
      this.lastName = trail.at(-1)?.label;
      this.path.replaceChildren(...trail.flatMap((one, i) => [i ? icon("chevron_right", "s") : "", el("button", { type: "button", class: "s-crumb", onclick: () => this.open(one.id) }, one.label)]));
    }

    // its states are not in the chart it sent, or it names none: nothing is lit, and that is said
    unknown({ states }, told) {
      const said = told.length ? told : states.map(([id]) => id);
      this.lastName = said.at(-1);
      this.path.replaceChildren(el("span", {}, said.length ? `It says: ${said.join(", ")}. Its chart has no such state.` : "It does not say in which state it is."));
    }

    // a robot without a chart: its path in words
    bare(supervisor) {
      const said = supervisor?.path?.join(", ") ?? "";
      if (said === this.marked) return;
      this.marked = said;
      this.lastName = supervisor?.path?.at(-1);
      attr(this, "data-state", said);
      this.bareLine = said ? el("span", { class: "h-2 h-t16" }, `It says: ${said}`) : null;
      this.blankText = undefined;
      text(this.path, said);
    }
  }

  HL.superDefine("hl-super-chart", SuperChart);
})();
