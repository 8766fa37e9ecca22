// Dock of the map: publish with the reason why not, compare, discard; without a draft, the way into one.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr } = HL;
  const { count } = HL.maps;

  class Dock {
    // act: {publish, checks, compare, discard, edit, take}
    constructor(act) {
      const button = (hook, sign, run, look = "") => {
        const word = el("span");
        const node = el("button", { type: "button", class: `h-btn op ${look}`.trim(), "data-testid": hook, onclick: run }, sign ? icon(sign) : "", word);
        return { node, word };
      };
      this.publish = button("editor-publish", "publish", () => act.publish(), "pri");
      this.compare = button("editor-compare", "difference", () => act.compare());
      this.discard = button("editor-discard", "", () => act.discard(), "q");
      this.edit = button("editor-edit", "edit", () => act.edit(), "pri");
      this.take = button("editor-take", "lock_open", () => act.take());
      this.sign = el("span", { class: "m-sign" }, alarm(2, 24));
      this.reason = el("span", { "data-testid": "editor-reason" });
      this.toChecks = el("button", { type: "button", class: "h-btn op", "data-testid": "editor-to-checks", onclick: () => act.checks() }, "Show");
      this.why = el("span", { class: "h-row h-t14 m-why" }, this.sign, this.reason, this.toChecks);
      this.running = el("span");
      this.keeps = el("span");
      this.hint = el("span", { class: "h-t13 h-2 m-running" }, this.running, this.keeps);
      text(this.discard.word, "Discard draft");
      this.node = el("div", { class: "m-dock", role: "toolbar", "aria-label": "Draft" }, this.publish.node, this.edit.node, this.why, this.take.node, this.compare.node, this.discard.node, el("span", { class: "h-sp" }), this.hint);
    }

    // state: {isEditing, reason, isBlocked, next, base, edit: {label, reason, isOff}, canTake}
    paint({ isEditing, reason, isBlocked, next, base, isOutdated, edit, canTake }) {
      for (const one of [this.publish, this.compare, this.discard]) attr(one.node, "hidden", !isEditing);
      attr(this.edit.node, "hidden", isEditing || !edit.label);
      attr(this.take.node, "hidden", isEditing || !canTake);
      attr(this.compare.node, "hidden", !isEditing || !(base || isOutdated));
      attr(this.publish.node, "disabled", Boolean(reason));
      attr(this.edit.node, "disabled", edit.isOff);
      text(this.publish.word, `Publish v${next}`);
      text(this.compare.word, base ? `Compare with v${base}` : "Compare");
      text(this.edit.word, edit.label);
      text(this.take.word, "Take");
      for (const one of [this.sign, this.toChecks]) attr(one, "hidden", !(isEditing && isBlocked));
      text(this.reason, isEditing ? reason : edit.reason);
      attr(this.why, "hidden", !this.reason.textContent);
      this.paintRunning();
    }

    // robots on a mission, as the fleet says
    paintRunning() {
      const n = Object.values(HL.port.fleet()).filter((robot) => robot.mode === "auto" || robot.mode === "paused").length;
      text(this.running, n ? `${count(n, "robot runs a mission", "robots run missions")}.` : "");
      text(this.keeps, n ? (n === 1 ? "It keeps its map." : "They keep their map.") : "");
    }
  }

  HL.maps.Dock = Dock;
})();
