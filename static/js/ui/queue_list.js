// The same queue as a list: every entry with what it waits for, its conditions and its place.
(() => {
  "use strict";
  const { el, icon } = HL;

  // actions: as for the timeline
  function list(queue, actions) {
    return el("div", { class: "q-lists", "data-testid": "queue-list" }, ...queue.robots.map((robot) => one(queue, robot, actions)));
  }

  function one(queue, robot, actions) {
    const mine = queue.entries.filter((entry) => entry.robot_id === robot.robot_id);
    const ended = queue.ended.filter((entry) => entry.robot_id === robot.robot_id && entry.state !== "removed").slice(-5).reverse();
    const movable = [];
    const rows = mine.map((entry) => row(queue, entry, movable, actions));
    const past = ended.map((entry) => el("li", { class: "q-entry past", "data-state": entry.state }, el("span", { class: "h-col h-sp" }, el("b", { class: "h-t16" }, entry.name), el("span", { class: "h-t14 h-2" }, `${HL.queue.when(Date.parse(entry.ended_utc), queue.zone)} · ${entry.why}`))));
    const state = robot.arming ? `armed by ${robot.arming.by} until ${HL.queue.clock(Date.parse(robot.arming.until_utc), queue.zone)}` : "not armed";
    return el("section", { class: "h-card q-listcard", "aria-label": `Queue of ${robot.name}` }, el("div", { class: "h-row" }, el("h3", { class: "h-t18 h-b h-sp" }, robot.name), el("span", { class: robot.arming ? "h-chip dark" : "h-chip line" }, state), robot.arming ? el("button", { type: "button", class: "h-btn", onclick: () => actions.disarm(robot) }, "Disarm") : ""), robot.now && !mine.some((entry) => entry.mission_id === robot.now.mission_id) ? el("p", { class: "h-t14 h-b", "data-testid": `queue-now-${robot.robot_id}` }, nowWords(robot.now)) : "", rows.length ? el("ol", {}, ...rows) : el("p", { class: "h-t14 h-2" }, "Nothing in the queue."), past.length ? el("details", {}, el("summary", { class: "h-t14 h-b" }, "Ended lately"), el("ul", {}, ...past)) : "");
  }

  // what a person started, which the queue waits for
  const nowWords = ({ name, status, remaining_s: left }) => `${status === "paused" ? "Paused" : "Under way"}: ${name}${left ? `, about ${HL.queue.duration(left)} of work left` : ""}. Not from the queue.`;

  function row(queue, entry, movable, actions) {
    const isFixed = HL.queue.isFixed(entry) || !actions.mayEdit;
    const handle = el("span", { class: "q-handle", "aria-hidden": "true", hidden: isFixed }, icon("unfold_more", "m"));
    const step = (by, name, sign) => el("button", { type: "button", class: "h-btn ico", "aria-label": `${name}: ${entry.name}`, disabled: isFixed, onclick: () => actions.shift(entry, by) }, icon(sign, "m"));
    const words = [entry.earliest_utc ? `from ${HL.queue.when(Date.parse(entry.earliest_utc), queue.zone)}` : "", HL.queue.repeatWords(entry.repeat), entry.duration_s ? HL.queue.duration(entry.duration_s) : "", entry.is_unattended ? `starts by itself with ${HL.queue.conditionWords(entry.conditions) || "no conditions"}` : "a person starts it"].filter(Boolean).join(" · ");
    const node = el("li", { class: "q-entry", tabindex: "0", "data-testid": `queue-entry-${entry.id}`, "data-state": entry.status, "data-code": entry.waiting?.code ?? null }, handle, el("button", { type: "button", class: "q-open h-sp", onclick: () => actions.open(entry) }, el("span", { class: "h-row" }, el("b", { class: "h-t16" }, entry.name), el("span", { class: "h-chip line" }, HL.plan.status(entry.status))), el("span", { class: "h-t14 q-waits" }, entry.waiting?.text ?? "Looked at in a moment."), el("span", { class: "h-t13 h-2" }, words)), step(-1, "Earlier", "arrow_upward"), step(1, "Later", "arrow_downward"));
    if (!isFixed) {
      movable.push(node);
      HL.queueDrag.draggable(node, handle, { axis: "y", fellows: () => movable, drop: (index) => actions.move(entry, index) });
      HL.queueDrag.keyed(node, (by) => actions.shift(entry, by));
    }
    return node;
  }

  Object.assign(HL.queue, { list });
})();
