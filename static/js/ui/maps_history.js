// What changed about a feature over the published versions, and from which day its values hold.
(() => {
  "use strict";
  const { el, text } = HL;
  const M = HL.maps;
  const DATED = ["crop", "species", "status", "seeded", "row_spacing_m", "row_bearing_deg", "headland_m"];

  const fieldOf = (key, fields) => fields.find((one) => one.key === key);

  // a value as the panel would show it, with its unit
  function words(value, field) {
    if (value === null || value === undefined || value === "") return "–";
    if (!field) return typeof value === "object" ? "other values" : String(value);
    const unit = field.type === "number" && field.unit ? ` ${field.unit}` : "";
    return `${M.told(field, value)}${unit}`;
  }

  function row(one, fields) {
    const field = fieldOf(one.key, fields);
    const label = field?.label ?? one.label;
    const isFirst = [undefined, null, "", one.after].includes(one.before);
    const head = one.key ? (isFirst ? `${label}: ${words(one.after, field)}` : `${label}: ${words(one.before, field)} to ${words(one.after, field)}`) : one.label;
    const valid = one.valid_from ? `valid from ${HL.words.date(new Date(`${one.valid_from}T00:00`))}` : "";
    const line = [`v${one.version}`, HL.records.when(one.published_utc), one.by, one.note, valid].filter(Boolean).join(" · ");
    return el("div", { class: "m-item m-past", "data-testid": `history-${one.key || "feature"}-${one.version}` }, el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b" }, head), el("div", { class: "h-t13 h-2" }, line)));
  }

  // days from which the values hold that are in the draft now
  function days(feature, fields, act) {
    const set = DATED.filter((key) => feature.properties[key] !== undefined && fieldOf(key, fields));
    if (!set.length || M.kindOf(feature) !== "parcel") return [];
    const inputs = set.map((key) => {
      const field = fieldOf(key, fields);
      const made = M.input({ key, hook: `valid-from-${key.replaceAll("_", "-")}`, label: `${field.label}, ${words(feature.properties[key], field)}`, type: "date" }, (day) => act.setDay(key, day));
      made.set(feature.properties.valid_from?.[key]);
      made.allow(act.canEdit);
      return made.node;
    });
    return [el("h3", { class: "h-t16 h-b" }, "Valid from"), el("p", { class: "h-t14 h-2" }, act.canEdit ? "Without a day a value holds from when it was published." : act.reason), el("div", { class: "m-form" }, ...inputs)];
  }

  // act: {canEdit, reason, setDay(key, day or null)}
  function showHistory(id, feature, act) {
    const fields = [...M.fieldsOf(feature), ...M.moreOf(feature)];
    const place = el("div", { class: "m-items" });
    const choice = el("select", { class: "h-select", "aria-label": "Show", "data-testid": "history-choice" }, el("option", { value: "" }, "Everything"), ...fields.filter((one) => DATED.includes(one.key)).map((one) => el("option", { value: one.key }, one.label)));
    HL.sheet({ title: `${M.nameOf(feature)}: what changed`, hook: "history", body: [...days(feature, fields, act), el("div", { class: "h-row" }, el("h3", { class: "h-t16 h-b h-sp" }, "Published"), choice), place], buttons: [["Close", (close) => close(), true]] });
    const draw = (answer) => {
      const all = answer.entries ?? [];
      const shown = all.filter((one) => !choice.value || one.key === choice.value);
      choice.onchange = () => place.replaceChildren(...draw(answer));
      if (!shown.length) return [HL.records.empty("Nothing changed", all.length ? "No published map changed this value." : "It stands on no published map yet.")];
      return shown.map((one) => row(one, fields));
    };
    HL.port.api("GET", `/map/features/${id}/history`).then((answer) => {
      if (!place.isConnected) return;
      if (answer.ok || answer.status === 404) place.replaceChildren(...draw(answer.ok ? answer : { entries: [] }));
      else HL.records.load(place, "The history", `/map/features/${id}/history`, draw);
    });
    text(place, "Loading");
  }

  // a feature with another value of an attribute: a day given for the old value says nothing about the new one
  function withValue(feature, key, value) {
    const after = M.withProperty(feature, key, value);
    if (feature.properties.valid_from?.[key] === undefined) return after;
    return withDay(after, key, null);
  }

  function withDay(feature, key, day) {
    const kept = { ...feature.properties.valid_from, [key]: day };
    if (day === null) delete kept[key];
    return M.withProperty(feature, "valid_from", Object.keys(kept).length ? kept : null);
  }

  Object.assign(HL.maps, { showHistory, withValue, withDay });
})();
