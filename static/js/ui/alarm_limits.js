// Admin: when an alarm counts, type by type. Every change has a reason; of priority 1 a second admin agrees.
(() => {
  "use strict";
  const { el, alarm, text } = HL;
  const { table, when } = HL.records;
  const PATH = "/alarms/limits";
  const KEYS = ["on_s", "off_s", "at", "deadband"];

  const button = (label, onclick, hook, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick }, label);
  const number = (value) => (value === null || value === undefined ? "–" : String(Number(value.toFixed(3))));
  const isSame = (a, b) => KEYS.every((key) => (a[key] ?? null) === (b[key] ?? null));

  function words(values, unit) {
    const parts = [`counts after ${number(values.on_s)} s`, `gone after ${number(values.off_s)} s`];
    if (values.at !== null) parts.unshift(`limit ${number(values.at)} ${unit}, dead-band ${number(values.deadband)} ${unit}`);
    return parts.join(", ");
  }

  class Panel {
    constructor(place) {
      this.rows = el("div");
      this.problem = el("div", { class: "h-error", role: "alert" });
      place.append(
        el("h2", {}, "Alarm limits"),
        el("p", { class: "h-2" }, "When a condition becomes an alarm. A change holds at once, without a restart, and is written to the audit log with its reason. Of priority 1 a second admin has to agree first."),
        this.problem, this.rows,
      );
      this.load();
    }

    load() {
      HL.records.load(this.rows, "Alarm limits", PATH, (answer) => this.draw(answer));
    }

    draw({ types }) {
      const order = [...types].sort((a, b) => Boolean(b.asked) - Boolean(a.asked) || a.priority - b.priority || a.title.localeCompare(b.title));
      return table(["", "Alarm", "Limit", "Dead-band", "Counts after", "Gone after", "State", ""], order.map((one) => this.row(one)));
    }

    row(one) {
      const { now, unit } = one;
      const value = (key, sign) => (now[key] === null ? "–" : `${number(now[key])} ${sign}`);
      return {
        hook: `limit-row-${one.code}`,
        cells: [el("span", {}, alarm(one.priority, 22, "acknowledged")), one.title, value("at", unit), value("deadband", unit), value("on_s", "s"), value("off_s", "s"), this.state(one), el("div", { class: "acts" }, ...this.acts(one))],
      };
    }

    state({ asked, changed, now, shipped, unit }) {
      if (asked) return el("span", { class: "h-col" }, el("b", {}, `${asked.by} asks for: ${words(asked.values, unit)}`), el("span", { class: "h-2" }, `${asked.reason}. ${asked.is_mine ? "Another admin has to agree." : "It holds when you agree."}`));
      if (!changed || isSame(now, shipped)) return "as shipped";
      return el("span", { class: "h-col" }, el("span", {}, `Set by ${[changed.by, changed.second].filter(Boolean).join(" and ")}, ${when(changed.at)}`), el("span", { class: "h-2" }, changed.reason));
    }

    acts(one) {
      const { asked, code } = one;
      if (!asked) return [button("Change", () => this.edit(one), `limit-edit-${code}`)];
      const drop = button(asked.is_mine ? "Take back" : "Decline", () => this.send("POST", `${PATH}/${code}/drop`, {}), `limit-drop-${code}`);
      return asked.is_mine ? [drop] : [button("Agree", () => this.send("POST", `${PATH}/${code}/agree`, {}), `limit-agree-${code}`, "pri"), drop];
    }

    edit(one) {
      const { now, shipped, bounds, unit } = one;
      const input = (key, most, least = 0) => {
        const node = el("input", { class: "h-input", type: "number", step: "any", min: least, max: most, "data-testid": `limit-${key}` });
        node.value = now[key];
        return node;
      };
      const inputs = { on_s: input("on_s", one.most_on_s), off_s: input("off_s", 3600) };
      if (bounds) Object.assign(inputs, { at: input("at", bounds[1], bounds[0]), deadband: input("deadband", bounds[1]) });
      const LABELS = { on_s: `Counts after, seconds (at most ${one.most_on_s})`, off_s: "Gone after, seconds", at: bounds ? `Limit, ${unit} (${bounds[0]} to ${bounds[1]})` : "", deadband: `Dead-band, ${unit}` };
      const reason = el("input", { class: "h-input", maxlength: "200", "data-testid": "limit-reason", "aria-label": "Reason" });
      const said = el("div", { class: "h-error", role: "alert" });
      const put = async (close, values) => {
        if (!reason.value.trim()) return text(said, "Say why. It is written to the audit log.");
        const answer = await HL.port.api("PUT", `${PATH}/${one.code}`, { values, reason: reason.value.trim() });
        if (!answer.ok) return text(said, answer.text || "The server did not answer.");
        close();
        HL.toast(one.priority === 1 ? "Asked. Another admin has to agree." : "Changed. It holds now.", "check");
        return this.load();
      };
      const read = () => Object.fromEntries(KEYS.map((key) => [key, inputs[key] ? Number(inputs[key].value) : null]));
      HL.sheet({
        title: one.title, hook: "limit-sheet",
        body: [
          el("p", { class: "h-2 h-t16" }, `As shipped: ${words(shipped, unit)}.${one.priority === 1 ? " Priority 1: another admin has to agree." : ""}`),
          el("div", { class: "h-form" }, ...Object.entries(inputs).map(([key, node]) => el("label", { class: "h-field" }, LABELS[key], node))),
          el("label", { class: "h-field" }, "Reason", reason), said,
        ],
        buttons: [["Cancel", (close) => close()], ["As shipped", (close) => put(close, null)], [one.priority === 1 ? "Ask" : "Change", (close) => put(close, read()), true]],
      });
    }

    async send(method, path, body) {
      const answer = await HL.port.api(method, path, body);
      text(this.problem, answer.ok ? "" : answer.text || "The server did not answer.");
      this.load();
    }
  }

  HL.AlarmLimits = Panel;
})();
