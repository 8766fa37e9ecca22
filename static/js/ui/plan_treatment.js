// Where the tool works: the whole field, or areas of the map that are off, on, or get more or less.
(() => {
  "use strict";
  const { el } = HL;
  const DOSES = [["", "As the rest"], ["0", "Off"], ["0.5", "Half dose"], ["1", "Usual dose"], ["1.5", "One and a half"], ["2", "Double dose"]];
  const REST = [["1", "Treat it"], ["0.5", "Half dose"], ["0", "Leave it out"]];

  const corners = (geometry) => (geometry?.type === "Polygon" ? geometry.coordinates[0] : geometry?.type === "MultiPolygon" ? geometry.coordinates.flatMap((one) => one[0]) : []);

  function box(geometry) {
    const points = corners(geometry);
    if (!points.length) return null;
    const xs = points.map((p) => p[0]);
    const ys = points.map((p) => p[1]);
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  const meet = (a, b) => a && b && a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3];
  const select = (hook, label, rows) => el("select", { class: "h-select", "data-testid": hook, "aria-label": label }, ...rows.map(([value, word]) => el("option", { value }, word)));
  const metres = (hook, label) => el("input", { class: "h-input", type: "number", inputmode: "decimal", min: "0", max: "10", step: "any", placeholder: "as the tool needs", "data-testid": hook, "aria-label": label });

  class Treatment {
    // areas: features of the map that may have a dose of their own
    constructor(areas) {
      this.areas = areas;
      this.doses = new Map();
      this.rest = select("plan-rest-dose", "Rest of the field", REST);
      this.leadIn = metres("plan-lead-in", "Tool on before, m");
      this.leadOut = metres("plan-lead-out", "Tool off after, m");
      this.list = el("div", { class: "p-areas" });
      this.none = el("p", { class: "h-t13 h-2" }, "No treatment areas lie in this field. Draw them under Maps: an area of kind Treatment area.");
      const field = (label, input) => el("label", { class: "h-field" }, label, input);
      this.node = el("div", { class: "p-treatment" }, this.list, this.none, field("Rest of the field", this.rest), el("div", { class: "p-two" }, field("Tool on before, m", this.leadIn), field("Tool off after, m", this.leadOut)));
    }

    // offers the areas whose surroundings meet the field's
    follow(field) {
      const own = box(field?.geometry);
      this.shown = this.areas.filter((area) => meet(own, box(area.geometry)));
      this.none.hidden = this.shown.length > 0;
      this.list.replaceChildren(...this.shown.map((area) => {
        const dose = area.properties?.dose;
        const choice = select(`plan-dose-${area.id}`, area.name, typeof dose === "number" && !DOSES.some(([value]) => value === String(dose)) ? [...DOSES, [String(dose), `${dose} times`]] : DOSES);
        choice.value = this.doses.get(area.id) ?? (area.kind === "treatment" ? String(dose ?? 1) : "");
        this.doses.set(area.id, choice.value);
        choice.addEventListener("input", () => this.doses.set(area.id, choice.value));
        return el("label", { class: "h-field" }, area.name, choice);
      }));
    }

    // what of it goes into the wish
    wish() {
      const treatments = (this.shown ?? []).filter((area) => this.doses.get(area.id)).map((area) => ({ feature_id: area.id, dose: Number(this.doses.get(area.id)) }));
      const wish = {};
      if (treatments.length) wish.treatments = treatments;
      if (this.rest.value !== "1") wish.rest_dose = Number(this.rest.value);
      if (this.leadIn.value !== "") wish.lead_in_m = Number(this.leadIn.value);
      if (this.leadOut.value !== "") wish.lead_out_m = Number(this.leadOut.value);
      return wish;
    }

    apply(wish) {
      this.doses = new Map((wish.treatments ?? []).map((one) => [one.feature_id, String(one.dose)]));
      for (const area of this.areas) if (!this.doses.has(area.id) && wish.treatments) this.doses.set(area.id, "");
      this.rest.value = String(wish.rest_dose ?? 1);
      this.leadIn.value = wish.lead_in_m ?? "";
      this.leadOut.value = wish.lead_out_m ?? "";
    }

    summary() {
      const own = (this.shown ?? []).filter((area) => this.doses.get(area.id));
      if (this.rest.value === "0") return own.length ? `Only ${own.map((area) => area.name).join(", ")}` : "Nothing is treated";
      const off = own.filter((area) => this.doses.get(area.id) === "0").length;
      const parts = [off ? `${off} off` : "", own.length - off ? `${own.length - off} with a dose of their own` : ""].filter(Boolean);
      return parts.length ? `Whole field, ${parts.join(", ")}` : this.rest.value === "1" ? "Whole field, usual dose" : "Whole field, half dose";
    }

    problem() {
      return this.rest.value === "0" && !(this.shown ?? []).some((area) => Number(this.doses.get(area.id)) > 0) ? "Nothing is treated. Choose an area or the rest of the field." : "";
    }
  }

  HL.planner.Treatment = Treatment;
})();
