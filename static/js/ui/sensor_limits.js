// Limits: which values treatment waits for, and which are only watched. Planners change them, everybody reads them.
(() => {
  "use strict";
  const { el, icon } = HL;
  const U = HL.sensorUnits;
  const PATH = "/sensor-limits";
  const READ_ONLY = "Limits can be changed by planners.";

  const title = (row) => row.label || `${HL.sensorRules.QUANTITIES[row.quantity]?.label ?? row.quantity}${U.isNumber(row.depth_m) ? ` ${Math.round(row.depth_m * 100)} cm` : ""}`;
  const bound = (value, unit) => (U.isNumber(value) ? `${value} ${unit ?? ""}`.trim().replaceAll(" ", "\u00a0") : "–");
  const who = (row) => (row.by ? `Set by ${row.by}, ${HL.records.when(row.at)}` : "As shipped");

  class Limits {
    constructor(mayChange) {
      this.mayChange = mayChange;
      this.form = new HL.SensorForm("limits");
      this.place = el("div", { class: "h-col" });
      this.form.open({
        title: "Limits",
        body: [el("p", { class: "h-t16" }, `Treatment waits while a value is beyond its limit, and goes on when the value is back.${mayChange ? " Leave both fields of a limit empty to take it away." : ""}`), mayChange ? "" : el("p", { class: "h-row h-t16 h-b", "data-testid": "limits-readonly" }, icon("lock", "m"), READ_ONLY), this.place],
        label: "Save limits",
        save: mayChange ? () => this.order() : null,
      });
      if (mayChange) this.form.button.disabled = true; // until there is something to change
      HL.records.load(this.place, "Limits", PATH, (answer) => this.draw(HL.records.list(answer, "limits")));
    }

    draw(rows) {
      Object.assign(this, { rows: [], revision: rows[0]?.revision ?? "" });
      this.form.rows = [];
      if (!this.mayChange) {
        if (!rows.length) return HL.records.empty("No limits", "Nothing that is measured holds treatment.");
        return HL.records.table(["Value", "Least", "Most", "Treatment waits", ""], rows.map((row) => ({ cells: [title(row).replaceAll(" ", "\u00a0"), bound(row.low, row.unit), bound(row.high, row.unit), row.is_treatment ? "yes" : "no", [row.note, who(row)].filter(Boolean).join(" · ")] })));
      }
      this.form.button.disabled = false;
      this.blocks = el("div", { class: "h-col" }, ...rows.map((row) => this.block(row)));
      this.more = el("select", { class: "h-select", "aria-label": "Another limit", "data-testid": "limits-add", onchange: () => this.add() });
      this.offer();
      return [this.blocks, this.more];
    }

    // what is measured and has no limit yet
    offer() {
      const key = (one) => `${one.quantity}@${one.depth_m ?? ""}`;
      const has = new Set(this.rows.map(key));
      const values = HL.sensors.stations().flatMap((one) => one.values).filter((one) => one.quantity !== "wind_bearing");
      this.offered = new Map(values.filter((one) => !has.has(key(one))).map((one) => [key(one), one]));
      const offers = [...this.offered].sort((a, b) => title(a[1]).localeCompare(title(b[1]), undefined, { numeric: true }));
      this.more.replaceChildren(el("option", { value: "" }, "Add a limit"), ...offers.map(([id, one]) => el("option", { value: id }, title(one))));
      this.more.hidden = !offers.length;
    }

    add() {
      const one = this.offered.get(this.more.value);
      if (!one) return;
      const { quantity, depth_m, label, unit } = one;
      this.blocks.append(this.block({ quantity, depth_m, label, unit, low: null, high: null, is_treatment: true, note: "", isNew: true }));
      this.offer();
      this.form.of(`limits.${this.rows.length - 1}.high`).focus();
    }

    block(row) {
      const n = this.rows.push(row) - 1;
      const key = (name) => `limits.${n}.${name}`;
      const low = this.form.number(key("low"), `Least, ${row.unit || "no unit"}`, row.low);
      const high = this.form.number(key("high"), `Most, ${row.unit || "no unit"}`, row.high);
      const note = this.form.input(key("note"), "Note", row.note, { maxlength: "200" });
      row.box = el("input", { type: "checkbox", checked: row.is_treatment, "data-testid": `limits-${n}-treatment` });
      return el("fieldset", { class: "sn-limit", "data-testid": `limit-${row.quantity}${U.isNumber(row.depth_m) ? `-${Math.round(row.depth_m * 100)}` : ""}` }, el("legend", { class: "h-t16 h-b" }, title(row)), low.label, high.label, el("label", { class: "sn-check h-t16" }, row.box, "Treatment waits"), note.label, el("span", { class: "h-t13 h-2" }, row.isNew ? "New" : who(row)));
    }

    // a limit with neither least nor most asks nothing: it goes
    order() {
      const limits = [];
      const sent = [];
      for (const [n, row] of this.rows.entries()) {
        const keys = [`limits.${n}.low`, `limits.${n}.high`];
        const found = this.form.numbers(keys);
        if (!found) return null;
        const [low, high] = keys.map((key) => found[key]);
        if (low !== null && high !== null && low >= high) return this.form.tell("Least has to be below most.", keys[0]);
        if (low === null && high === null) continue;
        sent.push(n);
        limits.push({ quantity: row.quantity, depth_m: row.depth_m ?? null, low, high, is_treatment: row.box.checked, note: this.form.of(`limits.${n}.note`).value.trim() });
      }
      // the server counts what was sent, the sheet what is on it
      const field = (name) => name?.replace(/^limits\.(\d+)\./, (_, k) => `limits.${sent[Number(k)]}.`);
      return { method: "PUT", path: PATH, body: { limits, revision: this.revision }, done: "Limits saved. They hold now.", field };
    }
  }

  HL.sensorLimits = (mayChange) => new Limits(mayChange);
})();
