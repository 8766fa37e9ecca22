// Planning a mission: field, robot, home, rows; a preview with its numbers; then stored, or stored and sent.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const PREVIEW_LIMIT_MS = 70000; // the planner gives up after 60 s and says so
  const DRAFT = "mission-plan";

  const options = (rows) => rows.map(({ id, name }) => el("option", { value: id }, name));
  const field = (label, input, hint) => el("label", { class: "h-field" }, label, input, hint ? el("small", { class: "h-t12 h-2" }, hint) : "");
  const select = (hook, name, rows) => el("select", { class: "h-select", "data-testid": hook, name }, ...rows);
  const number = (hook, name, props) => el("input", { class: "h-input", "data-testid": hook, name, type: "number", inputmode: "decimal", step: "any", ...props });

  class MissionForm {
    // places: {fields, homes, robots}; actions: {stored(mission, isSent), close}
    constructor(places, actions, maySend) {
      this.places = places;
      this.actions = actions;
      this.preview = null;
      this.inputs = {
        field_id: select("plan-field", "field_id", options(places.fields)),
        robot_id: select("plan-robot", "robot_id", options(places.robots)),
        home_id: select("plan-home", "home_id", [el("option", { value: "" }, "Its own, or the nearest"), ...options(places.homes)]),
        width_m: number("plan-width", "width_m", { min: "0.05", max: "50", required: true, value: "3" }),
        row_bearing_deg: number("plan-bearing", "row_bearing_deg", { min: "-360", max: "360", placeholder: "as planted, or best" }),
        headland_passes: number("plan-headland", "headland_passes", { min: "0", max: "50", step: "1", placeholder: "as many as turning needs" }),
        name: el("input", { class: "h-input", "data-testid": "plan-name", name: "name", maxlength: "80", placeholder: "field and row distance", autocomplete: "off" }),
        returns_home: el("input", { type: "checkbox", name: "returns_home", "data-testid": "plan-return", checked: true }),
      };
      this.problem = el("div", { class: "h-error", role: "alert", "data-testid": "plan-error" });
      this.result = el("div", { class: "h-sec" });
      this.previewButton = el("button", { class: "h-btn pri", type: "submit", "data-testid": "plan-preview" }, icon("visibility", "m"), "Preview");
      this.storeButton = el("button", { class: "h-btn", type: "button", "data-testid": "plan-store", disabled: true, onclick: () => this.store(false) }, icon("check", "m"), "Store");
      this.sendButton = el("button", { class: "h-btn pri", type: "button", "data-testid": "plan-send", disabled: true, onclick: () => this.store(true) });
      this.maySend = maySend;
      this.node = this.build();
      this.recall();
      this.follow();
    }

    build() {
      const i = this.inputs;
      const form = el("form", { class: "h-card h-sec", novalidate: true, onsubmit: (event) => (event.preventDefault(), this.look()) },
        el("div", { class: "h-form" }, field("Field", i.field_id), field("Robot", i.robot_id), field("Home", i.home_id), field("Row distance, m", i.width_m), field("Row direction, ° from north", i.row_bearing_deg), field("Headland laps", i.headland_passes), field("Name", i.name), el("label", { class: "h-check" }, i.returns_home, "Drive home at the end")),
        el("div", { class: "h-row h-wrap" }, this.previewButton, this.storeButton, this.sendButton, el("span", { class: "h-t13 h-2" }, "Sending does not move the robot.")), this.problem);
      form.addEventListener("input", () => this.changed());
      return el("div", { class: "h-sec" }, el("div", { class: "h-row" }, el("button", { type: "button", class: "h-btn q ico", "aria-label": "Back to the missions", onclick: () => this.actions.close() }, icon("arrow_back")), el("h2", {}, "Plan a mission")), form, this.result);
    }

    // what was typed survives an outage and a reload
    recall() {
      const kept = HL.draft.get(DRAFT) || {};
      for (const [key, input] of Object.entries(this.inputs)) {
        if (!(key in kept)) continue;
        if (input.type === "checkbox") input.checked = kept[key] === true;
        else if (!input.matches("select") || [...input.options].some((option) => option.value === kept[key])) input.value = kept[key];
      }
    }

    // the map knows how a field was planted: its row distance is the first offer
    follow() {
      this.inputs.field_id.addEventListener("change", () => {
        const spacing = this.places.fields.find((one) => one.id === this.inputs.field_id.value)?.properties?.row_spacing_m;
        if (spacing) this.inputs.width_m.value = String(Math.max(spacing, 0.5));
      });
      this.inputs.robot_id.addEventListener("change", () => this.words());
      this.words();
    }

    words() {
      const robot = this.places.robots.find((one) => one.id === this.inputs.robot_id.value);
      this.sendButton.replaceChildren(icon("route", "m"), `Store and send to ${robot?.name ?? "robot"}`);
    }

    changed() {
      this.preview = null;
      this.storeButton.disabled = this.sendButton.disabled = true;
      HL.draft.set(DRAFT, Object.fromEntries(Object.entries(this.inputs).map(([key, input]) => [key, input.type === "checkbox" ? input.checked : input.value])));
    }

    wish() {
      const i = this.inputs;
      const body = { field_id: i.field_id.value, robot_id: i.robot_id.value, width_m: Number(i.width_m.value), returns_home: i.returns_home.checked };
      if (i.home_id.value) body.home_id = i.home_id.value;
      if (i.name.value.trim()) body.name = i.name.value.trim();
      if (i.row_bearing_deg.value !== "") body.row_bearing_deg = Number(i.row_bearing_deg.value);
      if (i.headland_passes.value !== "") body.headland_passes = Math.round(Number(i.headland_passes.value));
      return body;
    }

    async look() {
      const wish = this.wish();
      text(this.problem, "");
      this.previewButton.disabled = true;
      this.result.replaceChildren(el("div", { class: "h-card h-row" }, icon("hourglass_top"), "Planning"));
      const answer = await HL.port.api("POST", "/missions/preview", wish, PREVIEW_LIMIT_MS);
      this.previewButton.disabled = false;
      if (!answer.ok) {
        this.result.replaceChildren();
        return this.refused(answer);
      }
      this.preview = JSON.stringify(wish);
      this.storeButton.disabled = false;
      this.sendButton.disabled = !this.maySend;
      this.result.replaceChildren(el("div", { class: "h-mpicture" }, HL.fieldPicture(answer.geometry, answer.name)), HL.plan.cards(answer.statistics), ...(answer.statistics.notes ?? []).map((note) => el("div", { class: "h-row h-t14 h-b" }, icon("warning", "m"), note)));
    }

    async store(isSending) {
      const wish = this.wish();
      if (JSON.stringify(wish) !== this.preview) return this.look();
      this.storeButton.disabled = this.sendButton.disabled = true;
      const answer = await HL.port.api("POST", "/missions/plan", wish, PREVIEW_LIMIT_MS);
      if (!answer.ok) {
        this.storeButton.disabled = false;
        this.sendButton.disabled = !this.maySend;
        return this.refused(answer);
      }
      HL.draft.clear(DRAFT);
      this.actions.stored(answer.data, isSending);
    }

    refused(answer) {
      text(this.problem, answer.text || "Not planned: the server did not answer. Try again.");
      this.inputs[answer.field]?.focus();
    }
  }

  HL.MissionForm = MissionForm;
})();
