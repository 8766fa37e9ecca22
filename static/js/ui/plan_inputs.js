// The inputs of a plan, what they ask for, and the draft of them that outlives an outage and a reload.
(() => {
  "use strict";
  const { el } = HL;
  const DRAFT = "mission-plan";
  const CORNERS = [["", "Any"], ["north_west", "North-west"], ["north_east", "North-east"], ["south_west", "South-west"], ["south_east", "South-east"]];
  const PATTERNS = ["row_by_row", "skip_rows", "spiral", "shortest"];

  // what rows can run along; the last three as far as the field has them on the map
  const ROWS = { "": "As planted", best_angle: "Best angle", along_edge: "Along the edge", ab_line: "A-B line", guide_line: "Guide line", recorded_rows: "Recorded rows" };
  const ALONG = { best_angle: " at the best angle", along_edge: " along the edge", ab_line: " along the A-B line", guide_line: " along the guide line", recorded_rows: " along the recorded ones" };
  const DRAWN = ["ab_line", "guide_line", "recorded_rows"];

  const AT_FIELD = "@field"; // no feature of a map has such an id
  const FAR_M = 3000;
  const METRES_PER_DEGREE = 111320;

  // metres from a robot to the nearest corner of a field, 0 on it
  function awayM(geometry, { lon, lat }) {
    const wide = Math.cos((lat * Math.PI) / 180);
    const parts = geometry?.type === "Polygon" ? [geometry.coordinates] : geometry?.coordinates ?? [];
    let nearest = Infinity;
    for (const [ring] of parts) {
      let isOn = false;
      ring.forEach(([x, y], k) => {
        const [px, py] = ring[(k || ring.length) - 1];
        if (y > lat !== py > lat && lon < ((px - x) * (lat - y)) / (py - y) + x) isOn = !isOn;
        nearest = Math.min(nearest, Math.hypot((x - lon) * wide, y - lat) * METRES_PER_DEGREE);
      });
      if (isOn) return 0;
    }
    return nearest;
  }

  const byName = (a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }); // bay 2 before bay 10
  const options = (rows) => rows.map(({ id, name }) => el("option", { value: id }, name));
  const later = () => el("option", { value: "" }, "Choose later"); // for a draft: nothing is planned without
  const select = (hook, name, rows) => el("select", { class: "h-select", "data-testid": hook, name }, ...rows);
  const number = (hook, name, props) => el("input", { class: "h-input", "data-testid": hook, name, type: "number", inputmode: "decimal", step: "any", ...props });
  const field = (label, input) => el("label", { class: "h-field" }, label, input);

  // what one pass of the tool takes, in whole rows as the field was planted; metres, null if neither is known
  function usualWidth(tool, spacing) {
    if (!tool) return spacing ? Math.max(spacing, 0.5) : null;
    return spacing && spacing < tool ? Number((Math.floor(tool / spacing + 1e-9) * spacing).toFixed(3)) : tool;
  }

  // laps that fill the headland the map has for a field; "" leaves them to the planner
  const usualLaps = (headland, width) => (headland > 0 && width > 0 ? String(Math.min(Math.max(Math.round(headland / width), 1), 50)) : "");

  // one of a few, as buttons; reads and writes like an input
  class Choice {
    constructor(hook, label, rows, value) {
      this.rows = rows;
      this.node = el("div", { class: "h-seg p-seg", role: "group", "aria-label": label, "data-testid": hook }, ...rows.map(([key, word]) => el("button", { type: "button", "data-testid": `${hook}-${key.replace("_", "-") || "any"}`, onclick: () => this.pick(key) }, word)));
      this.value = value;
    }
    get value() {
      return this.held;
    }
    set value(value) {
      this.held = this.rows.some(([key]) => key === value) ? value : this.rows[0][0];
      [...this.node.children].forEach((button, k) => button.setAttribute("aria-pressed", this.rows[k][0] === this.held ? "true" : "false"));
    }
    pick(value) {
      this.value = value;
      this.node.dispatchEvent(new Event("input", { bubbles: true }));
    }
    focus() {
      this.node.firstElementChild.focus();
    }
  }

  class Inputs {
    // draft: of the server, with its wish; it is kept there, not in this browser
    constructor(places, draft = null) {
      this.places = places;
      this.draft = draft;
      this.all = {
        field_id: select("plan-field", "field_id", [...options([...places.fields].sort(byName)), later()]),
        robot_id: select("plan-robot", "robot_id", [...options(places.robots), later()]),
        home_id: select("plan-home", "home_id", [el("option", { value: "" }, "Own or nearest"), ...options([...places.homes].sort(byName)), el("option", { value: AT_FIELD }, "None: starts at the field")]),
        width_m: number("plan-width", "width_m", { min: "0.05", max: "50", required: true, value: "3" }),
        row_speed_mps: number("plan-speed", "row_speed_mps", { min: "0.01", max: "20", placeholder: "usual" }),
        overlap: number("plan-overlap", "overlap", { min: "0", max: "50", placeholder: "0" }),
        headland_passes: number("plan-headland", "headland_passes", { min: "0", max: "50", step: "1", placeholder: "as needed" }),
        row_bearing_deg: number("plan-bearing", "row_bearing_deg", { min: "-360", max: "360", placeholder: "as planted" }),
        rows: select("plan-rows-along", "rows", []),
        plant_spacing_m: number("plan-spacing", "plant_spacing_m", { min: "0.05", max: "100", placeholder: "usual" }),
        name: el("input", { class: "h-input", "data-testid": "plan-name", name: "name", maxlength: "80", placeholder: "field and width", autocomplete: "off" }),
        returns_home: el("input", { type: "checkbox", name: "returns_home", "data-testid": "plan-return", checked: true }),
        pattern: new Choice("plan-pattern", "Pattern", PATTERNS.map((key) => [key, HL.planner.NAMES[key]]), "shortest"),
        start_corner: select("plan-corner", "start_corner", CORNERS.map(([value, word]) => el("option", { value }, word))),
      };
      this.spacing = field("Plant spacing, m", this.all.plant_spacing_m);
      this.wayBack = el("span", { "data-testid": "plan-return-word" }, "Drive home at the end");
      this.bearing = field("Row direction, ° from north", this.all.row_bearing_deg);
      this.all.rows.addEventListener("input", () => this.offerRows());
      this.all.width_m.addEventListener("input", () => this.offerLaps());
      this.all.home_id.addEventListener("input", () => this.offerReturn());
      this.offerRows();
      this.recall();
    }

    where() {
      return [el("div", { class: "p-two" }, field("Robot", this.all.robot_id), field("Home", this.all.home_id)), el("label", { class: "h-check" }, this.all.returns_home, this.wayBack)];
    }

    how() {
      const i = this.all;
      const group = (label, input) => el("div", { class: "h-field" }, label, input);
      return [group("Pattern", i.pattern.node), el("div", { class: "p-two" }, field("Working width, m", i.width_m), field("Speed on rows, m/s", i.row_speed_mps), field("Overlap, %", i.overlap), field("Headland laps", i.headland_passes), field("Rows", i.rows), this.bearing, field("Start corner", i.start_corner), this.spacing), field("Name", i.name)];
    }

    get fieldPlace() {
      return this.places.fields.find((one) => one.id === this.all.field_id.value);
    }

    get robot() {
      return this.places.robots.find((one) => one.id === this.all.robot_id.value);
    }

    get home() {
      return this.places.homes.find((one) => one.id === this.all.home_id.value);
    }

    offerWidth() {
      const width = usualWidth(this.robot?.tool_width_m, this.fieldPlace?.properties?.row_spacing_m);
      if (width) this.all.width_m.value = String(width);
      this.offerLaps();
    }

    // follows field and width until somebody enters laps; in the air there is no headland
    offerLaps() {
      const laps = this.all.headland_passes;
      if (laps.value !== (this.laps ?? "")) return;
      laps.value = this.laps = this.flies ? "" : usualLaps(this.fieldPlace?.properties?.headland_m, Number(this.all.width_m.value));
    }

    // without a home there is no way back to it
    offerReturn() {
      this.all.returns_home.disabled = this.all.home_id.value === AT_FIELD;
    }

    startAtField() {
      this.all.home_id.value = AT_FIELD;
      this.all.home_id.dispatchEvent(new Event("input", { bubbles: true }));
    }

    // as long as nobody chose a field, the one where the robot stands; one of another site is of no use to it
    offerField() {
      const robot = HL.port.fleet()[this.all.robot_id.value];
      if (robot?.lat === null || robot?.lat === undefined) return false;
      const away = (one) => awayM(one.geometry, robot);
      if (this.fieldPlace && (this.isKept || this.isFieldChosen) && !(away(this.fieldPlace) > FAR_M)) return false;
      const nearest = this.places.fields.map((one) => [away(one), one.id]).filter(([far]) => far <= FAR_M).sort((a, b) => a[0] - b[0])[0]?.[1];
      if (!nearest || nearest === this.all.field_id.value) return false;
      this.all.field_id.value = nearest;
      return true;
    }

    // only planters plant, and UAVs fly; HL.port knows the family as soon as the robot was heard
    offerSpacing() {
      const family = HL.port.fleet()[this.all.robot_id.value]?.family ?? this.robot?.family;
      this.spacing.hidden = family !== "planter";
      const flew = this.flies;
      this.flies = family === "uav";
      HL.text(this.wayBack, `${this.flies ? "Fly" : "Drive"} home at the end`);
      if (this.flies !== flew) this.offerLaps();
    }

    // what this field's rows can run along; a direction in degrees only where nothing else gives it
    offerRows(wanted = this.all.rows.value) {
      const lines = this.fieldPlace?.lines ?? {};
      const offered = Object.entries(ROWS).filter(([key]) => !DRAWN.includes(key) || lines[key]);
      this.all.rows.replaceChildren(...offered.map(([value, word]) => el("option", { value }, value === "recorded_rows" ? `${word} (${lines[value]})` : word)));
      this.all.rows.value = offered.some(([key]) => key === wanted) ? wanted : "";
      this.bearing.hidden = this.all.rows.value !== "";
    }

    recall() {
      if (this.draft) {
        this.isKept = true;
        this.all.field_id.value = this.all.robot_id.value = "";
        const { wish, name } = this.draft;
        const isOwn = name !== this.places.fields.find((one) => one.id === wish.field_id)?.name; // else it goes on following the field
        return this.apply({ ...wish, name: isOwn ? name : "" });
      }
      const kept = HL.draft.get(DRAFT);
      this.isKept = Boolean(kept);
      this.laps = kept?.laps; // offered before, not entered: they go on following the field
      this.fill(kept || {});
    }

    fill(kept) {
      for (const [key, input] of Object.entries(this.all)) {
        if (!(key in kept)) continue;
        if (key === "rows") this.offerRows(kept.rows);
        else if (input.type === "checkbox") input.checked = kept[key] === true;
        else if (!(input instanceof HTMLSelectElement) || [...input.options].some((option) => option.value === kept[key])) input.value = kept[key];
      }
      this.offerReturn();
    }

    keep() {
      if (!this.draft) HL.draft.set(DRAFT, { laps: this.laps, ...Object.fromEntries(Object.entries(this.all).map(([key, input]) => [key, input.type === "checkbox" ? input.checked : input.value])) });
    }

    forget() {
      if (!this.draft) HL.draft.clear(DRAFT);
    }

    wish() {
      const i = this.all;
      const body = { field_id: i.field_id.value, robot_id: i.robot_id.value, width_m: Number(i.width_m.value), returns_home: i.returns_home.checked && !i.returns_home.disabled };
      if (i.returns_home.disabled) body.starts_at = "field";
      else if (i.home_id.value) body.home_id = i.home_id.value;
      if (i.pattern.value !== "shortest") body.pattern = i.pattern.value;
      if (i.start_corner.value) body.start_corner = i.start_corner.value;
      if (i.name.value.trim()) body.name = i.name.value.trim();
      if (i.rows.value) body.rows = i.rows.value;
      for (const key of ["row_bearing_deg", "row_speed_mps"]) if (i[key].value !== "" && !(key === "row_bearing_deg" && i.rows.value)) body[key] = Number(i[key].value);
      if (i.headland_passes.value !== "") body.headland_passes = Math.round(Number(i.headland_passes.value));
      if (i.overlap.value !== "" && Number(i.overlap.value)) body.overlap = Number(i.overlap.value) / 100;
      if (!this.spacing.hidden && i.plant_spacing_m.value !== "") body.plant_spacing_m = Number(i.plant_spacing_m.value);
      return body;
    }

    // what is missing before anything can be planned: [input, sentence], null if nothing is
    missing() {
      if (!this.all.robot_id.value) return ["robot_id", "Choose a robot, or save it as a draft."];
      return this.all.field_id.value ? null : ["field_id", "Choose a field, or save it as a draft."];
    }

    // a template's wish into the inputs; what it does not say goes back to its usual value
    apply(wish) {
      this.isFieldChosen ||= Boolean(wish.field_id);
      const usual = { row_speed_mps: "", headland_passes: "", row_bearing_deg: "", rows: "", plant_spacing_m: "", name: "", start_corner: "", pattern: "shortest", returns_home: true };
      const given = Object.fromEntries(Object.entries(wish).filter(([key]) => key in this.all).map(([key, value]) => [key, typeof value === "number" ? String(value) : value ?? ""]));
      const home = wish.starts_at === "field" ? AT_FIELD : wish.home_id ?? (this.all.returns_home.disabled ? "" : this.all.home_id.value);
      this.fill({ ...usual, ...given, home_id: home, overlap: wish.overlap ? String(Number((100 * wish.overlap).toFixed(2))) : "" });
    }

    get(name) {
      return this.all[name];
    }
  }

  Object.assign(HL.planner, { Inputs, usualLaps, usualWidth, ALONG, CORNERS: Object.fromEntries(CORNERS) });
})();
