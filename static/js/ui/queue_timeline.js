// The day of every robot as a row of bars, with the line of now; what can be moved is dragged along its row.
(() => {
  "use strict";
  const { el, icon } = HL;
  const HOUR = 3600e3;
  const BEFORE_MS = 2 * HOUR;
  const LEAST_MS = 1.5 * HOUR; // a job of ten minutes is still wide enough for a finger
  const MOST_MS = 26 * HOUR;
  const STEPS = [0.25, 0.5, 1, 2, 3, 4];
  const MOST_TICKS = 9;
  const PADDING = 16; // px beside a name

  const isFixed = (entry) => !entry || ["sent", "accepted", "running", "paused", "resuming"].includes(entry.status) || entry.state !== "open";

  // from when to when: what ran in the last hours to the end of what is planned, on full hours
  function span(rows, now) {
    const all = rows.flatMap((row) => row.bars);
    const first = Math.min(now - HOUR / 6, ...all.filter((one) => one.to > now - BEFORE_MS).map((one) => Math.max(one.from, now - BEFORE_MS)));
    const last = Math.max(first + LEAST_MS, ...all.map((one) => one.to));
    const step = HOUR * (STEPS.find((one) => (last - first) / (one * HOUR) <= MOST_TICKS) ?? 4);
    const from = Math.floor(first / step) * step;
    return { from, to: Math.min(Math.ceil(last / step) * step, from + MOST_MS), step };
  }

  // actions: {open(entry), move(entry, index), arm(), disarm(robot), mayEdit}
  function timeline(queue, actions) {
    const now = Date.now();
    const rows = queue.robots.map((robot) => ({ robot, bars: HL.queue.bars(queue, robot, now) }));
    const { from, to, step } = span(rows, now);
    const share = (at) => `${(100 * (at - from)) / (to - from)}%`;
    const ticks = [];
    for (let at = from; at < to; at += step) if (Math.abs(at - now) > 0.05 * (to - from)) ticks.push(el("span", { class: "h-t12 h-2", style: `left:${share(at)}` }, HL.queue.clock(at, queue.zone)));
    const head = el("div", { class: "q-hours-axis", "aria-hidden": "true" }, ...ticks, el("b", { class: "h-t12", style: `left:${share(now)}` }, "now"));
    const line = () => el("i", { class: "q-now", style: `left:${share(now)}`, "aria-hidden": "true" });
    return el("div", { class: "q-timeline", "data-testid": "queue-timeline" }, el("div", { class: "q-axisrow" }, el("span"), head), ...rows.map((row) => robotRow(queue, row, { from, to, share, line, now }, actions)));
  }

  function robotRow(queue, row, scale, actions) {
    const { robot } = row;
    const track = el("div", { class: "q-track", role: "list", "aria-label": `Queue of ${robot.name}` }, scale.line());
    const movable = [];
    for (const bar of row.bars) {
      const node = barNode(queue, bar, scale, actions);
      if (!node) continue;
      track.append(node);
      if (bar.entry && !isFixed(bar.entry)) movable.push(node);
      if (bar.entry && !isFixed(bar.entry) && actions.mayEdit) {
        HL.queueDrag.draggable(node, node, { axis: "x", fellows: () => movable, drop: (index) => actions.move(bar.entry, index) });
        HL.queueDrag.keyed(node, (by) => actions.shift(bar.entry, by));
      }
    }
    const later = row.bars.filter((bar) => bar.from >= scale.to).length;
    new ResizeObserver(() => placeNames(track)).observe(track);
    if (!row.bars.some((bar) => bar.entry?.state === "open" || bar.look === "other")) track.append(el("span", { class: "q-free h-t13 h-2", style: `left:calc(${scale.share(scale.now)} + 8px)` }, "Nothing in the queue"));
    return el("div", { class: "q-robot", "data-testid": `queue-row-${robot.robot_id}` }, el("div", { class: "q-name" }, el("b", { class: "h-t16 h-ell" }, robot.name), armed(queue, robot, actions), later ? el("span", { class: "h-t13 h-2", "data-testid": `queue-later-${robot.robot_id}` }, `${later} later, see Calendar`) : ""), el("div", { class: "q-lane" }, track, reason(queue, robot, actions)));
  }

  // a name that does not fit into its bar stands beside it, where the row is free; all in px along the row
  const isSlim = (bar, name, next) => name > bar.to - bar.from - PADDING && name + PADDING < next - bar.to;

  // asked anew whenever the row gets another width
  function placeNames(track) {
    const bars = [...track.querySelectorAll(".q-bar")];
    for (const bar of bars) bar.classList.remove("slim");
    const end = track.getBoundingClientRect().right;
    const found = bars.map((bar) => {
      const { left: from, right: to } = bar.getBoundingClientRect();
      return { bar, from, to, name: bar.querySelector(".h-ell").scrollWidth };
    });
    for (const one of found) {
      const next = Math.min(end, ...found.filter((other) => other !== one && other.from >= one.from).map((other) => other.from));
      one.bar.classList.toggle("slim", isSlim(one, one.name, next));
    }
  }

  function barNode(queue, bar, scale, actions) {
    if (bar.to <= scale.from || bar.from >= scale.to) return null;
    const { entry } = bar;
    const name = entry ? entry.name : bar.name;
    const times = `${HL.queue.when(bar.from, queue.zone)} to ${HL.queue.when(bar.to, queue.zone)}`;
    const left = Math.max(bar.from, scale.from);
    const width = `calc(${(100 * (Math.min(bar.to, scale.to) - left)) / (scale.to - scale.from)}% - 3px)`;
    const why = entry?.waiting && entry.status !== "running" ? ` ${entry.waiting.text}` : "";
    const status = entry ? (entry.state === "open" ? HL.plan.status(entry.status) : entry.why) : "Not from the queue";
    const tag = entry?.state === "open" ? "button" : "div";
    const node = el(tag, { type: tag === "button" ? "button" : null, class: "q-bar", role: "listitem", "data-testid": entry ? `queue-bar-${entry.id}` : null, "data-look": bar.look, "data-state": entry?.status ?? null, style: `left:${scale.share(left)};width:${width}`, title: `${name}, ${times}. ${status}.${why}`, "aria-label": `${name}, ${times}. ${status}.${why}`, onclick: entry?.state === "open" ? () => actions.open(entry) : null }, entry?.repeat ? icon("autoplay", "s") : "", el("span", { class: "h-ell" }, name));
    if (bar.look === "running") node.style.setProperty("--done", `${Math.min(100, Math.max(0, (100 * (scale.now - left)) / Math.max(1, bar.to - left)))}%`);
    return node;
  }

  function armed(queue, robot, actions) {
    if (robot.arming) return el("div", { class: "q-armed", "data-testid": `queue-armed-${robot.robot_id}`, "data-state": "armed" }, el("span", { class: "h-chip dark" }, icon("autoplay", "s"), `Armed until ${HL.queue.clock(Date.parse(robot.arming.until_utc), queue.zone)}`), el("button", { type: "button", class: "h-btn", "data-testid": `queue-disarm-${robot.robot_id}`, onclick: () => actions.disarm(robot) }, "Disarm"));
    const why = robot.is_unattended_allowed ? robot.disarmed?.why || "Not armed" : "A person starts it";
    return el("div", { class: "q-armed h-t13 h-2", "data-testid": `queue-armed-${robot.robot_id}`, "data-state": "off" }, why);
  }

  // the first thing this robot waits for, in one line under its bars
  function reason(queue, robot, actions) {
    const first = queue.entries.filter((one) => one.robot_id === robot.robot_id).find((one) => one.waiting && !["not_first", "running"].includes(one.waiting.code));
    if (!first) return el("div", { class: "q-reason" });
    return el("div", { class: "q-reason h-t14", "data-testid": `queue-reason-${robot.robot_id}`, "data-code": first.waiting.code }, icon(first.waiting.step === "wait" ? "hourglass_top" : "play_arrow", "s"), el("span", {}, el("b", {}, `${first.name}: `), first.waiting.text), first.waiting.code === "holds_other" ? HL.queueHold.button(robot, actions.changed) : "");
  }

  Object.assign(HL.queue, { timeline, isFixed, isSlim });
})();
