// Change the shape in hand: grow or shrink, straighten, simplify, turn. What comes out is shown before it is done.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const WAIT_MS = 220; // after the last digit or drag

  // what a person enters for each; corners are counted from 1
  const WAYS = {
    grow: { word: "Grow", op: "buffer", label: "By", unit: "m", start: 1, step: 0.5, least: 0.01, most: 1000, digits: 2, args: (value) => ({ distance_m: value }) },
    inset: { word: "Inset", op: "buffer", label: "By", unit: "m", start: 1, step: 0.5, least: 0.01, most: 1000, digits: 2, args: (value) => ({ distance_m: -value }) },
    straighten: { word: "Straighten", op: "straighten_all", label: "Edges that turn less than", unit: "°", start: 4, step: 1, least: 0.1, most: 20, digits: 1, args: (value) => ({ within_deg: value }) },
    simplify: { word: "Simplify", op: "simplify", label: "Edge may be off by", unit: "m", start: 0.1, step: 0.05, least: 0.01, most: 50, digits: 2, args: (value) => ({ tolerance_m: value }) },
    turn: { word: "Turn", op: "turn", label: "Clockwise", unit: "°", start: 0, step: 0.5, least: -180, most: 180, digits: 1, args: (value) => ({ angle_deg: value }) },
  };
  const isPoint = (feature) => feature?.geometry.type === "Point";
  const waysOf = (feature) => (isPoint(feature) ? ["grow", "inset"] : feature?.geometry.type === "Polygon" ? Object.keys(WAYS) : ["straighten", "simplify", "turn"]);
  const canReshape = (feature) => !isPoint(feature) || M.kindOf(feature) === "obstacle";
  const metres = (m) => (m < 1 ? `${m.toFixed(2)} m` : `${m.toFixed(1)} m`);

  // act: {trial(op, ids, args) -> Promise(answer), operate(op, ids, args, label) -> Promise(answer), show(features), turning(degrees or null), unlock(isOn), isUnlocked()}
  class Reshape {
    constructor(act) {
      this.act = act;
      this.id = null;
      this.ways = el("div", { class: "h-seg m-ways", role: "radiogroup", "aria-label": "How" });
      this.label = el("span", { class: "m-label" });
      this.value = el("input", { class: "h-input", inputmode: "decimal", autocomplete: "off", "data-testid": "reshape-value", oninput: () => this.typed(), onkeydown: (event) => event.key === "Enter" && this.apply() });
      this.unit = el("span", { class: "m-unit" });
      const step = (hook, word, sign) => el("button", { type: "button", class: "h-btn ico m-step", "data-testid": hook, "aria-label": word, onclick: () => this.stepBy(sign) }, sign < 0 ? "−" : icon("add", "m"));
      this.row = el("div", { class: "m-stepper" }, step("reshape-less", "Less", -1), el("span", { class: "m-inp" }, this.value, this.unit), step("reshape-more", "More", 1));
      this.from = this.cornerInput("reshape-from", "From corner");
      this.to = this.cornerInput("reshape-to", "To corner");
      this.one = el("input", { type: "checkbox", "data-testid": "reshape-one-edge", onchange: () => this.look() });
      this.edge = el("div", { class: "m-edge" }, el("label", { class: "h-check" }, this.one, "Only one edge"), el("div", { class: "m-form" }, this.from.node, this.to.node), el("div", { class: "h-t13 h-2" }, "Or tap its two corners on the map."));
      this.lock = el("div", { class: "h-row m-lockline" }, icon("lock", "m"), el("span", { class: "h-sp" }, "The whole shape is locked."), el("button", { type: "button", class: "h-btn", "data-testid": "reshape-unlock", onclick: () => (act.unlock(true), this.look()) }, icon("lock_open", "m"), "Unlock"));
      this.said = el("div", { class: "h-t14 h-b m-effect", role: "status", "data-testid": "reshape-effect" });
      this.go = el("button", { type: "button", class: "h-btn pri", "data-testid": "reshape-apply", onclick: () => this.apply() }, "Apply");
      this.node = el("section", { class: "m-reshape h-card", hidden: true, "data-testid": "reshape", "aria-label": "Change shape" },
        el("div", { class: "h-row" }, el("h3", { class: "h-t16 h-b h-sp" }, "Change shape"), el("button", { type: "button", class: "h-btn", "data-testid": "reshape-close", onclick: () => this.close() }, "Cancel")),
        this.ways, el("label", { class: "h-field m-value" }, this.label, this.row), this.edge, this.lock, this.said, this.go);
    }

    cornerInput(hook, word) {
      const control = el("input", { class: "h-input", inputmode: "numeric", autocomplete: "off", "data-testid": hook, oninput: () => { this.one.checked = true; this.typed(); } });
      return { control, node: el("label", { class: "h-field" }, el("span", { class: "m-label" }, word), control) };
    }

    get isOpen() {
      return this.id !== null;
    }

    open(id, feature) {
      [this.id, this.feature] = [id, feature];
      this.picked = 0;
      this.one.checked = false;
      const names = waysOf(feature);
      this.ways.replaceChildren(...names.map((name) => el("button", { type: "button", role: "radio", "data-way": name, "data-testid": `reshape-${name}`, onclick: () => this.choose(name) }, WAYS[name].word)));
      attr(this.node, "hidden", null);
      this.choose(names[0]);
      this.node.scrollIntoView({ block: "nearest" });
    }

    close() {
      clearTimeout(this.timer);
      if (this.id === null) return;
      this.id = null;
      this.turn = (this.turn ?? 0) + 1;
      attr(this.node, "hidden", true);
      this.act.show([]);
      this.act.turning(null);
    }

    choose(name) {
      this.way = name;
      const way = WAYS[name];
      for (const button of this.ways.children) attr(button, "aria-checked", String(button.dataset.way === name));
      text(this.label, way.label);
      text(this.unit, way.unit);
      this.value.value = String(way.start);
      attr(this.edge, "hidden", name !== "straighten");
      this.look();
    }

    number() {
      const way = WAYS[this.way];
      const value = Number(this.value.value.replace(",", "."));
      return this.value.value.trim() !== "" && value >= way.least && value <= way.most ? value : null;
    }

    stepBy(sign) {
      const way = WAYS[this.way];
      const value = Math.min(way.most, Math.max(way.least, (this.number() ?? way.start) + sign * way.step));
      this.value.value = String(Number(value.toFixed(way.digits)));
      this.typed();
    }

    typed() {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.look(), WAIT_MS);
    }

    // the dial on the map was dragged
    turned(degrees) {
      if (this.way !== "turn" || !this.isOpen) return;
      this.value.value = String(degrees);
      this.typed();
    }

    // a corner was tapped: the first is where the edge begins, the second where it ends
    corner(index) {
      if (!this.isOpen || this.way !== "straighten" || index === null) return;
      (this.picked % 2 ? this.to : this.from).control.value = String(index + 1);
      this.picked += 1;
      this.one.checked = true;
      this.typed();
    }

    // {op, args}, or {why} while something is missing
    wish() {
      const way = WAYS[this.way];
      if (this.way === "straighten" && this.one.checked) {
        const [from, to] = [this.from, this.to].map((one) => Number.parseInt(one.control.value, 10));
        return from >= 1 && to >= 1 ? { op: "straighten", args: { from: from - 1, to: to - 1 } } : { why: "Enter or tap the corners where the edge begins and ends." };
      }
      const value = this.number();
      if (value === null) return { why: `${way.label}: ${way.least} to ${way.most} ${way.unit}` };
      return value === 0 ? { why: "Drag the arrow on the map, or enter degrees." } : { op: way.op, args: way.args(value) };
    }

    async look() {
      clearTimeout(this.timer);
      if (!this.isOpen) return;
      const isLocked = this.way === "turn" && !this.act.isUnlocked();
      attr(this.lock, "hidden", !isLocked);
      attr(this.value, "disabled", isLocked);
      this.act.turning(this.way === "turn" && !isLocked ? (this.number() ?? 0) : null);
      this.turn = (this.turn ?? 0) + 1;
      const { turn } = this;
      const wish = this.wish();
      attr(this.go, "disabled", true);
      if (isLocked || wish.why) return this.tell(isLocked ? "" : wish.why, []);
      const answer = await this.act.trial(wish.op, [this.id], wish.args);
      if (turn !== this.turn || !this.isOpen) return undefined;
      if (!answer.ok) return this.tell(answer.text || "The server did not answer. Try again.", []);
      if (answer.refused) return this.tell(answer.refused.text, []);
      attr(this.go, "disabled", null);
      return this.tell(this.words(answer.effect), answer.changes.map((one) => one.after).filter(Boolean));
    }

    tell(words, features) {
      text(this.said, words);
      attr(this.said, "hidden", !words);
      this.act.show(features);
    }

    words(effect) {
      const { corners_before: before, corners_after: after, area_before_m2: was, area_after_m2: is, off_m: off, pieces } = effect;
      if (this.way === "turn") return `Turned by ${Math.abs(this.number())}° ${this.number() > 0 ? "clockwise" : "counter-clockwise"}`;
      if (this.way === "simplify" || this.way === "straighten") return `${after} of ${M.count(before, "corner")} stay, at most ${metres(off ?? 0)} off`;
      const parts = pieces > 1 ? `, in ${pieces} pieces` : "";
      return `${M.words(M.area(was))} to ${M.words(M.area(is))}${parts}`;
    }

    async apply() {
      const wish = this.wish();
      if (wish.why || !this.isOpen || this.go.disabled) return;
      attr(this.go, "disabled", true);
      const { id } = this;
      const answer = await this.act.operate(wish.op, [id], wish.args, "Change shape");
      if (answer.ok && this.id === id) this.close();
      else attr(this.go, "disabled", null);
    }
  }

  Object.assign(HL.maps, { Reshape, canReshape });
})();
