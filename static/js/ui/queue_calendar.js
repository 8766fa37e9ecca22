// A week of every robot, day by day: what is planned, when it comes again, and when nothing starts by itself.
(() => {
  "use strict";
  const { el, icon } = HL;
  const DAY = 86400e3;
  const DAYS = 7;
  const NOON_MS = 12 * 3600e3; // a day is named by its noon: no change of the clocks moves it to another one
  const MOST_WEEKS = 52;
  let week = 0; // weeks ahead of this one

  const text = (day) => new Date(day + NOON_MS).toISOString().slice(0, 10);
  const flat = (date) => Date.parse(`${date}T00:00Z`);
  const weekday = (date) => (new Date(flat(date)).getUTCDay() + 6) % 7; // 0 is Monday

  // whether a job that is planned for the day `first` comes again on another one, both as 2026-06-15; as hmi.domain.queue.repeat
  function comesAgain(rule, first, date) {
    if (!rule || date <= first || (rule.until && date > rule.until)) return false;
    if (rule.kind === "workdays") return weekday(date) < 5;
    if (rule.kind === "weekly") return rule.days.includes(weekday(date));
    if (rule.kind === "every_n_days") return ((flat(date) - flat(first)) / DAY) % rule.every_days === 0;
    return true;
  }

  const local = (at, zone) => HL.queue.toLocal(at, zone); // 2026-06-15T06:00 on the farm's clock

  // what a day after the first says of a job that still takes time then; empty for what has ended or stands still
  function goingOn(bar, start, end, date) {
    if (date <= start.slice(0, 10) || date > end.slice(0, 10) || bar.isPaused || ["done", "ended"].includes(bar.look)) return "";
    return date === end.slice(0, 10) ? `to about ${end.slice(11)}` : "goes on";
  }

  // [{date, rows: [{at, told, name, entry, look, isAgain, isGoingOn}], windows}] of one robot
  function days(queue, robot, now, first) {
    const bars = HL.queue.bars(queue, robot, now);
    const mine = queue.blackouts.filter((one) => !one.robots?.length || one.robots.includes(robot.robot_id));
    return Array.from({ length: DAYS }, (_, k) => text(first + k * DAY)).map((date) => {
      const rows = [];
      for (const bar of bars) {
        const start = local(bar.look === "running" ? now : bar.from, queue.zone); // one of yesterday that goes on is today's
        if (start.slice(0, 10) === date) rows.push({ at: start.slice(11), told: at(bar, start.slice(11)), name: bar.entry?.name ?? bar.name, entry: bar.entry, look: bar.look, isAgain: false });
        const goesOn = goingOn(bar, start, local(bar.to, queue.zone), date);
        if (goesOn) rows.push({ at: "", told: goesOn, name: bar.entry?.name ?? bar.name, entry: bar.entry, look: bar.look, isAgain: false, isGoingOn: true });
        const planned = bar.entry?.earliest_utc ? local(Date.parse(bar.entry.earliest_utc), queue.zone) : start;
        if (bar.entry?.state === "open" && comesAgain(bar.entry.repeat, planned.slice(0, 10), date)) rows.push({ at: planned.slice(11), told: planned.slice(11), name: bar.entry.name, entry: bar.entry, look: "again", isAgain: true });
      }
      return { date, rows: rows.sort((a, b) => a.at.localeCompare(b.at)), windows: mine.filter((one) => one.days.includes(weekday(date))) };
    });
  }

  // a time is told only where somebody set it: what waits its turn begins when it may
  const at = (bar, time) => (["running", "other"].includes(bar.look) ? "now" : bar.entry?.state === "open" && !bar.entry.earliest_utc ? "in turn" : time);

  function job(row, actions) {
    const isOpen = row.entry?.state === "open";
    const label = `${row.told} ${row.name}${row.isAgain ? ", again" : ""}`;
    return el(isOpen ? "button" : "div", { type: isOpen ? "button" : null, class: "q-job", "data-look": row.look, "data-testid": row.entry && !row.isGoingOn ? `calendar-job-${row.entry.id}` : null, title: label, "aria-label": label, onclick: isOpen ? () => actions.open(row.entry) : null }, el("b", {}, row.told), row.entry?.repeat ? icon("autoplay", "s") : "", el("span", { class: "q-jobname" }, row.name));
  }

  const closed = (one) => el("div", { class: "q-closed h-t12", title: one.name }, icon("timer_off", "s"), `${HL.queue.minutes(one.from_min)} to ${HL.queue.minutes(one.to_min)}`);
  const dayName = (date) => HL.queue.day(flat(date) + NOON_MS, "UTC");

  // actions: {open(entry), redraw()}
  function calendar(queue, actions) {
    const now = Date.now();
    const today = local(now, queue.zone).slice(0, 10);
    const first = flat(today) + week * DAYS * DAY;
    const dates = Array.from({ length: DAYS }, (_, k) => text(first + k * DAY));
    const go = (by) => ((week = by ? Math.min(Math.max(week + by, 0), MOST_WEEKS) : 0), actions.redraw());
    const turn = (hook, sign, name, by, isOff) => el("button", { type: "button", class: "h-btn ico", "data-testid": `calendar-${hook}`, "aria-label": name, title: name, disabled: isOff, onclick: () => go(by) }, icon(sign, "m"));
    const head = el("div", { class: "h-row q-weekhead" }, turn("back", "arrow_back", "A week back", -1, week === 0), turn("on", "arrow_forward", "A week on", 1, week === MOST_WEEKS), el("b", { class: "h-t16", "data-testid": "calendar-week" }, `${dayName(dates[0])} to ${dayName(dates[DAYS - 1])}`), el("span", { class: "h-sp" }), week ? el("button", { type: "button", class: "h-btn", "data-testid": "calendar-today", onclick: () => go(0) }, "Today") : "");
    const names = el("div", { class: "q-weekrow q-weekdays", "aria-hidden": "true" }, el("span"), ...dates.map((date) => el("b", { class: "h-t13", "data-today": date === today ? "yes" : null }, dayName(date))));
    const rows = queue.robots.map((robot) => {
      const found = days(queue, robot, now, first);
      const cells = found.map((one) => el("div", { class: "q-day", "data-empty": one.rows.length ? null : "yes", "data-today": one.date === today ? "yes" : null, "data-testid": `calendar-${robot.robot_id}-${one.date}` }, el("span", { class: "q-dayname h-t13 h-b" }, dayName(one.date)), ...one.windows.map(closed), ...one.rows.map((row) => job(row, actions))));
      const none = found.every((one) => !one.rows.length) ? el("span", { class: "h-t13 h-2" }, "Nothing in this week") : "";
      return el("section", { class: "q-weekrow", "aria-label": `Week of ${robot.name}` }, el("div", { class: "q-name" }, el("b", { class: "h-t16 h-ell" }, robot.name), none), ...cells);
    });
    return el("div", { class: "q-cal", "data-testid": "queue-calendar" }, head, names, ...rows);
  }

  Object.assign(HL.queue, { calendar, comesAgain, calendarDays: days });
})();
