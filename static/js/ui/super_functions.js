// What it can do now: the tree of functions in two columns, why one is off or limited, and what turns it on.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, toggle, LiveElement, words } = HL;
  const WORDS = { on: "On", limited: "Limited", off: "Off" };
  const CONTINUED = 1.5; // what a name said again costs, and a little more: trees stay whole where they can
  const SIGNS = { on: "check", limited: "remove", off: "block" };

  const group = () => HL.port.inside(HL.view.robot).functions;

  // side by side, so that neither column is much longer; a large tree goes on in the second one below its name
  function columns(functions) {
    const height = (one) => (one.state === "on" ? 1 : 1.5);
    const total = functions.reduce((sum, one) => sum + height(one), 0);
    let best = [functions.length, total];
    let left = 0;
    functions.forEach((one, i) => {
      const right = total - left + (one.depth ? CONTINUED : 0);
      const worst = Math.max(left, right);
      if (i && one.depth < 2 && worst < best[1]) best = [i, worst];
      left += height(one);
    });
    return [functions.slice(0, best[0]), functions.slice(best[0])];
  }

  // "Rear camera lost for 41 s"
  function reason(one) {
    const { why, since } = one;
    if (!why || since === null || since === undefined) return why;
    const age = words.since(HL.port.age(since));
    const [first, more] = why.split(/(?=, and \d+ more$)/);
    return `${first} for ${age}${more ?? ""}`;
  }

  class Functions extends LiveElement {
    build() {
      this.sum = el("span", { class: "h-t13 h-2 sub" });
      this.note = el("div", { class: "s-say h-2 h-t14", role: "status" });
      this.left = el("ul");
      this.right = el("ul");
      this.hint = el("span");
      this.hintHead = el("b");
      this.hintLine = el("div", { class: "s-hint h-t13", "data-testid": "function-hint" }, icon("info", "m"), el("span", {}, this.hintHead, this.hint));
      this.rows = new Map();
      this.append(el("div", { class: "s-head" }, el("b", {}, "What it can do now"), this.sum), this.note, el("div", { class: "s-scroll" }, el("div", { class: "s-functions2" }, this.left, this.right)), this.hintLine);
    }
    paint() {
      const told = group();
      const functions = told?.functions ?? [];
      const said = HL.superNodes.notice(told === null ? null : told);
      text(this.note, said === "empty" ? `${HL.view.name()} does not tell what it can do.` : said);
      attr(this.note, "hidden", !said);
      toggle(this, "stale", Boolean(said) && functions.length > 0);
      text(this.sum, told ? `${told.on} of ${told.total} functions on` : "");
      this.place(functions);
      for (const one of functions) paintRow(this.rows.get(one.name), one);
      this.paintHint(told, functions);
    }
    place(functions) {
      const key = functions.map((one) => `${one.name}:${one.depth}:${one.state}`).join();
      if (key === this.placed) return;
      this.placed = key;
      for (const { name } of functions) if (!this.rows.has(name)) this.rows.set(name, row(name, () => this.choose(name)));
      const [left, right] = columns(functions);
      this.left.replaceChildren(...left.map((one) => this.rows.get(one.name).node));
      const root = right[0]?.depth ? left.findLast((one) => one.depth === 0) : null;
      this.right.replaceChildren(root ? el("li", { class: "cont h-t12 h-2", "data-state": "on" }, `${root.label}, continued`) : "", ...right.map((one) => this.rows.get(one.name).node));
    }
    choose(name) {
      this.chosen = this.chosen === name ? null : name;
      HL.repaint();
    }
    paintHint(told, functions) {
      const one = functions.find((fn) => fn.name === this.chosen && fn.state !== "on");
      const hint = one ? `To ${one.state === "off" ? "turn on" : "have all of"} ${one.label}: ${lower(one.turns_on)}.` : told?.hint ?? "";
      const at = hint.indexOf(": ") + 1;
      text(this.hintHead, hint.slice(0, at));
      text(this.hint, hint.slice(at));
      attr(this.hintLine, "hidden", !hint);
    }
  }

  const lower = (words) => (/^.[a-z]/.test(words) ? words[0].toLowerCase() + words.slice(1) : words);

  function row(name, choose) {
    const sign = el("span", { class: "sign" });
    const label = el("span", { class: "label" });
    const why = el("span", { class: "why h-t12 h-2" });
    const state = el("span", { class: "state h-t12" });
    const node = el("li", { "data-testid": `function-${name}`, onclick: choose, onkeydown: (event) => event.key === "Enter" && choose() }, sign, el("span", { class: "words" }, label, why), state);
    return { node, sign, label, why, state };
  }

  function paintRow(row, one) {
    attr(row.node, "data-state", one.state);
    attr(row.node, "data-depth", Math.min(one.depth, 4));
    attr(row.node, "tabindex", one.state === "on" ? null : 0);
    attr(row.node, "title", one.state === "on" ? null : one.turns_on);
    if (row.drawn !== `${one.state}|${one.level}`) {
      row.drawn = `${one.state}|${one.level}`;
      row.sign.replaceChildren(one.level && one.state === "off" ? alarm(one.level, 20) : icon(SIGNS[one.state], "m"));
    }
    text(row.label, one.label);
    text(row.why, reason(one));
    attr(row.why, "hidden", !one.why);
    text(row.state, WORDS[one.state]);
  }

  HL.superDefine("hl-super-functions", Functions);
  Object.assign(HL, { superFunctions: { columns, reason } });
})();
