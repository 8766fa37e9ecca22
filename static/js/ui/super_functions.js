// What it can do now: the tree of functions in two columns, why one is off or limited, and what turns it on.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, toggle, LiveElement, words } = HL;
  const WORDS = { on: "On", limited: "Limited", off: "Off" };
  const SIGNS = { on: "check", limited: "remove", off: "block" };

  const group = () => HL.port.inside(HL.view.robot).functions;

  // whole trees side by side, so that neither column is much longer; what is off takes two lines
  function columns(functions) {
    const trees = [];
    for (const one of functions) {
      if (one.depth === 0 || !trees.length) trees.push([]);
      trees[trees.length - 1].push(one);
    }
    const height = (tree) => tree.reduce((sum, one) => sum + (one.state === "on" ? 1 : 1.5), 0);
    const total = trees.reduce((sum, tree) => sum + height(tree), 0);
    let best = [1, Infinity];
    let left = 0;
    trees.forEach((tree, i) => {
      left += height(tree);
      const worst = Math.max(left, total - left);
      if (worst < best[1]) best = [i + 1, worst];
    });
    return [trees.slice(0, best[0]).flat(), trees.slice(best[0]).flat()];
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
      this.right.replaceChildren(...right.map((one) => this.rows.get(one.name).node));
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
