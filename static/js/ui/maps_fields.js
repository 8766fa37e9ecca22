// Inputs of a feature's attributes: each takes a stored value, shows it in the person's unit, and gives it back checked.
(() => {
  "use strict";
  const { el, attr } = HL;
  const { shown, stored, bounds } = HL.maps;
  let lists = 0;

  // input(field, onValue(stored or null), features by id) -> {node, set(value), allow(isOn), back()}
  function input(field, onValue, features) {
    const hook = field.hook ?? `feature-${field.key.replaceAll("_", "-")}`;
    const isChoice = field.type === "choice";
    const options = isChoice ? (typeof field.options === "function" ? field.options(features) : field.options) : [];
    const control = isChoice
      ? el("select", { class: "h-select", "data-testid": hook }, ...options.map(([value, word]) => el("option", { value }, word)))
      : el("input", { class: "h-input", "data-testid": hook, type: field.type === "date" ? "date" : "text", inputmode: field.type === "number" ? "decimal" : null, maxlength: field.type === "text" ? "120" : null, autocomplete: "off" });
    let offers = "";
    if (field.offers) {
      lists += 1;
      offers = el("datalist", { id: `m-offers-${lists}` }, ...field.offers.map((value) => el("option", { value })));
      control.setAttribute("list", offers.id);
    }
    let now = "";
    control.addEventListener("change", () => {
      const value = stored(field, control.value);
      if (value === undefined) {
        HL.toast(bounds(field), "block");
        control.value = now;
        return;
      }
      if (shown(field, value) !== now) onValue(value);
    });
    control.addEventListener("keydown", (event) => event.key === "Enter" && control.blur());
    const set = (value) => {
      now = shown(field, value);
      if (isChoice && now && !options.some(([option]) => option === now)) {
        const word = field.gone ?? now;
        options.push([now, word]);
        control.append(el("option", { value: now }, word));
      }
      if (document.activeElement !== control || isChoice) control.value = now;
      attr(control, "data-value", value ?? null);
    };
    const unit = field.unit ? el("span", { class: "m-unit" }, field.unit) : "";
    const node = el("label", { class: "h-field" }, el("span", { class: "m-label" }, field.label), el("span", { class: "m-inp" }, control, unit), offers);
    return { node, set, control, allow: (isOn) => attr(control, "disabled", !isOn), back: () => (control.value = now) };
  }

  HL.maps.input = input;
})();
