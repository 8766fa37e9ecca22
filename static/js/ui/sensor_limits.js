// Limits: which values treatment waits for, and which are only watched. Planners change them, everybody reads them.
(() => {
  "use strict";
  const { el, icon } = HL;
  const U = HL.sensorUnits;
  const PATH = "/sensor-limits";
  const READ_ONLY = "Limits can be changed by planners.";

  const title = (row) => row.label || `${HL.sensorRules.QUANTITIES[row.quantity]?.label ?? row.quantity}${U.isNumber(row.depth_m) ? ` ${Math.round(row.depth_m * 100)} cm` : ""}`;
  const bound = (value, unit) => (U.isNumber(value) ? `${value} ${unit ?? ""}`.trim() : "–");
  const who = (row) => (row.by ? `Set by ${row.by}, ${HL.records.when(row.at)}` : "As shipped");

  class Limits {
    constructor(mayChange) {
      this.mayChange = mayChange;
      this.form = new HL.SensorForm("limits");
      this.place = el("div", { class: "h-col" });
      this.form.open({
        title: "Limits",
        body: [el("p", { class: "h-t16" }, "Treatment waits while a value is beyond its limit, and goes on when the value is back. Leave a field empty to ask nothing."), mayChange ? "" : el("p", { class: "h-row h-t16 h-b", "data-testid": "limits-readonly" }, icon("lock", "m"), READ_ONLY), this.place],
        label: "Save limits",
        save: mayChange ? () => this.order() : null,
      });
      if (mayChange) this.form.button.disabled = true; // until there is something to change
      HL.records.load(this.place, "Limits", PATH, (answer) => this.draw(HL.records.list(answer, "limits")));
    }

    draw(rows) {
      Object.assign(this, { rows });
      this.form.rows = [];
      if (this.mayChange) this.form.button.disabled = !rows.length;
      if (!rows.length) return HL.records.empty("No limits", "Nothing that is measured holds treatment.");
      if (!this.mayChange) return HL.records.table(["Value", "Least", "Most", "Holds treatment", ""], rows.map((row) => ({ cells: [title(row), bound(row.low, row.unit), bound(row.high, row.unit), row.is_treatment ? "yes" : "no", [row.note, who(row)].filter(Boolean).join(". ")] })));
      return rows.map((row, n) => this.block(row, n));
    }

    block(row, n) {
      const key = (name) => `limits.${n}.${name}`;
      const low = this.form.number(key("low"), `Least, ${row.unit || "no unit"}`, row.low);
      const high = this.form.number(key("high"), `Most, ${row.unit || "no unit"}`, row.high);
      const note = this.form.input(key("note"), "Note", row.note, { maxlength: "200" });
      const box = el("input", { type: "checkbox", checked: row.is_treatment, "data-testid": `limits-${n}-treatment` });
      row.box = box;
      return el("fieldset", { class: "sn-limit", "data-testid": `limit-${row.quantity}${U.isNumber(row.depth_m) ? `-${Math.round(row.depth_m * 100)}` : ""}` }, el("legend", { class: "h-t16 h-b" }, title(row)), low.label, high.label, el("label", { class: "f-check sn-check" }, box, "Treatment waits"), note.label, el("span", { class: "h-t13 h-2" }, who(row)));
    }

    order() {
      const limits = [];
      for (const [n, row] of this.rows.entries()) {
        const keys = [`limits.${n}.low`, `limits.${n}.high`];
        const found = this.form.numbers(keys);
        if (!found) return null;
        const [low, high] = keys.map((key) => found[key]);
        if (low !== null && high !== null && low >= high) return this.form.tell("Least has to be below most.", keys[0]);
        limits.push({ quantity: row.quantity, depth_m: row.depth_m ?? null, low, high, is_treatment: row.box.checked, note: this.form.of(`limits.${n}.note`).value.trim() });
      }
      return { method: "PUT", path: PATH, body: { limits }, done: "Limits saved. They hold now." };
    }
  }

  HL.sensorLimits = (mayChange) => new Limits(mayChange);
})();
