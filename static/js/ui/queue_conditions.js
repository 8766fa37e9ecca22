// The fields of an entry: when, how often, under which conditions; and back to what REST takes.
(() => {
  "use strict";
  const { el, text } = HL;
  const { DAYS, fromLocal, toLocal } = HL.queue;
  const WINDOWS = [[900, "15 min"], [3600, "1 h"], [14400, "4 h"], [43200, "12 h"], [86400, "24 h"]];
  const REPEATS = [["", "Once"], ["daily", "Every day"], ["workdays", "Monday to Friday"], ["weekly", "On days of the week"], ["every_n_days", "Every few days"]];

  const field = (label, input, hint) => el("label", { class: "h-field" }, label, input, hint ? el("small", { class: "h-t12 h-2" }, hint) : "");
  const number = (hook, value, props) => {
    const input = el("input", { class: "h-input", type: "number", inputmode: "decimal", step: "any", "data-testid": hook, ...props });
    input.value = value ?? "";
    return input;
  };
  const select = (hook, options, value) => {
    const made = el("select", { class: "h-select", "data-testid": hook }, ...options.map(([key, name]) => el("option", { value: key }, name)));
    made.value = String(value ?? "");
    return made;
  };
  const check = (hook, label, isOn) => {
    const input = el("input", { type: "checkbox", "data-testid": hook });
    input.checked = Boolean(isOn);
    return [input, el("label", { class: "h-check" }, input, label)];
  };

  class EntryFields {
    // entry: as REST gives it, or null for a new one; canStart: "" or why the queue cannot start it
    constructor(entry, zone, canStart) {
      this.zone = zone;
      const rule = entry?.conditions ?? { rain_below_mm_h: null, wind_below_mps: null, needs_daylight: false, after_sunrise_s: 0, before_sunset_s: 0, battery_reserve: 0.15, battery_min: null, needs_rtk: true, needs_treatment_weather: false };
      this.rule = rule;
      [this.unattended, this.unattendedLabel] = check("queue-unattended", "The queue starts it, when a person has armed it", entry?.is_unattended && !canStart);
      this.unattended.disabled = Boolean(canStart);
      this.why = el("p", { class: "h-t13 h-2" }, canStart);
      this.earliest = el("input", { class: "h-input", type: "datetime-local", "data-testid": "queue-earliest" });
      if (entry?.earliest_utc) this.earliest.value = toLocal(Date.parse(entry.earliest_utc), zone);
      this.window = select("queue-window", WINDOWS, entry?.window_s ?? 900);
      if (!this.window.value) this.window.append(new Option(`${Math.round(entry.window_s / 60)} min`, entry.window_s, true, true));
      this.repeat = select("queue-repeat", REPEATS, entry?.repeat?.kind ?? "");
      this.every = number("queue-every", entry?.repeat?.every_days ?? 2, { min: "1", max: "60", step: "1" });
      this.until = el("input", { class: "h-input", type: "date", "data-testid": "queue-until" });
      this.until.value = entry?.repeat?.until ?? "";
      this.days = DAYS.map((name, k) => {
        const [input, label] = check(`queue-day-${k}`, name, entry?.repeat?.days?.includes(k));
        return { input, label };
      });
      this.rain = number("queue-rain", rule.rain_below_mm_h, { min: "0.1", max: "100", placeholder: "no limit" });
      this.wind = number("queue-wind", rule.wind_below_mps, { min: "0.5", max: "60", placeholder: "no limit" });
      this.reserve = number("queue-reserve", rule.battery_reserve === null ? "" : Math.round(rule.battery_reserve * 100), { min: "0", max: "100", step: "1", placeholder: "not asked" });
      this.least = number("queue-least", rule.battery_min === null ? "" : Math.round(rule.battery_min * 100), { min: "0", max: "100", step: "1", placeholder: "not asked" });
      this.after = number("queue-after-rise", Math.round(rule.after_sunrise_s / 60), { min: "-360", max: "360", step: "1" });
      this.before = number("queue-before-set", Math.round(rule.before_sunset_s / 60), { min: "-360", max: "360", step: "1" });
      [this.daylight, this.daylightLabel] = check("queue-daylight", "Daylight only", rule.needs_daylight);
      [this.rtk, this.rtkLabel] = check("queue-rtk", "RTK fixed", rule.needs_rtk);
      [this.treatment, this.treatmentLabel] = check("queue-treatment", "Within the treatment limits", rule.needs_treatment_weather);
      this.problem = el("div", { class: "h-error", role: "alert", "data-testid": "queue-problem" });
      this.node = this.build();
      this.follow();
    }

    build() {
      this.daysField = el("div", { class: "q-days" }, ...this.days.map((one) => one.label));
      this.everyField = field("Every how many days", this.every);
      this.untilField = field("Last day", this.until, "empty: no end");
      this.windowField = field("May start later by", this.window, "later than that it waits for you");
      this.sunFields = el("div", { class: "h-form" }, field("Minutes after sunrise", this.after), field("Minutes before sunset", this.before));
      this.rules = el("fieldset", { class: "q-rules" }, el("legend", { class: "h-t14 h-b" }, "It starts only with"), el("div", { class: "h-form" }, field("Rain below, mm/h", this.rain), field("Wind below, m/s", this.wind), field("Battery left at the end, %", this.reserve), field("Battery at the start, %", this.least)), el("div", { class: "h-row h-wrap" }, this.daylightLabel, this.rtkLabel, this.treatmentLabel), this.sunFields);
      const node = el("div", { class: "q-fields" }, this.unattendedLabel, this.why, el("div", { class: "h-form" }, field("Not before", this.earliest, "empty: as soon as it is its turn"), this.windowField, field("Repeat", this.repeat), this.everyField, this.untilField), this.daysField, this.rules, this.problem);
      node.addEventListener("input", () => this.follow());
      return node;
    }

    follow() {
      const kind = this.repeat.value;
      this.daysField.hidden = kind !== "weekly";
      this.everyField.hidden = kind !== "every_n_days";
      this.untilField.hidden = !kind;
      this.windowField.hidden = !this.earliest.value;
      this.rules.hidden = !this.unattended.checked;
      this.sunFields.hidden = !this.daylight.checked;
    }

    // what REST takes, or null with a sentence beside the fields
    wish() {
      text(this.problem, "");
      const days = this.days.flatMap((one, k) => (one.input.checked ? [k] : []));
      if (this.repeat.value && !this.earliest.value) return this.refuse("A job that repeats needs a time.", this.earliest);
      if (this.repeat.value === "weekly" && !days.length) return this.refuse("Choose at least one day.", this.days[0].input);
      for (const input of [this.rain, this.wind, this.reserve, this.least, this.every, this.after, this.before]) if (!input.closest("[hidden]") && !input.checkValidity()) return this.refuse(`${input.closest("label").firstChild.textContent}: ${input.min} to ${input.max}.`, input);
      const given = (input, factor = 1) => (input.value === "" ? null : Number(input.value) * factor);
      return {
        is_unattended: this.unattended.checked,
        earliest_utc: this.earliest.value ? new Date(fromLocal(this.earliest.value, this.zone)).toISOString() : null,
        window_s: Number(this.window.value),
        repeat: this.repeat.value ? { kind: this.repeat.value, days: this.repeat.value === "weekly" ? days : [], every_days: this.repeat.value === "every_n_days" ? Math.round(Number(this.every.value)) : 1, until: this.until.value || null } : null,
        conditions: {
          rain_below_mm_h: given(this.rain), wind_below_mps: given(this.wind), needs_daylight: this.daylight.checked,
          after_sunrise_s: Math.round(Number(this.after.value) * 60), before_sunset_s: Math.round(Number(this.before.value) * 60),
          battery_reserve: given(this.reserve, 0.01), battery_min: given(this.least, 0.01), needs_rtk: this.rtk.checked,
          needs_treatment_weather: this.treatment.checked,
        },
      };
    }

    refuse(words, input) {
      text(this.problem, words);
      input?.focus();
      return null;
    }
  }

  HL.queueFields = { EntryFields, field, select };
})();
