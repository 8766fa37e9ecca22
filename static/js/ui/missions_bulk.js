// Several missions at once: each is asked for on its own and answers on its own; and the list by where missions are.
(() => {
  "use strict";
  const { el, icon } = HL;
  const GROUPS = [
    ["all", "All", null],
    ["draft", "Drafts", ["draft"]],
    ["ready", "Ready", ["validated"]],
    ["queue", "Queue", ["queued", "waiting"]],
    ["robot", "Active", ["sent", "accepted", "running", "paused", "resuming"]],
    ["ended", "Ended", ["done", "aborted", "failed"]],
  ];
  const of = (id) => `/missions/${encodeURIComponent(id)}`;
  const PLAIN = { is_unattended: false, earliest_utc: null, repeat: null };

  const isIn = (group, mission) => GROUPS.find(([key]) => key === group)?.[2]?.includes(mission.status) ?? true;

  // chips with counts; `choose(group)`
  function chips(group, missions, choose) {
    const count = (key) => missions.filter((one) => isIn(key, one)).length;
    return GROUPS.filter(([key]) => key !== "draft" || key === group || count(key)).map(([key, name]) => el("button", { type: "button", class: "h-btn q-filter", "aria-pressed": String(key === group), "data-testid": `mission-filter-${key}`, onclick: () => choose(key) }, name, el("span", { class: "h-2" }, String(count(key)))));
  }

  // what can be done with the chosen; rights: {edit, send}
  function bar(missions, rights, done) {
    const button = (hook, sign, label, may, run) => el("button", { type: "button", class: "h-btn", "data-testid": `bulk-${hook}`, disabled: !may || !missions.length, onclick: run }, icon(sign, "m"), label);
    const each = (title, work) => () => run(title, missions, work, done);
    const patch = (body) => (one) => HL.port.api("PATCH", of(one.id), body);
    return el("div", { class: "q-bulk", "data-testid": "bulk-bar" }, el("b", { class: "h-t14" }, missions.length === 1 ? "1 chosen" : `${missions.length} chosen`), el("div", { class: "h-row h-wrap" },
      button("queue", "add", "Add to queue", rights.send, each("Add to queue", (one) => HL.port.api("POST", "/queue/entries", { mission_id: one.id, ...PLAIN }))),
      button("unattended", "autoplay", "Unattended", rights.edit, each("Mark unattended", patch({ is_supervised: false }))),
      button("supervised", "visibility", "Supervised", rights.edit, each("Mark supervised", patch({ is_supervised: true }))),
      button("robot", "smart_toy", "Robot", rights.edit, () => chooseRobot(missions, done)),
      button("delete", "delete", "Delete", rights.edit, () => reallyDelete(missions, done))));
  }

  function chooseRobot(missions, done) {
    const robots = Object.entries(HL.port.fleet()).filter(([, robot]) => robot.is_registered !== false);
    const select = el("select", { class: "h-select", "data-testid": "bulk-robot-select" }, ...robots.map(([id, robot]) => el("option", { value: id }, robot.name)));
    const go = (close) => (close(), run("Change robot", missions, (one) => HL.port.api("PATCH", of(one.id), { robot_id: select.value }), done));
    HL.sheet({ title: `Another robot for ${missions.length} missions`, body: [el("label", { class: "h-field" }, "Robot", select)], buttons: [["Leave it", (close) => close()], ["Change", go, true]] });
  }

  function reallyDelete(missions, done) {
    const names = missions.slice(0, 6).map((one) => one.name).join(", ");
    const go = (close) => (close(), run("Delete", missions, (one) => HL.port.api("DELETE", of(one.id)), done));
    HL.sheet({ title: `Delete ${missions.length} missions?`, body: [el("p", { class: "h-2 h-t16" }, `${names}${missions.length > 6 ? ` and ${missions.length - 6} more` : ""}. They cannot be brought back.`)], buttons: [["Keep them", (close) => close()], ["Delete", go, true]] });
  }

  // one after the other, so that a list of refusals names each
  async function run(title, missions, work, done) {
    const lines = missions.map((one) => ({ one, state: el("span", { class: "h-t14 h-2" }, "waits"), sign: el("span", {}, icon("hourglass_top", "m")) }));
    const body = el("ul", { class: "q-results", "data-testid": "bulk-results" }, ...lines.map(({ one, state, sign }) => el("li", { class: "h-row", "data-testid": `bulk-result-${one.id}` }, sign, el("span", { class: "h-col" }, el("b", { class: "h-t16" }, one.name), state))));
    HL.sheet({ title, hook: "bulk-sheet", body: [body], buttons: [["Close", (close) => close(), true]] });
    for (const line of lines) {
      const answer = await work(line.one);
      line.sign.replaceChildren(icon(answer.ok ? "check" : "block", "m"));
      line.state.textContent = answer.ok ? "Done" : answer.text || "No answer. Look at it before you try again.";
      line.state.closest("li").dataset.state = answer.ok ? "done" : "refused";
    }
    done();
  }

  HL.missionsBulk = { chips, isIn, bar };
})();
