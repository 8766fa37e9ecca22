// A registered robot in hand: what an admin may change of it. Only what was changed is sent; a token is never shown.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const KINDS = ["weeder", "planter", "uav", "other"];
  const TAKEN_AWAY = new Set(["http_url", "contact_name", "contact_phone"]); // empty means: there is none

  const FIELDS = [
    ["name", "Name", { required: true, maxlength: "80" }],
    ["family", "Kind", {}],
    ["http_url", "Its HTTP address", { placeholder: "http://10.0.0.17:8090", inputmode: "url", maxlength: "300" }],
    ["http_token", "Its token", { type: "password", autocomplete: "new-password", maxlength: "200" }],
    ["contact_name", "Contact on site", { maxlength: "80" }],
    ["contact_phone", "Phone", { type: "tel", maxlength: "40" }],
    ["keep_out_m", "People stay away, m (its factsheet may ask for more)", { type: "number", inputmode: "decimal", min: "1", max: "1000", step: "any" }],
  ];

  class RobotSheet {
    constructor(robot, done) {
      Object.assign(this, { robot, done, inputs: {}, wrong: {} });
      const rows = FIELDS.map(([key, label, options]) => this.row(key, label, options));
      this.inputs.http_token.placeholder = robot.has_http_token ? "set; leave empty to keep it" : "none";
      this.noToken = this.check("No token: take the one away that is set", "robot-edit-no-token", false);
      this.noToken.label.hidden = !robot.has_http_token;
      this.unattended = this.check("May run without a person", "robot-edit-unattended", robot.is_unattended_allowed === true);
      this.problem = el("div", { class: "h-error", role: "alert", "data-testid": "robot-edit-error" });
      this.form = el("form", { class: "h-col", novalidate: true, onsubmit: (event) => (event.preventDefault(), this.save()) },
        el("div", { class: "h-restgrid" }, ...rows), this.noToken.label, this.unattended.label,
        el("p", { class: "h-t13 h-2" }, "Then its queue may start missions marked unattended, for the hours somebody arms it for. Off: only a person who slides starts it."), this.problem);
      this.close = HL.sheet({ title: `Change ${robot.name}`, hook: "robot-edit", body: [this.form], buttons: [["Keep it as it is", (close) => close()], ["Save", () => this.save(), true]] });
      this.button = document.querySelector("[data-testid=robot-edit] .foot .pri");
      attr(this.button, "data-testid", "robot-edit-save");
    }

    row(key, label, options) {
      const value = String(this.robot[key] ?? "");
      const input = key === "family"
        ? el("select", { class: "h-select" }, ...KINDS.map((one) => el("option", { value: one }, one)))
        : el("input", { class: "h-input", autocomplete: "off", ...options });
      attr(input, "data-testid", `robot-edit-${key.replaceAll("_", "-")}`);
      if (key !== "http_token") input.value = value;
      this.inputs[key] = input;
      this.wrong[key] = el("span", { class: "h-error", id: `robot-wrong-${key}` });
      return el("label", { class: "h-field" }, label, input, this.wrong[key]);
    }

    check(words, hook, isOn) {
      const input = el("input", { type: "checkbox", "data-testid": hook });
      input.checked = isOn;
      return { input, label: el("label", { class: "h-check" }, input, words) };
    }

    changes() {
      const found = {};
      for (const [key, input] of Object.entries(this.inputs)) {
        const value = input.value.trim();
        if (key === "http_token" ? value : value !== String(this.robot[key] ?? "")) found[key] = value === "" && TAKEN_AWAY.has(key) ? null : key === "keep_out_m" ? Number(value) : value;
      }
      if (this.noToken.input.checked) found.http_token = null;
      if (this.unattended.input.checked !== (this.robot.is_unattended_allowed === true)) found.is_unattended_allowed = this.unattended.input.checked;
      return found;
    }

    async save() {
      this.tell("", "");
      const changes = this.changes();
      if (changes.name === "") return this.tell("A robot needs a name.", "name");
      if (changes.keep_out_m !== undefined && !(changes.keep_out_m >= 1 && changes.keep_out_m <= 1000)) return this.tell("Say 1 to 1000 m.", "keep_out_m");
      if (this.noToken.input.checked && this.inputs.http_token.value.trim()) return this.tell("Enter a token, or take the one away that is set; not both.", "http_token");
      if (!Object.keys(changes).length) return this.close();
      this.button.disabled = true;
      const answer = await HL.port.api("PATCH", `/robots/${encodeURIComponent(this.robot.id)}`, changes);
      this.button.disabled = false;
      if (!answer.ok) return this.tell(`Not saved: ${answer.text || "no answer. Look before you save again."}`, answer.field);
      this.close();
      HL.toast(`${answer.data.name} is changed`, "check");
      return this.done();
    }

    tell(words, field) {
      for (const [key, input] of Object.entries(this.inputs)) {
        const isIt = Boolean(words) && key === field;
        text(this.wrong[key], isIt ? words : "");
        attr(input, "aria-invalid", isIt ? "true" : null);
        attr(input, "aria-describedby", isIt ? this.wrong[key].id : null);
      }
      text(this.problem, this.inputs[field] ? "" : words);
      this.inputs[field]?.focus();
    }
  }

  HL.editRobot = (robot, done) => new RobotSheet(robot, done);
})();
