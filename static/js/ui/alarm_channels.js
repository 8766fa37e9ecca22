// The form of one notification channel: where to, about what, how often. A secret goes in and never comes back.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const KINDS = { webhook: "Web address", email: "E-mail" };
  const STEPS = { raised: "when it comes", escalated: "when nobody answers", returned: "when it is gone", acknowledged: "when somebody has seen it" };
  const list = (words) => words.split(/[\s,;]+/).filter(Boolean);

  // [key, label, attributes]
  const FIELDS = {
    webhook: [["name", "Name", { required: true, maxlength: "80" }], ["url", "Address", { required: true, maxlength: "500", placeholder: "https://host/path" }], ["secret", "Secret that signs it", { type: "password" }]],
    email: [["name", "Name", { required: true, maxlength: "80" }], ["host", "Mail server", { required: true }], ["port", "Port", { type: "number", min: "1", max: "65535", required: true }], ["security", "Encryption", { choices: ["starttls", "tls", "none"] }], ["user", "User", {}], ["secret", "Password", { type: "password" }], ["sender", "From", { required: true }], ["recipients", "To, with commas", { required: true }]],
  };
  const FRESH = { webhook: {}, email: { port: 587, security: "starttls" } };

  function field(channel, [key, label, { choices, ...options }]) {
    const isSecret = options.type === "password";
    const node = choices
      ? el("select", { class: "h-select", name: key, "data-testid": `notify-${key}` }, ...choices.map((value) => el("option", { value }, value)))
      : el("input", { class: "h-input", name: key, autocomplete: isSecret ? "new-password" : "off", "data-testid": `notify-${key}`, ...options });
    if (isSecret) node.placeholder = channel.secret ? "kept, not shown. Write to replace it" : "none";
    else node.value = Array.isArray(channel[key]) ? channel[key].join(", ") : channel[key] ?? "";
    return { key, node, label: el("label", { class: "h-field" }, label, node), name: label };
  }

  function ticks(legend, options, chosen, hook) {
    const boxes = Object.entries(options).map(([value, label]) => {
      const box = el("input", { type: "checkbox", value, "data-testid": `${hook}-${value}` });
      box.checked = chosen.includes(value);
      return [box, el("label", { class: "h-check" }, box, label)];
    });
    return { node: el("fieldset", { class: "h-ticks4" }, el("legend", { class: "h-field" }, legend), ...boxes.map(([, label]) => label)), value: () => boxes.filter(([box]) => box.checked).map(([box]) => box.value) };
  }

  const newId = (name) => `${name.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 40) || "channel"}-${Math.floor(Math.random() * 46656).toString(36)}`;

  function value({ key, node }) {
    if (key === "recipients") return list(node.value);
    if (key === "secret") return node.value || null; // null keeps what is there
    return node.type === "number" ? Number(node.value) : node.value.trim();
  }

  // What keeps a form from being saved. Where somebody else saved in between, what is typed stays and theirs is loaded.
  function trouble(hook, load, loaded = "") {
    const words = el("span");
    const button = el("button", { type: "button", class: "h-btn", "data-testid": `${hook}-load`, hidden: true }, "Load what is saved");
    const say = (said, isOld = false) => (text(words, said), attr(button, "hidden", !isOld));
    button.onclick = async () => ((await load()) ? say(loaded) : say("Not loaded: no answer. Try again.", true));
    const failed = (answer) => say(`Not saved: ${answer.text || "no answer"}`, answer.code === "changed");
    return { node: el("div", { class: "h-error", role: "alert", "data-testid": hook }, words, " ", button), say, failed };
  }

  // save(channel) -> answer of the server; load() what is saved
  function edit(kind, old, save, load) {
    const channel = old ?? { ...FRESH[kind], is_on: true, priorities: [1, 2], steps: ["raised", "escalated"], robots: [], per_hour: 30 };
    const fields = FIELDS[kind].map((one) => field(channel, one));
    const perHour = field(channel, ["per_hour", "At most so many an hour; what is more comes as one list", { type: "number", min: "1", max: "600", required: true }]);
    const robots = field(channel, ["robots", "Only of these robots, ids with commas; empty is all", {}]);
    const levels = ticks("Priority", { 1: "1 critical", 2: "2 high", 3: "3 medium", 4: "4 low" }, channel.priorities.map(String), "notify-priority");
    const steps = ticks("Told", STEPS, channel.steps, "notify-step");
    const isOn = el("input", { type: "checkbox", "data-testid": "notify-on" });
    isOn.checked = channel.is_on;
    const problem = trouble("notify-problem", load, "Loaded. What you typed is still here; Save keeps it.");
    const done = async (close) => {
      const bad = [...fields, perHour].find(({ node }) => !node.checkValidity());
      if (bad) return problem.say(`${bad.name}: ${bad.node.validationMessage}`), bad.node.focus();
      problem.say("Saving …");
      const found = Object.fromEntries(fields.map((one) => [one.key, value(one)]));
      const answer = await save({ ...found, id: channel.id ?? newId(found.name), kind, is_on: isOn.checked, priorities: levels.value().map(Number), steps: steps.value(), robots: list(robots.node.value), per_hour: value(perHour) });
      if (answer.ok) return close();
      return problem.failed(answer);
    };
    HL.sheet({ title: `${old ? "Change" : "Add"}: ${KINDS[kind]}`, hook: "notify-sheet", body: [el("div", { class: "h-form" }, ...fields.map(({ label }) => label)), levels.node, steps.node, el("div", { class: "h-form" }, perHour.label, robots.label), el("label", { class: "h-check" }, isOn, "Switched on"), problem.node], buttons: [["Leave it", (close) => close()], ["Save", done, true]] });
  }

  HL.alarmChannels = { edit, trouble, KINDS };
})();
