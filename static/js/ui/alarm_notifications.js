// Admin: who is told about alarms outside the console. Secrets go in and never come back; a test shows the real answer.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const { table, empty, when } = HL.records;
  const PATH = "/alarms/notifications";
  const TEST_MS = 20000;
  const LEVELS = { 1: "Priority 1", 2: "Priority 1 and 2", 3: "Priority 1 to 3", 4: "All" };
  const KINDS = { webhook: "Web address", smtp: "E-mail" };

  const button = (label, onclick, hook, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick }, ...[label].flat());
  const list = (words) => words.split(/[\s,;]+/).filter(Boolean);

  // [key, label, attributes]; secrets are of type password and sent only when something was written
  const FIELDS = {
    webhook: [["name", "Name", { required: true, maxlength: "80" }], ["url", "Address", { required: true, type: "url", placeholder: "https://…" }], ["secret", "Secret that signs it", { type: "password" }]],
    smtp: [["name", "Name", { required: true, maxlength: "80" }], ["host", "Mail server", { required: true }], ["port", "Port", { type: "number", min: "1", max: "65535", placeholder: "587" }], ["user", "User", {}], ["secret", "Password", { type: "password" }], ["sender", "From", { type: "email", required: true }], ["to", "To, with commas", { required: true }]],
  };

  function input(channel, [key, label, options]) {
    const isSecret = options.type === "password";
    const node = el("input", { class: "h-input", name: key, autocomplete: isSecret ? "new-password" : "off", "data-testid": `notify-${key}`, ...options });
    if (isSecret && channel?.has_secret) node.placeholder = "kept, not shown. Write to replace it";
    else if (!isSecret && channel) node.value = Array.isArray(channel[key]) ? channel[key].join(", ") : channel[key] ?? "";
    return [key, node, el("label", { class: "h-field" }, label, node)];
  }

  function values(inputs) {
    const found = {};
    for (const [key, node] of inputs) {
      const value = node.value.trim();
      if (key === "secret" && !value) continue; // what is kept stays
      if (key === "to") found.to = list(value);
      else if (node.type === "number") found[key] = value ? Number(value) : undefined;
      else found[key] = value;
    }
    return found;
  }

  function edit(kind, channel, save) {
    const inputs = FIELDS[kind].map((field) => input(channel, field));
    const level = el("select", { class: "h-select", "data-testid": "notify-level" }, ...Object.entries(LEVELS).map(([value, label]) => el("option", { value }, label)));
    level.value = String(channel?.priority ?? 2);
    const isOn = el("input", { type: "checkbox", "data-testid": "notify-on" });
    isOn.checked = channel?.is_on ?? true;
    const problem = el("div", { class: "h-error", role: "alert", "data-testid": "notify-problem" });
    const done = async (close) => {
      const bad = inputs.find(([, node]) => !node.checkValidity());
      if (bad) return text(problem, `${bad[2].firstChild.textContent}: ${bad[1].validationMessage}`), bad[1].focus();
      const answer = await save({ ...channel, kind, ...values(inputs), priority: Number(level.value), is_on: isOn.checked });
      if (answer.ok) return close();
      text(problem, answer.text || "Not saved.");
      return undefined;
    };
    HL.sheet({ title: `${channel ? "Change" : "Add"}: ${KINDS[kind]}`, hook: "notify-sheet", body: [...inputs.map(([, , label]) => label), el("label", { class: "h-field" }, "Tell about", level), el("label", { class: "h-check" }, isOn, "Switched on"), problem], buttons: [["Leave it", (close) => close()], ["Save", done, true]] });
  }

  const last = (one) => (one ? `${one.ok ? "Delivered" : "Failed"} ${when(one.at)}${one.text ? `: ${one.text}` : ""}` : "Nothing sent yet");

  class Panel {
    constructor(place) {
      this.rows = el("div");
      this.limit = el("p", { class: "h-2" });
      place.append(el("h2", {}, "Notifications"), el("p", { class: "h-2" }, "Alarms are told on to a web address or by e-mail when they come. What is told leaves this farm: it names robot, alarm and time, nothing else."), this.rows, el("div", { class: "h-row" }, button([icon("add", "m"), "Add web address"], () => this.edit("webhook"), "notify-add-webhook"), button([icon("outgoing_mail", "m"), "Add e-mail"], () => this.edit("smtp"), "notify-add-smtp")), this.limit);
      this.load();
    }

    load() {
      HL.records.load(this.rows, "Notifications", PATH, (answer) => this.draw(answer));
    }

    draw(answer) {
      this.channels = answer.channels ?? [];
      text(this.limit, answer.rate_limit ? `At most ${answer.rate_limit.count} in ${answer.rate_limit.minutes} min each; what is more is told as a number in the next one.` : "");
      if (!this.channels.length) return empty("Nobody is told outside the console", "Add a web address or an e-mail below.");
      return table(["Name", "Kind", "To", "Tells about", "State", "Last", ""], this.channels.map((one) => this.row(one)));
    }

    row(one) {
      const said = el("span", { "data-testid": `notify-last-${one.id}`, role: "status" }, last(one.last));
      const test = button("Test", async () => {
        attr(test, "disabled", true);
        text(said, "Sending …");
        const answer = await HL.port.api("POST", `${PATH}/${encodeURIComponent(one.id)}/test`, {}, TEST_MS);
        attr(test, "disabled", null);
        text(said, answer.ok && answer.is_delivered !== false ? `Delivered: ${answer.text || "it was taken"}` : `Failed: ${answer.text || "no answer"}`);
      }, `notify-test-${one.id}`);
      const to = one.kind === "webhook" ? one.url : `${(one.to ?? []).join(", ")} by ${one.host}`;
      return { hook: `notify-row-${one.id}`, cells: [one.name, KINDS[one.kind] ?? one.kind, to, LEVELS[one.priority], one.is_on ? "on" : "off", said, el("div", { class: "acts" }, test, button("Change", () => this.edit(one.kind, one), `notify-edit-${one.id}`), button("Remove", () => this.remove(one), `notify-remove-${one.id}`))] };
    }

    edit(kind, channel = null) {
      edit(kind, channel, (changed) => this.save(channel ? this.channels.map((one) => (one === channel ? changed : one)) : [...this.channels, changed]));
    }

    remove(one) {
      HL.sheet({ title: `Remove ${one.name}?`, body: [el("p", { class: "h-2 h-t16" }, "It is told nothing any more. Its secret is forgotten.")], buttons: [["Keep it", (close) => close()], ["Remove", async (close) => ((await this.save(this.channels.filter((other) => other !== one))).ok ? close() : close()), true]] });
    }

    async save(channels) {
      const wire = channels.map(({ last: _last, has_secret: _has, ...one }) => one);
      const answer = await HL.port.api("PUT", PATH, { channels: wire });
      if (answer.ok) HL.toast("Saved", "check");
      else HL.toast(`Not saved: ${answer.text || "no answer"}`, "block");
      if (answer.ok) this.load();
      return answer;
    }
  }

  HL.AlarmNotifications = Panel;
})();
