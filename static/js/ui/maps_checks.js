// What is wrong with the draft: what blocks publishing, what is to look at, each with a way to mend or see it.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr } = HL;
  const { count } = HL.maps;
  const ROBOT = "headland.map.robot";

  class Checks {
    // act: {fix(finding), show(finding), robot(): another machine was chosen}
    constructor(act) {
      this.act = act;
      this.sum = el("span", { class: "h-row h-t13 h-b m-sum", role: "status" });
      this.list = el("div", { class: "m-findings" });
      this.machine = el("select", { class: "h-select m-machine", "data-testid": "checks-robot", "aria-label": "Wide enough for", onchange: () => this.choose() });
      this.node = el("section", { class: "m-checks", "data-testid": "editor-checks", "aria-label": "Checks" }, el("div", { class: "h-row" }, el("h3", { class: "h-t16 h-b" }, "Checks"), this.sum), this.list, el("label", { class: "h-row h-t13 h-2 m-fits" }, "Wide enough for", this.machine));
      this.key = null;
    }
    get robot() {
      return HL.keep.read(ROBOT, "");
    }
    choose() {
      HL.keep.write(ROBOT, this.machine.value);
      this.act.robot();
    }
    paintMachines() {
      const robots = HL.maps.robots();
      const key = JSON.stringify(robots);
      if (key === this.machines) return;
      this.machines = key;
      this.machine.replaceChildren(...[["", "no machine chosen"], ...robots].map(([id, name]) => el("option", { value: id }, name)));
      this.machine.value = robots.some(([id]) => id === this.robot) ? this.robot : "";
    }
    // checks: {findings, blocks, looks}, null while the first answer is on its way, or {error}
    paint(checks, canEdit, nameOf) {
      this.paintMachines();
      const key = JSON.stringify([checks, canEdit, checks?.findings?.map((one) => nameOf(one.feature_id))]);
      if (key === this.key) return;
      this.key = key;
      attr(this.node, "data-blocks", checks?.blocks ?? null);
      attr(this.node, "data-looks", checks?.looks ?? null);
      this.sum.replaceChildren(...this.summary(checks));
      this.list.replaceChildren(...(checks?.findings ?? []).toSorted((a, b) => a.level - b.level).map((one) => this.card(one, canEdit, nameOf)));
    }
    summary(checks) {
      if (!checks) return ["Checking"];
      if (checks.error) return [el("span", { class: "h-2" }, `Not checked: ${checks.error}`)];
      const part = (level, words) => el("span", { class: "h-row m-count" }, alarm(level, 22), words);
      const parts = [];
      if (checks.blocks) parts.push(part(2, `${checks.blocks} ${checks.blocks === 1 ? "blocks" : "block"} publishing`));
      if (checks.looks) parts.push(part(3, `${checks.looks} to look at`));
      return parts.length ? parts : [el("span", { class: "h-2" }, "Nothing found")];
    }
    card(one, canEdit, nameOf) {
      const name = nameOf(one.feature_id);
      const head = name && !one.text.toLowerCase().includes(name.toLowerCase()) ? `${name}: ${one.text[0].toLowerCase()}${one.text.slice(1)}` : one.text;
      const fix = one.fix ? el("button", { type: "button", class: "h-btn", "data-testid": "finding-fix", disabled: !canEdit, onclick: (event) => this.fix(one, event.currentTarget) }, one.fix.label) : "";
      const show = el("button", { type: "button", class: one.fix ? "h-btn ico" : "h-btn", "data-testid": "finding-show", "aria-label": `Show: ${head}`, onclick: () => this.act.show(one) }, one.fix ? icon("visibility", "m") : "Show");
      return el("div", { class: "h-card m-finding", "data-testid": `finding-${one.code}`, "data-level": one.level }, alarm(one.level, 26), el("div", { class: "h-sp" }, el("div", { class: "h-t14 h-b" }, head), el("div", { class: "h-t13 h-2" }, one.advice)), el("span", { class: "h-row m-do" }, show, fix));
    }
    async fix(one, button) {
      attr(button, "disabled", true);
      text(button, "Working");
      await this.act.fix(one);
      this.key = null; // what stays is drawn anew, with its button
    }
  }

  HL.maps.Checks = Checks;
  HL.maps.blockedWords = (n) => `Fix ${count(n, "blocking check")} first.`;
})();
