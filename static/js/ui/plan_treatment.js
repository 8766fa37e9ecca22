// Where the tool works: the whole field, or areas that are off, on, or get more or less: of the map, or drawn here.
(() => {
  "use strict";
  const { el, icon } = HL;
  const DRAFT = "mission-plan-areas";
  const DRAWN_DOSES = [["0", "Off"], ["0.5", "Half dose"], ["1", "Usual dose"], ["1.5", "One and a half"], ["2", "Double dose"]];
  const MOST_DRAWN = 50;
  const DIGITS = 8; // of degrees: a millimetre
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

  const polygon = (outline) => ({ type: "Polygon", coordinates: [[...outline, outline[0]]] });
  const meet = (a, b) => a && b && a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3];
  const select = (hook, label, rows) => el("select", { class: "h-select", "data-testid": hook, "aria-label": label }, ...rows.map(([value, word]) => el("option", { value }, word)));
  const metres = (hook, label) => el("input", { class: "h-input", type: "number", inputmode: "decimal", min: "0", max: "10", step: "any", placeholder: "usual", "data-testid": hook, "aria-label": label });

  class Treatment {
    // areas: features of the map that may have a dose of their own; actions: {draw(done, ended), changed()};
    // draft: of the server, kept there and not in this browser
    constructor(areas, actions, draft = null) {
      this.areas = areas;
      this.actions = actions;
      this.draft = draft;
      const kept = (!draft && HL.draft.get(DRAFT)) || {};
      this.chosen = new Map(Object.entries(kept.chosen ?? {})); // by a person; the others stay as the map has them
      this.doses = new Map();
      this.drawn = kept.drawn ?? []; // [{outline, dose}], of this plan alone
      this.pen = el("button", { type: "button", class: "h-btn", "data-testid": "plan-draw-area", onclick: () => this.draw() }, icon("pentagon", "m"), "Draw an area");
      this.own = el("div", { class: "p-areas" });
      this.rest = select("plan-rest-dose", "Rest of the field", REST);
      this.leadIn = metres("plan-lead-in", "Tool on before, m");
      this.leadOut = metres("plan-lead-out", "Tool off after, m");
      this.list = el("div", { class: "p-areas" });
      this.none = el("p", { class: "h-t13 h-2" }, "No treatment areas of the map lie in this field. Draw one here for this plan, or under Maps for all plans.");
      this.rest.value = kept.rest ?? "1";
      this.leadIn.value = kept.leadIn ?? "";
      this.leadOut.value = kept.leadOut ?? "";
      const field = (label, input) => el("label", { class: "h-field" }, label, input);
      this.node = el("div", { class: "p-treatment", oninput: () => this.keep() }, this.list, this.none, this.own, this.pen, field("Rest of the field", this.rest), el("div", { class: "p-two" }, field("Tool on before, m", this.leadIn), field("Tool off after, m", this.leadOut)));
    }

    // offers the areas whose surroundings meet the field's
    follow(field) {
      const own = box(field?.geometry);
      this.field = own;
      this.shown = this.areas.filter((area) => meet(own, box(area.geometry)));
      this.paintDrawn();
      this.none.hidden = this.shown.length > 0;
      this.list.replaceChildren(...this.shown.map((area) => {
        const dose = area.properties?.dose;
        const choice = select(`plan-dose-${area.id}`, area.name, typeof dose === "number" && !DOSES.some(([value]) => value === String(dose)) ? [...DOSES, [String(dose), `${dose} times`]] : DOSES);
        choice.value = this.chosen.get(area.id) ?? (area.kind === "treatment" ? String(dose ?? 1) : "");
        this.doses.set(area.id, choice.value);
        choice.addEventListener("input", () => (this.chosen.set(area.id, choice.value), this.doses.set(area.id, choice.value)));
        return el("label", { class: "h-field" }, area.name, choice);
      }));
    }

    draw() {
      this.pen.disabled = true;
      this.actions.draw((outline) => {
        this.drawn.push({ outline: outline.map((place) => place.map((one) => Number(one.toFixed(DIGITS)))), dose: 0 });
        this.redrawn();
      }, () => this.paintDrawn());
    }

    keep() {
      if (!this.draft) HL.draft.set(DRAFT, { drawn: this.drawn, chosen: Object.fromEntries(this.chosen), rest: this.rest.value, leadIn: this.leadIn.value, leadOut: this.leadOut.value });
    }

    redrawn() {
      this.keep();
      this.paintDrawn();
      this.actions.changed();
    }

    forget() {
      if (!this.draft) HL.draft.clear(DRAFT);
    }

    // those drawn in the field at hand
    get here() {
      return this.drawn.filter((one) => meet(this.field, box(polygon(one.outline))));
    }

    pictured() {
      return this.here.map((one, k) => ({ ...one, name: `Area ${k + 1}, ${HL.doseWords(one.dose).toLowerCase()}` }));
    }

    paintDrawn() {
      this.pen.disabled = this.drawn.length >= MOST_DRAWN;
      this.own.replaceChildren(...this.here.map((one, k) => {
        const choice = select(`plan-drawn-dose-${k}`, `Area ${k + 1}`, DRAWN_DOSES.some(([value]) => value === String(one.dose)) ? DRAWN_DOSES : [...DRAWN_DOSES, [String(one.dose), `${one.dose} times`]]);
        choice.value = String(one.dose);
        choice.addEventListener("change", () => ((one.dose = Number(choice.value)), this.redrawn()));
        const away = () => ((this.drawn = this.drawn.filter((other) => other !== one)), this.redrawn());
        return el("div", { class: "h-row p-drawn" }, el("label", { class: "h-field h-sp" }, `Area ${k + 1}, of this plan`, choice), el("button", { type: "button", class: "h-btn ico", "aria-label": `Take area ${k + 1} away`, "data-testid": `plan-drawn-remove-${k}`, onclick: away }, icon("delete", "m")));
      }));
    }

    // what of it goes into the wish; what is drawn here wins over the map
    wish() {
      const treatments = (this.shown ?? []).filter((area) => this.doses.get(area.id)).map((area) => ({ feature_id: area.id, dose: Number(this.doses.get(area.id)) }));
      treatments.push(...this.here.map((one) => ({ geometry: polygon(one.outline), dose: one.dose })));
      const wish = {};
      if (treatments.length) wish.treatments = treatments;
      if (this.rest.value !== "1") wish.rest_dose = Number(this.rest.value);
      if (this.leadIn.value !== "") wish.lead_in_m = Number(this.leadIn.value);
      if (this.leadOut.value !== "") wish.lead_out_m = Number(this.leadOut.value);
      return wish;
    }

    apply(wish) {
      this.chosen = new Map((wish.treatments ?? []).filter((one) => one.feature_id).map((one) => [one.feature_id, String(one.dose)]));
      this.drawn = (wish.treatments ?? []).filter((one) => one.geometry?.type === "Polygon").map((one) => ({ outline: one.geometry.coordinates[0].slice(0, -1), dose: one.dose }));
      for (const area of this.areas) if (!this.chosen.has(area.id) && wish.treatments) this.chosen.set(area.id, "");
      this.rest.value = String(wish.rest_dose ?? 1);
      this.leadIn.value = wish.lead_in_m ?? "";
      this.leadOut.value = wish.lead_out_m ?? "";
      this.keep();
    }

    summary() {
      const own = [...(this.shown ?? []).filter((area) => this.doses.get(area.id)), ...this.pictured().map((one) => ({ id: one, name: one.name.split(",")[0] }))];
      const dose = (area) => (typeof area.id === "string" ? this.doses.get(area.id) : String(area.id.dose));
      if (this.rest.value === "0") return own.length ? `Only ${own.map((area) => area.name).join(", ")}` : "Nothing is treated";
      const off = own.filter((area) => dose(area) === "0").length;
      const parts = [off ? `${off} off` : "", own.length - off ? `${own.length - off} with a dose of their own` : ""].filter(Boolean);
      return parts.length ? `Whole field, ${parts.join(", ")}` : this.rest.value === "1" ? "Whole field, usual dose" : "Whole field, half dose";
    }

    problem() {
      return this.rest.value === "0" && !this.here.some((one) => one.dose > 0) && !(this.shown ?? []).some((area) => Number(this.doses.get(area.id)) > 0) ? "Nothing is treated. Choose an area or the rest of the field." : "";
    }
  }

  HL.planner.Treatment = Treatment;
})();
