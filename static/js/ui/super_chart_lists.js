// The chart as lists: all states nested, for reading aloud; and the newest changes with cause and result.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, words } = HL;
  const MOST_MOVES = 50;
  const AGAIN_MS = 1000;

  class ChartTree {
    constructor(facts, open) {
      this.rows = new Map();
      const level = (parent) => {
        const kids = facts.kids(parent);
        return kids.length ? el("ul", { class: "s-tree" }, ...kids.map((state) => el("li", {}, this.row(state, open), level(state.id)))) : null;
      };
      this.node = el("div", { class: "s-treebox", "data-testid": "chart-tree" }, level(null));
    }
    row(state, open) {
      const time = el("span", { class: "time" });
      const node = el("button", { type: "button", class: "s-treerow", "data-id": state.id, onclick: () => open(state.id) }, el("span", { class: "dot", "aria-hidden": "true" }), el("span", { class: "name" }, state.label), state.kind === "simple" ? "" : el("span", { class: "h-t13 h-2" }, state.kind), el("span", { class: "h-sp" }), time);
      this.rows.set(state.id, { node, time });
      return node;
    }
    mark(states) {
      const active = new Set(states.map(([id]) => id));
      for (const [id, row] of this.rows) {
        toggle(row.node, "on", active.has(id));
        attr(row.node, "aria-current", active.has(id) ? "true" : null);
        if (!active.has(id)) (text(row.time, ""), toggle(row.node, "over", false));
      }
    }
    time(id, said, isOver) {
      const row = this.rows.get(id);
      if (!row) return;
      text(row.time, said);
      toggle(row.node, "over", isOver);
    }
  }

  // newest first, from the robot's record; asked again when something changed
  class ChartMoves {
    constructor(facts, open) {
      Object.assign(this, { facts, open });
      this.body = el("tbody", {});
      this.said = el("p", { class: "h-2 h-t14", role: "status" });
      this.node = el("div", { class: "s-moves", "data-testid": "chart-moves" }, el("table", { class: "h-table" }, el("thead", {}, el("tr", {}, ...["Time", "From", "To", "Cause", "Result", "Was in it"].map((word) => el("th", { scope: "col" }, word)))), this.body), this.said);
    }
    async load(last) {
      if (this.isAsked) return void (this.wants = last);
      this.isAsked = true;
      const answer = await HL.port.api("GET", `/robots/${HL.view.robot}/transitions?limit=${MOST_MOVES}`);
      if (answer.ok) this.fill(answer.data.transitions);
      else text(this.said, `The record did not load: ${answer.text}`);
      setTimeout(() => {
        this.isAsked = false;
        const again = this.wants;
        this.wants = undefined;
        if (again !== undefined && this.node.isConnected) this.load(again);
      }, AGAIN_MS);
    }
    fill(rows) {
      text(this.said, rows.length ? "" : "No change of state is on record yet.");
      const name = (id, label) => el("td", {}, this.facts.byId.has(id) ? el("button", { type: "button", class: "s-crumb", onclick: () => this.open(id) }, label) : label || "–");
      this.body.replaceChildren(...rows.map((one) => el("tr", {}, el("td", {}, words.wallSeconds(new Date(one.at))), name(one.source, one.source_label), name(one.target, one.target_label), el("td", {}, one.event || "–"), el("td", {}, one.result || "–"), el("td", {}, one.duration_s === null ? "–" : HL.chartFacts.span(one.duration_s)))));
    }
  }

  Object.assign(HL, { ChartTree, ChartMoves });
})();
