// Steps of planning: each done one folds to a line with Change, the one at hand is open.
(() => {
  "use strict";
  const { el, icon, attr, text } = HL;

  class Step {
    constructor(number, title, hook, ...body) {
      this.number = number;
      this.mark = el("span", { class: "p-mark" });
      this.line = el("div", { class: "h-t13 h-2 h-ell" });
      this.change = el("button", { type: "button", class: "h-btn q p-change", "data-testid": `plan-change-${hook}`, "aria-label": `Change ${title.toLowerCase()}`, onclick: () => this.open() }, "Change");
      this.body = el("div", { class: "h-card p-body" }, ...body);
      this.node = el("section", { class: "p-step", "data-testid": `plan-step-${hook}`, "aria-label": title }, el("div", { class: "h-row p-head" }, this.mark, el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b" }, title), this.line), this.change), this.body);
      this.state = "open";
      this.paint();
    }

    open() {
      this.state = "open";
      this.paint();
      this.body.querySelector("input, select, button")?.focus({ preventScroll: true });
      this.node.scrollIntoView({ block: "nearest" });
    }

    fold(summary) {
      this.state = "done";
      this.tell(summary);
    }

    tell(summary) {
      text(this.line, summary);
      this.paint();
    }

    paint() {
      attr(this.node, "data-state", this.state);
      this.mark.replaceChildren(this.state === "done" ? icon("check", "m") : String(this.number));
      this.body.hidden = this.state !== "open" || !this.body.childNodes.length;
      this.change.hidden = this.state !== "done";
    }
  }

  HL.planner.Step = Step;
})();
