// Planning choices kept under a name: save, apply, rename, delete.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const of = (id) => `/plan-templates/${encodeURIComponent(id)}`;

  function nameSheet(title, value, verb, done, ...more) {
    const input = el("input", { class: "h-input", maxlength: "80", autofocus: true, "data-testid": "template-name", autocomplete: "off" });
    const problem = el("div", { class: "h-error", role: "alert", "data-testid": "template-error" });
    input.value = value;
    const run = async (close) => {
      const name = input.value.trim();
      if (!name) return text(problem, "Give it a name.");
      const answer = await done(name);
      if (!answer.ok) return text(problem, answer.code === "already_exists" ? "There is a template of this name. Choose another." : answer.text || "Not saved: no answer. Try again.");
      close();
    };
    HL.sheet({ title, body: [el("label", { class: "h-field" }, "Name", input), ...more, problem], buttons: [["Cancel", (close) => close()], [verb, run, true]] });
  }

  // wish: what a planning request carries; field and robot only if wished
  function save(wish, suggested) {
    const isBound = el("input", { type: "checkbox", "data-testid": "template-bound" });
    const body = () => {
      const { field_id, robot_id, home_id, ...choices } = wish;
      return isBound.checked ? wish : choices;
    };
    nameSheet("Save as template", suggested, "Save", async (name) => {
      const answer = await HL.port.api("POST", "/plan-templates", { name, wish: body() });
      if (answer.ok) HL.toast(`Template ${name} is saved`, "check");
      return answer;
    }, el("label", { class: "h-check" }, isBound, "With this field, robot and home"));
  }

  async function choose(apply) {
    const list = el("div", { class: "p-templates" });
    const close = HL.sheet({ title: "Templates", hook: "templates", body: [list], buttons: [["Close", (done) => done()]] });
    const fill = async () => {
      list.replaceChildren(el("div", { class: "h-skeleton", "aria-label": "Loading templates" }, el("i"), el("i")));
      const answer = await HL.port.api("GET", "/plan-templates");
      if (!list.isConnected) return;
      if (!answer.ok) return list.replaceChildren(el("div", { class: "h-notice", role: "alert" }, el("b", {}, "Templates did not load"), el("span", { class: "h-2" }, answer.text), el("button", { type: "button", class: "h-btn", onclick: fill }, icon("refresh", "m"), "Try again")));
      if (!answer.templates.length) return list.replaceChildren(el("p", { class: "h-2 h-t16" }, "No templates yet. Plan a mission and save its choices here."));
      list.replaceChildren(...answer.templates.map((one) => row(one, fill, () => (close(), apply(one)))));
    };
    fill();
  }

  function row(template, again, use) {
    const rename = () => nameSheet(`Rename ${template.name}`, template.name, "Rename", (name) => HL.port.api("PATCH", of(template.id), { name }));
    const remove = async () => {
      const answer = await HL.port.api("DELETE", of(template.id));
      HL.toast(answer.ok ? `Template ${template.name} is deleted` : `Not deleted: ${answer.text || "no answer"}`, answer.ok ? "check" : "block");
      again();
    };
    const wish = template.wish;
    const line = [`${wish.width_m} m`, HL.planner.NAMES[wish.pattern ?? "shortest"], wish.field_id ? "with field and robot" : "any field"].join(" · ");
    return el("div", { class: "h-row p-template", "data-testid": `template-${template.id}` },
      el("button", { type: "button", class: "h-btn h-sp p-use", onclick: use }, el("span", { class: "h-col" }, el("b", { class: "h-t16" }, template.name), el("span", { class: "h-t13 h-2" }, line))),
      el("button", { type: "button", class: "h-btn ico", "aria-label": `Rename ${template.name}`, onclick: rename }, icon("edit", "m")),
      el("button", { type: "button", class: "h-btn ico", "aria-label": `Delete ${template.name}`, onclick: remove }, icon("delete", "m")));
  }

  HL.planner.templates = { save, choose };
})();
