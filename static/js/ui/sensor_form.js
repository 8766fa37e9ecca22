// Sheets with fields: what is wrong stands at its field, and what was typed stays when the server refuses.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const R = HL.sensorRules;

  class Form {
    // hook names the sheet and its parts: <hook>-<key>, <hook>-save, <hook>-error
    constructor(hook) {
      Object.assign(this, { hook, rows: [] });
      this.problem = el("div", { class: "h-error", role: "alert", hidden: true, "data-testid": `${hook}-error` });
    }

    row(key, label, node) {
      attr(node, "data-testid", `${this.hook}-${key.replace(/^limits\./, "").replaceAll(/[_.]/g, "-")}`);
      const wrong = el("span", { class: "h-error", hidden: true });
      const row = { key, node, wrong, label: el("label", { class: "h-field" }, label, node, wrong) };
      this.rows.push(row);
      return row;
    }

    input(key, label, value = "", options = {}) {
      const node = el("input", { class: "h-input", autocomplete: "off", ...options });
      node.value = String(value ?? "");
      return this.row(key, label, node);
    }

    number(key, label, value, options = {}) {
      return this.input(key, label, value ?? "", { inputmode: "decimal", maxlength: "20", ...options });
    }

    pick(key, label, choices, value) {
      const node = el("select", { class: "h-select" }, ...choices.map(([one, name]) => el("option", { value: one }, name)));
      node.value = value ?? "";
      return this.row(key, label, node);
    }

    of(key) {
      return this.rows.find((row) => row.key === key)?.node;
    }

    // numbers of these fields, null for empty ones; undefined when one is wrong, which then says so
    numbers(keys, needed = []) {
      const found = {};
      for (const key of keys) {
        const value = R.number(this.of(key).value);
        if (Number.isNaN(value)) return this.tell(`"${this.of(key).value.trim()}" is no number. Write it as 5.2`, key);
        if (value === null && needed.includes(key)) return this.tell("A number is needed here.", key);
        found[key] = value;
      }
      return found;
    }

    tell(words, field = null) {
      let isPlaced = false;
      for (const { key, node, wrong } of this.rows) {
        const isIt = Boolean(words) && key === field;
        isPlaced ||= isIt;
        text(wrong, isIt ? words : "");
        wrong.hidden = !isIt;
        attr(node, "aria-invalid", isIt ? "true" : null);
        if (isIt) node.focus();
      }
      text(this.problem, isPlaced ? "" : words);
      this.problem.hidden = !words || isPlaced;
      if (words && !isPlaced) this.problem.scrollIntoView({ block: "nearest" });
    }

    // the sheet around it; save() gives {method, path, body, done} or nothing when something is wrong
    open({ title, body, save, label, more = [] }) {
      const form = el("form", { class: "h-col", novalidate: true, onsubmit: (event) => (event.preventDefault(), this.send(save)) }, ...body, this.problem, el("button", { type: "submit", hidden: true }));
      const buttons = save ? [["Cancel", (close) => close()], ...more, [label, () => this.send(save), true]] : [["Close", (close) => close(), true]];
      this.close = HL.sheet({ title, hook: this.hook, body: [form], buttons });
      this.button = document.querySelector(`[data-testid=${this.hook}] > .foot .pri`);
      attr(this.button, "data-testid", save ? `${this.hook}-save` : `${this.hook}-close`);
      return this;
    }

    async send(save) {
      if (this.button.disabled) return;
      this.tell("");
      const order = save();
      if (!order) return;
      this.button.disabled = true;
      const answer = await HL.sensors.send(order.method, order.path, order.body);
      this.button.disabled = false;
      if (!answer.ok) return this.tell(`Not saved: ${answer.text || "no answer. Look before you save again."}`, order.field?.(answer.field) ?? answer.field ?? null);
      this.close();
      HL.toast(order.done, "check");
    }
  }

  HL.SensorForm = Form;
})();
