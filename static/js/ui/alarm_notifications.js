// Admin: who is told about alarms outside the console, and after how long without an answer. A test shows the real answer.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const { table, empty, when } = HL.records;
  const { edit, trouble, KINDS } = HL.alarmChannels;
  const PATH = "/alarms/notifications";
  const TEST_MS = 25000;
  const LEVELS = ["1", "2", "3", "4"];

  const button = (label, onclick, hook, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick }, ...[label].flat());
  const known = ({ health: _health, secret: _mask, ...one }) => ({ ...one, secret: null }); // null keeps the secret

  function lastWords({ sent, failed, waiting, dropped, last_error: error, last_sent: at }) {
    const counts = [waiting ? `${waiting} wait` : "", dropped ? `${dropped} given up` : ""].filter(Boolean).join(", ");
    const words = error ? `Failed ${failed}×: ${error}` : at ? `Delivered ${sent}, last ${when(at)}` : "Nothing sent since the start";
    return counts ? `${words}. ${counts}.` : words;
  }

  class Panel {
    constructor(place) {
      this.rows = el("div");
      this.hosts = el("p", { class: "h-2" });
      this.limits = LEVELS.map((level) => el("input", { class: "h-input", type: "number", min: "10", max: "86400", placeholder: "never", "data-testid": `notify-after-${level}` }));
      this.problem = trouble("notify-limits-problem", () => this.load());
      place.append(
        el("h2", {}, "Notifications"), el("p", { class: "h-2" }, "Alarms are told on to a web address or by e-mail. The message leaves this farm: robot, alarm, what to do and the time."),
        this.rows, el("div", { class: "h-row h-wrap" }, button([icon("add", "m"), "Add web address"], () => this.edit("webhook"), "notify-add-webhook"), button([icon("outgoing_mail", "m"), "Add e-mail"], () => this.edit("email"), "notify-add-email")), this.hosts,
        el("h2", {}, "When nobody answers"), el("p", { class: "h-2" }, "After so many seconds an alarm counts as not answered: it is marked, said again and told on. Empty is never."),
        el("form", { class: "h-card h-sec", "data-testid": "notify-limits", onsubmit: (event) => (event.preventDefault(), this.saveLimits()) }, el("div", { class: "h-form" }, ...this.limits.map((input, i) => el("label", { class: "h-field" }, `Priority ${LEVELS[i]}, seconds`, input)), el("button", { class: "h-btn pri", type: "submit" }, "Save")), this.problem.node),
      );
      this.load();
    }

    load() {
      return HL.records.load(this.rows, "Notifications", PATH, (answer) => this.draw(answer));
    }

    draw(answer) {
      this.revision = answer.revision;
      this.channels = answer.channels ?? [];
      this.limits.forEach((input, i) => (input.value = answer.escalate_after_s?.[LEVELS[i]] ?? ""));
      text(this.hosts, answer.hosts?.length ? `Only these hosts are allowed: ${answer.hosts.join(", ")}.` : answer.private_allowed ? "" : "Addresses in private networks are not allowed here; the settings of the server can change that.");
      if (!this.channels.length) return empty("Nobody is told outside the console", "Add a web address or an e-mail below.");
      return table(["Name", "Kind", "To", "About", "At most", "State", "Last", ""], this.channels.map((one) => this.row(one)));
    }

    row(one) {
      const said = el("span", { "data-testid": `notify-last-${one.id}`, role: "status" }, lastWords(one.health));
      const test = button("Test", async () => {
        attr(test, "disabled", true);
        text(said, "Sending …");
        const answer = await HL.port.api("POST", `${PATH}/${encodeURIComponent(one.id)}/test`, {}, TEST_MS);
        attr(test, "disabled", null);
        text(said, answer.ok && answer.data.ok ? `Test delivered. ${answer.text}` : `Test failed: ${answer.text || "no answer"}`);
      }, `notify-test-${one.id}`);
      const to = one.kind === "webhook" ? one.url : `${one.recipients.join(", ")} by ${one.host}`;
      const about = `Priority ${one.priorities.join(", ")}${one.robots.length ? `; ${one.robots.join(", ")}` : ""}`;
      return { hook: `notify-row-${one.id}`, cells: [one.name, KINDS[one.kind], `${to}${one.secret ? ", with a secret" : ""}`, about, `${one.per_hour} an hour`, one.is_on ? "on" : "off", said, el("div", { class: "acts" }, test, button("Change", () => this.edit(one.kind, one), `notify-edit-${one.id}`), button("Remove", () => this.remove(one), `notify-remove-${one.id}`))] };
    }

    edit(kind, old = null) {
      edit(kind, old, (changed) => this.save({ channels: this.withOne(changed), escalate_after_s: null }), () => this.load());
    }

    // by its id: what is saved may have been loaded anew since the form was opened
    withOne(changed) {
      const isNew = this.channels.every((one) => one.id !== changed.id);
      return [...this.channels.map((one) => (one.id === changed.id ? changed : known(one))), ...(isNew ? [changed] : [])];
    }

    remove(one) {
      const gone = async (close) => {
        const answer = await this.save({ channels: this.channels.filter((other) => other !== one).map(known), escalate_after_s: null });
        if (answer.code === "changed") this.load();
        close();
      };
      HL.sheet({ title: `Remove ${one.name}?`, body: [el("p", { class: "h-2 h-t16" }, "It is told nothing any more, and its secret is forgotten.")], buttons: [["Keep it", (close) => close()], ["Remove", gone, true]] });
    }

    async saveLimits() {
      const after = Object.fromEntries(this.limits.map((input, i) => [LEVELS[i], input.value ? Number(input.value) : null]));
      const answer = await this.save({ channels: null, escalate_after_s: after });
      if (answer.ok) this.problem.say("");
      else this.problem.failed(answer);
    }

    // what is null stays as it is
    async save(change) {
      const answer = await HL.port.api("PUT", PATH, { ...change, revision: this.revision });
      HL.toast(answer.ok ? "Saved" : `Not saved: ${answer.text || "no answer"}`, answer.ok ? "check" : "block");
      if (answer.ok) this.load();
      return answer;
    }
  }

  HL.AlarmNotifications = Panel;
})();
