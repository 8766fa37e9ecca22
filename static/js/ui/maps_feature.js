// Panel of what is chosen on the map: measures, attributes, the chosen corner; without a choice, what the farm has.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const STEPS = [["Left", "arrow_back", -1, 0], ["Up", "arrow_upward", 0, 1], ["Down", "arrow_downward", 0, -1], ["Right", "arrow_forward", 1, 0]];
  const STEP_M = 0.1;
  const MANY = 12; // fields that no list shows at once

  const stat = (label, hook) => {
    const figure = el("span");
    const unit = el("small");
    const node = el("div", { class: "h-card m-stat", "data-testid": hook }, el("div", { class: "h-h" }, label), el("div", { class: "h-t22 h-b" }, figure, unit));
    return { node, set: (value, words, note = "") => { attr(node, "hidden", value === null); attr(node, "data-value", value); text(figure, words?.text ?? ""); text(unit, words?.unit || note); } };
  };

  // as the planner takes them: what says it is, or lines that say nothing
  const isRecorded = ({ properties, geometry }) => (properties.type ? properties.type === "recorded" : geometry.type === "MultiLineString" && geometry.coordinates.length > 1);

  // act: {commit(label, changes), select(ids), fit(ids), copy, remove, nudge, removeVertex, setVertex, unlockBody, several, merge, start(tool), pick, reshape(id), history(id)}
  class FeaturePanel {
    constructor(act) {
      this.act = act;
      this.node = el("section", { class: "m-feature", "aria-label": "Chosen" });
      this.key = null;
    }

    paint({ features, chosen, canEdit, point, farm, isSeveral, isUnlocked, revision }) {
      this.features = features;
      const found = chosen.map((id) => features.get(id)).filter(Boolean);
      const kind = found.length === 1 ? `${found[0].id ?? found[0].properties.id}|${M.kindOf(found[0])}|${found[0].geometry.type}` : `${found.length}|${found.map((one) => one.id).join()}`;
      const key = `${kind}|${canEdit}`;
      if (key !== this.key) {
        this.key = key;
        this.one = null;
        if (found.length === 1) this.build(found[0], canEdit);
        else if (found.length) this.buildSeveral(found, canEdit);
        else this.buildFarm(farm);
      }
      if (this.one) this.fill(found[0], canEdit, point, isSeveral, isUnlocked);
      else if (!found.length) this.fillFarm(revision);
    }

    head(name, line, ...buttons) {
      return el("div", { class: "h-row m-head" }, el("div", { class: "h-sp h-ell" }, name, line), ...buttons);
    }

    tool(hook, sign, word, run, canEdit) {
      return el("button", { type: "button", class: "h-btn ico", "data-testid": hook, title: word, "aria-label": word, disabled: !canEdit, onclick: run }, icon(sign, "m"));
    }

    build(feature, canEdit) {
      const id = feature.id ?? feature.properties.id;
      this.name = el("input", { class: "m-name h-ell", "data-testid": "feature-name", "aria-label": "Name", maxlength: M.NAME_CHARS, autocomplete: "off", readonly: !canEdit, onchange: () => this.rename(), onkeydown: (event) => event.key === "Enter" && this.name.blur() });
      this.line = el("div", { class: "h-t13 h-2" });
      this.stats = { area: stat("Area", "editor-area"), edge: stat(feature.geometry.type === "Polygon" ? "Edge" : "Length", "editor-edge"), rows: stat("Rows", "editor-rows") };
      const field = (one) => M.input(one, (value) => this.set(one, value), this.features);
      const kindField = { key: "kind", label: "Kind", type: "choice", options: M.kindsFor(feature).map((kind) => [kind, M.label(kind)]) };
      this.inputs = new Map();
      const make = (one) => {
        const made = field(one);
        this.inputs.set(one, made);
        made.allow(canEdit);
        return made.node;
      };
      const more = M.moreOf(feature);
      this.one = id;
      this.corner = this.buildCorner(canEdit);
      this.node.replaceChildren(
        this.head(this.name, this.line, ...(M.kindOf(feature) === "parcel" ? [this.tool("feature-history", "history", "What changed", () => this.act.history(id), true)] : []), this.tool("feature-copy", "content_copy", "Copy", () => this.act.copy(), canEdit), this.tool("feature-delete", "delete", "Delete", () => this.act.remove(), canEdit)),
        el("div", { class: "m-stats" }, ...Object.values(this.stats).map((one) => one.node)),
        el("div", { class: "m-form" }, ...M.fieldsOf(feature).map(make), ...(this.inputs.size % 2 || !this.inputs.size ? [make(kindField)] : [])),
        ...(canEdit && M.canReshape(feature) ? [el("button", { type: "button", class: "h-btn m-change", "data-testid": "feature-reshape", onclick: () => this.act.reshape(id) }, icon("polyline", "m"), "Change shape…")] : []),
        this.corner,
        el("details", { class: "m-more" }, el("summary", {}, "More"), el("div", { class: "m-form" }, ...([...this.inputs.keys()].includes(kindField) ? [] : [make(kindField)]), ...more.map(make)), ...(canEdit ? [this.buildMove()] : [])),
      );
    }

    buildMove() {
      this.body = el("input", { type: "checkbox", "data-testid": "feature-unlock", onchange: () => this.act.unlockBody(this.body.checked) });
      this.many = el("input", { type: "checkbox", "data-testid": "feature-several", onchange: () => this.act.several(this.many.checked) });
      return el("div", { class: "m-moves" }, el("label", { class: "h-check" }, this.body, "Drag the whole shape"), el("label", { class: "h-check" }, this.many, "Choose several"));
    }

    buildCorner(canEdit) {
      const degrees = (key, label, most) => M.input({ key, hook: key, label, type: "number", unit: "°", least: -most, most, digits: 8 }, () => this.setCorner());
      this.lat = degrees("corner-lat", "Latitude", 90);
      this.lon = degrees("corner-lon", "Longitude", 180);
      const steps = STEPS.map(([word, sign, x, y]) => this.tool(`corner-${word.toLowerCase()}`, sign, `${word} 0.1 m`, () => this.act.nudge(x * STEP_M, y * STEP_M), canEdit));
      return el("div", { class: "m-corner", hidden: true, "data-testid": "feature-corner" }, el("div", { class: "h-t16 h-b" }, "Chosen corner"), el("div", { class: "m-form" }, this.lat.node, this.lon.node), el("div", { class: "h-row" }, ...steps, el("span", { class: "h-t13 h-2 h-nw" }, "0.1 m"), el("span", { class: "h-sp" }), this.tool("corner-remove", "delete", "Remove corner", () => this.act.removeVertex(), canEdit)));
    }

    setCorner() {
      const typed = [this.lat, this.lon].map((one) => one.control.value.trim());
      if (typed.includes("")) return void [this.lat, this.lon].forEach((one) => one.back());
      const [lat, lon] = typed.map((one) => Number(one.replace(",", ".")));
      if (Number.isFinite(lat) && Number.isFinite(lon)) this.act.setVertex([lon, lat]);
    }

    fill(feature, canEdit, point, isSeveral, isUnlocked) {
      const holes = M.holes(feature);
      if (document.activeElement !== this.name) this.name.value = M.nameOf(feature);
      text(this.line, [M.label(M.kindOf(feature)), M.count(M.corners(feature), feature.geometry.type === "Polygon" ? "corner" : "point"), holes ? M.count(holes, "hole") : ""].filter(Boolean).join(", "));
      const [area, length, rows] = [M.areaM2(feature), M.lengthM(feature), M.kindOf(feature) === "parcel" ? this.rows(feature) : null];
      this.stats.area.set(area, area === null ? null : M.area(area));
      this.stats.edge.set(length, length === null ? null : M.length(length));
      this.stats.rows.set(rows?.n ?? null, rows && { text: String(rows.n) }, rows?.isGuess ? "fit" : "");
      for (const [one, made] of this.inputs) made.set(feature.properties[one.key]);
      attr(this.corner, "hidden", !point || !canEdit);
      if (point) {
        this.lon.set(point[0]);
        this.lat.set(point[1]);
      }
      if (this.many) this.many.checked = isSeveral;
      if (this.body) this.body.checked = isUnlocked;
    }

    rows(feature) {
      // rows as they stand; an A-B or guide line is the direction of many
      const drawn = [...this.features.values()].filter((one) => M.kindOf(one) === "rows" && one.properties.parcel_id === this.one && isRecorded(one));
      if (drawn.length) return { n: drawn.reduce((sum, one) => sum + (one.geometry.type === "MultiLineString" ? one.geometry.coordinates.length : 1), 0) };
      const fit = M.rowsThatFit(feature);
      return fit === null ? null : { n: fit, isGuess: true };
    }

    rename() {
      const before = this.features.get(this.one);
      const name = this.name.value.trim();
      if (!before || !name || name === M.nameOf(before)) return;
      this.act.commit(`${M.nameOf(before)} renamed ${name}`, [{ id: this.one, before, after: M.withProperty(before, "name", name) }]);
    }

    set(field, value) {
      const before = this.features.get(this.one);
      if (!before) return;
      const kept = field.key === "row_bearing_deg" && value !== null ? ((value % 360) + 360) % 360 : value;
      const isKind = field.key === "kind";
      const label = isKind ? `Kind ${M.label(M.kindOf(before)).toLowerCase()} to ${M.label(kept).toLowerCase()}` : field.key === "parcel_id" ? this.fieldLabel(kept) : M.changeLabel(field, before.properties[field.key], kept);
      this.act.commit(label, [{ id: this.one, before, after: isKind ? M.withKind(before, kept) : M.withValue(before, field.key, kept) }]);
    }

    fieldLabel(id) {
      const parcel = this.features.get(id);
      return parcel ? `Field set to ${M.nameOf(parcel)}` : "Field removed";
    }

    buildSeveral(found, canEdit) {
      const areas = found.filter((one) => one.geometry.type === "Polygon");
      const total = areas.reduce((sum, one) => sum + M.areaM2(one), 0);
      const isOneKind = M.mergeable(areas).length === areas.length;
      const merge = el("button", { type: "button", class: "h-btn", "data-testid": "feature-merge", title: isOneKind ? "" : "Shapes of one kind can be merged", disabled: !canEdit || areas.length < 2 || !isOneKind, onclick: () => this.act.merge() }, icon("merge", "m"), "Merge");
      this.node.replaceChildren(
        this.head(el("h2", { class: "h-t22 h-b", "data-testid": "feature-title" }, `${found.length} chosen`), el("div", { class: "h-t13 h-2" }, total ? `Together ${M.words(M.area(total))}` : ""), merge, this.tool("feature-delete", "delete", "Delete", () => this.act.remove(), canEdit)),
        el("div", { class: "m-list" }, ...found.map((one) => this.row(one))),
      );
    }

    row(feature) {
      const id = feature.id ?? feature.properties.id;
      const area = M.kindOf(feature) === "parcel" ? M.areaM2(feature) : null;
      return el("button", { type: "button", class: "m-row", "data-testid": `feature-row-${id}`, onclick: () => (this.act.select([id]), this.act.fit([id])) }, el("span", { class: "h-ell" }, M.nameOf(feature)), el("span", { class: "h-2 h-t13 h-nw" }, area === null ? M.label(M.kindOf(feature)) : M.words(M.area(area))));
    }

    buildFarm(farm) {
      this.farmLine = el("div", { class: "h-t13 h-2" });
      this.farmList = el("div", { class: "m-list" });
      this.drawn = null;
      this.find = el("input", { class: "h-input", type: "search", placeholder: "Find a field, crop or obstacle", "aria-label": "Find on this map", autocomplete: "off", "data-testid": "feature-find", oninput: () => { this.sought = this.find.value.trim().toLowerCase(); this.listFarm(); } });
      this.find.value = this.sought ?? "";
      this.node.replaceChildren(this.head(el("h2", { class: "h-t22 h-b", "data-testid": "feature-title" }, farm), this.farmLine), this.find, this.farmList);
    }

    fillFarm(revision) {
      if (this.drawn === revision) return;
      this.drawn = revision;
      const parcels = [...this.features.values()].filter((one) => M.kindOf(one) === "parcel").sort((a, b) => M.byName(M.nameOf(a), M.nameOf(b)));
      text(this.farmLine, parcels.length ? `${M.count(parcels.length, "parcel")}, ${M.words(M.area(parcels.reduce((sum, one) => sum + (M.areaM2(one) ?? 0), 0)))}` : "No parcels yet");
      attr(this.find, "hidden", parcels.length < MANY && !this.sought);
      this.listFarm();
    }

    // fields; once somebody looks for something, whatever is called so or grows it
    listFarm() {
      const is = (one) => M.kindOf(one) === "parcel" && !this.sought || this.sought && [M.nameOf(one), M.label(M.kindOf(one)), one.properties.crop ?? ""].some((said) => said.toLowerCase().includes(this.sought));
      const found = [...this.features.values()].filter(is).sort((a, b) => M.byName(M.nameOf(a), M.nameOf(b)));
      const none = el("p", { class: "h-2 h-t14", "data-testid": "feature-none" }, "Nothing on this map is called so.");
      this.farmList.replaceChildren(...found.map((one) => this.row(one)), ...(this.sought && !found.length ? [none] : []));
    }
  }

  HL.maps.FeaturePanel = FeaturePanel;
})();
