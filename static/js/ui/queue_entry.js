// Putting a mission into a queue, and changing what stands there.
(() => {
  "use strict";
  const { el, icon } = HL;
  const { EntryFields, field, select } = HL.queueFields;
  const SUPERVISED = "This mission is supervised: a person must be there and starts it.";

  const failed = (answer) => answer.text || "No answer. Look at the queue before you try again.";
  const mayAlone = (robot) => (robot?.is_unattended_allowed ? "" : `${robot?.name ?? "This robot"} may not run without a person. An admin can allow it.`);

  // asks for robot, time and conditions, then puts the mission last; resolves with the entry, or null
  async function add(mission) {
    const queue = await HL.queue.load();
    if (!queue.ok) {
      HL.toast(`Not added: ${failed(queue)}`, "cloud_off");
      return null;
    }
    return new Promise((resolve) => ask(mission, queue, resolve));
  }

  function ask(mission, queue, resolve) {
    const mayEdit = HL.config.rights.includes("edit_mission");
    const robot = select("queue-robot", queue.robots.map((one) => [one.robot_id, one.name]), mission.robot_id);
    if (!robot.value && queue.robots.length) robot.value = queue.robots[0].robot_id;
    const place = el("div");
    const alone = el("input", { type: "checkbox", "data-testid": "queue-mark-unattended" });
    let fields;
    const draw = () => {
      const chosen = queue.robots.find((one) => one.robot_id === robot.value);
      const why = mayAlone(chosen) || (mission.is_supervised && !alone.checked ? SUPERVISED : "");
      fields = new EntryFields(null, queue.zone, why);
      place.replaceChildren(fields.node);
    };
    robot.addEventListener("change", draw);
    alone.addEventListener("change", draw);
    draw();
    const mark = mission.is_supervised && mayEdit ? el("label", { class: "h-check" }, alone, "Mark it unattended: it may run without a person") : "";
    const done = (close, entry) => (close(), resolve(entry));
    const put = async (close) => {
      const wish = fields.wish();
      if (!wish) return;
      if (alone.checked && mission.is_supervised) {
        const marked = await HL.port.api("PATCH", `/missions/${encodeURIComponent(mission.id)}`, { is_supervised: false });
        if (!marked.ok) return fields.refuse(failed(marked));
        mission.is_supervised = false;
      }
      const answer = await HL.port.api("POST", "/queue/entries", { mission_id: mission.id, robot_id: robot.value, ...wish });
      if (!answer.ok) return fields.refuse(failed(answer));
      HL.toast(`${mission.name} is in the queue of ${robot.selectedOptions[0].textContent}`, "check");
      done(close, answer.data ?? answer);
    };
    HL.sheet({ title: `${mission.name}: add to queue`, hook: "queue-add", body: [field("Robot", robot), mark, place], buttons: [["Leave it", (close) => done(close, null)], ["Add to queue", put, true]] });
  }

  // one entry: why it waits, its place, its conditions; `actions`: {move(entry, by), changed()}
  function open(entry, queue, mayEdit, actions) {
    const robot = queue.robots.find((one) => one.robot_id === entry.robot_id);
    const fields = new EntryFields(entry, queue.zone, mayAlone(robot) || (entry.is_supervised ? SUPERVISED : ""));
    const waiting = entry.waiting ? el("div", { class: "h-card q-why", "data-testid": "queue-entry-why" }, el("b", { class: "h-t16" }, entry.waiting.text), entry.waiting.clears ? el("span", { class: "h-t14 h-2" }, `Clears: ${entry.waiting.clears}`) : "", el("span", { class: "h-t13 h-2" }, `Who: ${entry.waiting.who}. Since ${HL.queue.when(Date.parse(entry.waiting.since_utc), queue.zone)}.`), entry.waiting.code === "holds_other" ? HL.queueHold.button(robot, () => (HL.closeSheet(), actions.changed())) : "") : "";
    const place = (by, label, sign) => el("button", { type: "button", class: "h-btn", disabled: !mayEdit || HL.queue.isFixed(entry), "data-testid": by < 0 ? "queue-earlier" : "queue-later", onclick: () => actions.move(entry, by) }, icon(sign, "m"), label);
    const operate = el("a", { class: "h-btn", href: `/operate/${entry.robot_id}` }, icon("gamepad", "m"), "Operate");
    const remove = el("button", { type: "button", class: "h-btn", disabled: !mayEdit, "data-testid": "queue-remove", onclick: () => take(entry, actions) }, icon("delete", "m"), "Take out");
    const note = el("p", { class: "h-t13 h-2" }, mayEdit ? "Any change disarms the queue of this robot." : "Changing the queue needs the operator or planner role.");
    if (!mayEdit) for (const input of fields.node.querySelectorAll("input, select")) input.disabled = true;
    const save = async (close) => {
      const wish = fields.wish();
      if (!wish) return;
      const answer = await HL.port.api("PATCH", `/queue/entries/${entry.id}`, wish);
      if (!answer.ok) return fields.refuse(failed(answer));
      close();
      HL.toast("Saved", "check");
      actions.changed();
    };
    const buttons = mayEdit ? [["Close", (close) => close()], ["Save", save, true]] : [["Close", (close) => close(), true]];
    HL.sheet({ title: `${entry.name}, ${robot?.name ?? entry.robot_id}`, hook: "queue-entry", body: [waiting, el("div", { class: "h-row h-wrap" }, place(-1, "Earlier", "arrow_upward"), place(1, "Later", "arrow_downward"), operate, remove), fields.node, note], buttons });
  }

  async function take(entry, actions) {
    const answer = await HL.port.api("DELETE", `/queue/entries/${entry.id}`);
    if (!answer.ok) return HL.toast(`Not taken out: ${failed(answer)}`, "block");
    HL.closeSheet();
    HL.toast(`${entry.name} was taken out`, "check");
    actions.changed();
  }

  Object.assign(HL.queue, { add, open, failed });
})();
