// Admin: robots, people, tablets, audit, diagnostics. Every change goes through REST, which asks for the right again.
(() => {
  "use strict";
  const { el, icon, text, LiveElement, define } = HL;
  const { table, load, empty, list, when } = HL.records;
  const ROLES = ["viewer", "operator", "planner", "supervisor", "dispatcher", "admin"];

  const act = (label, run, hook, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick: run }, ...[label].flat());
  const acts = (...buttons) => el("div", { class: "acts" }, ...buttons);

  async function send(method, path, body, done, isQuiet) {
    const answer = await HL.port.api(method, path, body);
    if (!answer.ok) HL.toast(`Not saved: ${answer.text || "no answer"}`, "block");
    else if (!isQuiet) HL.toast("Saved", "check");
    if (answer.ok) done();
    return answer;
  }

  // a form whose text survives an outage and a reload; secrets never do
  function form({ name, fields, submit, onsubmit }) {
    const inputs = {};
    const rows = fields.map(([key, label, options = {}]) => {
      const { choices, ...rest } = options;
      const input = choices
        ? el("select", { class: "h-select", name: key, ...rest }, ...choices.map((value) => el("option", { value }, value)))
        : el("input", { class: "h-input", name: key, autocomplete: "off", ...rest });
      inputs[key] = input;
      if (rest.type !== "password") HL.draft.bind(input, `${name}.${key}`);
      return el("label", { class: "h-field" }, label, input);
    });
    const problem = el("div", { class: "h-error", role: "alert" });
    const node = el("form", { class: "h-card h-sec", "data-testid": name, onsubmit: async (event) => {
      event.preventDefault();
      const values = Object.fromEntries(Object.entries(inputs).map(([key, input]) => [key, input.value.trim()]).filter(([, value]) => value !== ""));
      const answer = await onsubmit(values);
      text(problem, answer?.ok === false ? answer.text || "Not saved." : "");
      if (answer?.ok) for (const [key, input] of Object.entries(inputs)) { HL.draft.clear(`${name}.${key}`); if (!input.matches("select")) input.value = ""; }
    } }, el("div", { class: "h-form" }, ...rows, el("button", { class: "h-btn pri", type: "submit" }, submit)), problem);
    return { node, inputs };
  }

  const SECTIONS = {
    robots(place) {
      const known = el("div");
      const fresh = el("div");
      const again = () => (load(known, "Robots", "/robots", registered), load(fresh, "New robots", "/robots/new", unknown));
      const add = form({
        name: "robot-form",
        fields: [["id", "Id", { required: true, pattern: "[a-z0-9][a-z0-9_\\-]{0,63}", placeholder: "weeder-07" }], ["name", "Name", { required: true, maxlength: "80" }], ["family", "Kind", { choices: ["weeder", "planter", "uav", "other"] }], ["http_url", "Its HTTP address", { placeholder: "http://10.0.0.17:8090" }], ["http_token", "Its token", { type: "password", autocomplete: "new-password" }], ["contact_name", "Contact on site", {}], ["contact_phone", "Phone", { type: "tel" }]],
        submit: "Add robot",
        onsubmit: (values) => send("POST", "/robots", values, again),
      });
      const accept = (robot) => {
        for (const key of ["id", "name", "family"]) if (robot[key]) { add.inputs[key].value = robot[key]; add.inputs[key].dispatchEvent(new Event("input")); }
        add.node.scrollIntoView({ block: "center" });
        add.inputs.name.focus();
      };
      const remove = (robot) => HL.sheet({
        title: `Remove ${robot.name}?`,
        body: [el("p", { class: "h-2 h-t16" }, "It stays visible as new when it is heard, and can no longer be operated. Its records stay.")],
        buttons: [["Keep it", (close) => close()], ["Remove", (close) => (close(), send("DELETE", `/robots/${encodeURIComponent(robot.id)}`, null, again)), true]],
      });
      const registered = (answer) => {
        const robots = list(answer, "robots").filter((robot) => robot.is_registered !== false);
        if (!robots.length) return empty("No robots yet", "Accept one below, or add it by hand.");
        return table(["Robot", "Id", "Kind", "HTTP address", "Contact", "Unattended", ""], robots.map((robot) => ({ hook: `robot-row-${robot.id}`, cells: [robot.name, robot.id, robot.family ?? "", robot.http_url || "–", [robot.contact_name, robot.contact_phone].filter(Boolean).join(", ") || "–", robot.is_unattended_allowed ? "yes" : "no", acts(act("Change", () => HL.editRobot(robot, again), `robot-change-${robot.id}`), act("Remove", () => remove(robot), `robot-remove-${robot.id}`))] })));
      };
      const unknown = (answer) => {
        const robots = list(answer, "robots");
        if (!robots.length) return empty("Nothing new", "A robot that is heard and not registered is shown here, and cannot be operated.");
        return table(["Heard as", "Kind", "Model", ""], robots.map((robot) => ({ hook: `robot-new-${robot.id}`, cells: [robot.name ? `${robot.name} (${robot.id})` : robot.id, robot.family ?? "–", robot.model ?? "–", acts(act("Accept", () => accept(robot), `robot-accept-${robot.id}`, "pri"))] })));
      };
      place.append(el("h2", {}, "Registered"), known, el("h2", {}, "New"), fresh, el("h2", {}, "Add"), el("p", { class: "h-2" }, "Address and token of a robot come from here alone, never from what it says."), add.node);
      again();
    },

    people(place) {
      const known = el("div");
      const again = () => load(known, "People", "/users", draw);
      const id = (user) => `/users/${encodeURIComponent(user.id)}`;
      const secret = (user, key, label, options) => {
        const input = el("input", { class: "h-input", type: "password", autocomplete: "new-password", autofocus: true, ...options });
        HL.sheet({ title: `${label} for ${user.name}`, body: [el("label", { class: "h-field" }, label, input)], buttons: [["Leave it", (close) => close()], ["Save", async (close) => { if (!input.value) return input.focus(); const answer = await send("PATCH", id(user), { [key]: input.value }, again); return answer.ok && close(); }, true]] });
      };
      const draw = (answer) => {
        const users = list(answer, "users");
        if (!users.length) return empty("No other users yet", "Add the first below.");
        return table(["Name", "Signs in as", "Role", "PIN", "State", ""], users.map((user) => {
          const role = el("select", { class: "h-select", "aria-label": `Role of ${user.name}`, onchange: () => send("PATCH", id(user), { role: role.value }, again) }, ...ROLES.map((name) => el("option", { value: name }, name)));
          role.value = user.role;
          return { hook: `user-row-${user.id}`, cells: [user.name, user.id, role, user.has_pin ? "set" : "–", user.is_active === false ? "off" : "active", acts(act("Password", () => secret(user, "password", "New password", { minlength: "8" })), act("PIN", () => secret(user, "pin", "New PIN, 4 digits", { inputmode: "numeric", pattern: "\\d{4}", maxlength: "4" })), act(user.is_active === false ? "Let in" : "Lock out", () => send("PATCH", id(user), { is_active: user.is_active === false }, again)))] };
        }));
      };
      const add = form({
        name: "user-form",
        fields: [["name", "Name", { required: true, maxlength: "80" }], ["role", "Role", { choices: ROLES }], ["password", "Password", { type: "password", autocomplete: "new-password", required: true }]],
        submit: "Add person",
        onsubmit: (values) => send("POST", "/users", values, again),
      });
      place.append(el("h2", {}, "People"), known, el("h2", {}, "Add"), add.node);
      again();
    },

    tablets(place) {
      const known = el("div");
      const again = () => load(known, "Tablets", "/devices", draw);
      const draw = (answer) => {
        const devices = list(answer, "devices");
        if (!devices.length) return empty("No tablet is enrolled", "STOP works before sign-in on enrolled tablets only.");
        return table(["Tablet", "Enrolled by", "Since", "State", ""], devices.map((device) => ({ hook: `device-row-${device.id}`, cells: [device.name, device.enrolled_by, when(device.enrolled_utc), device.revoked_utc ? `taken out ${when(device.revoked_utc)}` : "enrolled", device.revoked_utc ? "" : acts(act("Take out", () => send("DELETE", `/devices/${encodeURIComponent(device.id)}`, null, again)))] })));
      };
      place.append(el("h2", {}, "Enrolled tablets"), known, act([icon("tablet", "m"), HL.config.device ? `This is ${HL.config.device}` : "Enrol this tablet"], HL.enrol, "admin-enrol"));
      again();
    },

    audit(place) {
      const rows = el("div");
      const again = () => load(rows, "Audit log", "/audit?limit=200", (answer) => {
        const entries = list(answer, "entries");
        return entries.length ? table(["Time", "Who", "Where", "What", "Robot", "Outcome", "Text", "No."], entries.map((one) => ({ hook: `audit-row-${one.seq}`, cells: [when(one.utc ?? one.at), one.actor, one.device || "–", titled(one.kind), HL.port.fleet()[one.robot_id]?.name ?? one.robot_id ?? "–", titled(one.outcome), one.text || "", one.seq] }))) : empty("Nothing yet", "Commands, stops, sign-ins and changes are written here.");
      });
      place.append(el("div", { class: "h-row" }, el("h2", {}, "Newest 200"), act([icon("refresh", "m"), "Refresh"], again, "audit-refresh")), rows);
      again();
    },

    notifications(place) {
      new HL.AlarmNotifications(place);
    },

    limits(place) {
      new HL.AlarmLimits(place);
    },

    cameras(place) {
      new HL.AdminCameras(place);
    },

    cloud(place) {
      new HL.AdminCloud(place);
    },

    diagnostics(place) {
      const rows = el("div");
      const again = () => load(rows, "Diagnostics", "/diagnostics", (answer) => flat(answer.data ?? {}).map(([head, entries]) => el("div", { class: "h-sec" }, el("h2", {}, head), table(["What", "Value"], entries.map(([key, value]) => ({ cells: [key, value] }))))));
      place.append(el("div", { class: "h-row" }, el("h2", {}, "Diagnostics"), act([icon("refresh", "m"), "Refresh"], again, "diagnostics-refresh")), rows);
      again();
    },
  };

  // "down_since_utc" -> "down since (UTC)"
  const spaced = (name) => name.replace(/_utc$/, " (UTC)").replaceAll("_", " ");
  const titled = (name) => (name ? name[0].toUpperCase() + spaced(name.slice(1)) : "");

  // nested counters as one table a part, deeper ones by their path; one of a robot bears its name
  function flat(data) {
    const isDeep = (value) => value && typeof value === "object" && !Array.isArray(value) && Object.keys(value).length;
    const word = (value) => (value === null || (typeof value === "object" && !Object.keys(value).length) ? "–" : typeof value === "object" ? JSON.stringify(value) : String(value));
    const leaves = (value, path) => Object.entries(value).flatMap(([key, one]) => (isDeep(one) ? leaves(one, [...path, key]) : [[[...path, key].map((part, i) => HL.port.fleet()[part]?.name ?? (i ? spaced(part) : titled(part))).join(", "), word(one)]]));
    const parts = Object.entries(data).filter(([, value]) => value && typeof value === "object" && !Array.isArray(value));
    const loose = Object.entries(data).filter(([key]) => !parts.some(([name]) => name === key));
    const all = parts.map(([name, value]) => [titled(name), leaves(value, [])]);
    return loose.length ? [["General", loose.map(([key, one]) => [titled(key), word(one)])], ...all] : all;
  }

  class Admin extends LiveElement {
    build() {
      this.place = el("div", { class: "h-sec" });
      this.append(this.place);
    }
    enter() {
      this.tabs = [...this.parentElement.querySelectorAll("[data-tab]")];
      this.onTab = (event) => this.show(event.currentTarget.dataset.tab);
      for (const tab of this.tabs) tab.addEventListener("click", this.onTab);
      this.show(HL.draft.get("admin-tab") || "robots");
    }
    leave() {
      for (const tab of this.tabs) tab.removeEventListener("click", this.onTab);
    }
    show(name) {
      const section = SECTIONS[name] ? name : "robots";
      HL.draft.set("admin-tab", section);
      for (const tab of this.tabs) tab.setAttribute("aria-pressed", String(tab.dataset.tab === section));
      this.place.replaceChildren();
      SECTIONS[section](this.place);
    }
  }

  document.head.append(el("link", { rel: "stylesheet", href: document.querySelector("hl-admin")?.dataset.style ?? "" }));
  define("hl-admin", Admin);
})();
