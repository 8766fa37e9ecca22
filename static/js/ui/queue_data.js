// The queue as REST tells it: times on the farm's clock, what is planned when, and orders with the newest tick.
(() => {
  "use strict";
  const LATE_MS = 5000;
  const GUESS_S = 1800; // a mission whose duration nobody knows is drawn half an hour long
  const DAYS = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"];
  const OVER_TEN_S = 10000; // arming writes to disk before it answers

  const load = () => HL.port.api("GET", "/queue", null, LATE_MS);
  const ms = (utc) => (utc ? Date.parse(utc) : null);

  function clock(at, zone, withDay = false) {
    const parts = { timeZone: zone, hour: "2-digit", minute: "2-digit" };
    const time = new Date(at).toLocaleTimeString("en-GB", parts);
    return withDay ? `${day(at, zone)} ${time}` : time;
  }

  const day = (at, zone) => new Date(at).toLocaleDateString("en-GB", { timeZone: zone, weekday: "short", day: "numeric", month: "short" }).replace(",", "");
  const date = (at, zone) => new Date(at).toLocaleDateString("en-CA", { timeZone: zone }); // 2026-11-22
  const isSameDay = (a, b, zone) => date(a, zone) === date(b, zone);
  const isSameYear = (a, b, zone) => date(a, zone).slice(0, 4) === date(b, zone).slice(0, 4);

  function when(at, zone, now = Date.now()) {
    if (isSameDay(at, now, zone)) return clock(at, zone);
    return isSameYear(at, now, zone) ? clock(at, zone, true) : `${day(at, zone)} ${date(at, zone).slice(0, 4)} ${clock(at, zone)}`;
  }

  // minutes that the farm's clock is ahead of UTC at an instant
  function offsetMs(at, zone) {
    const parts = Object.fromEntries(new Intl.DateTimeFormat("en-GB", { timeZone: zone, hourCycle: "h23", year: "numeric", month: "2-digit", day: "2-digit", hour: "2-digit", minute: "2-digit", second: "2-digit" }).formatToParts(at).map(({ type, value }) => [type, value]));
    return Date.UTC(parts.year, parts.month - 1, parts.day, parts.hour, parts.minute, parts.second) - Math.floor(at / 1000) * 1000;
  }

  // "2026-06-15T06:00" on the farm's clock to an instant, and back: the tablet may be set to another zone
  function fromLocal(text, zone) {
    const flat = Date.parse(`${text}Z`);
    const first = flat - offsetMs(flat, zone);
    return flat - offsetMs(first, zone);
  }
  const toLocal = (at, zone) => new Date(at + offsetMs(at, zone)).toISOString().slice(0, 16);

  const zoneName = (zone) => zone.replace(/^Etc\/(UTC|GMT)$/, "UTC"); // as people write it

  function duration(seconds) {
    const minutes = Math.max(1, Math.round(seconds / 60));
    return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")}`;
  }

  // what ended, runs and is planned of one robot, as bars from..to in ms; what waits is planned not before now
  function bars(queue, robot, now) {
    const past = queue.ended.filter((one) => one.robot_id === robot.robot_id && one.started_utc && one.state !== "removed");
    const done = past.map((one) => ({ entry: one, from: ms(one.started_utc), to: ms(one.ended_utc), look: one.state === "done" ? "done" : "ended" }));
    const open = queue.entries.filter((one) => one.robot_id === robot.robot_id);
    let free = now;
    if (robot.now && !open.some((one) => one.mission_id === robot.now.mission_id)) {
      free = now + (robot.now.remaining_s ?? GUESS_S) * 1000;
      done.push({ entry: null, name: robot.now.status === "paused" ? `${robot.now.name}, paused` : robot.now.name, from: now, to: free, look: "other", isPaused: robot.now.status === "paused" });
    }
    const isUnderWay = (one) => ["running", "paused", "resuming"].includes(one.status);
    const planned = [...open].sort((a, b) => isUnderWay(b) - isUnderWay(a)).map((one) => {
      if (isUnderWay(one)) {
        const left = robot.now?.mission_id === one.mission_id ? robot.now.remaining_s : null;
        const from = ms(one.started_utc) ?? now;
        free = Math.max(now, left === null || left === undefined ? from + (one.duration_s ?? GUESS_S) * 1000 : now + left * 1000);
        return { entry: one, from, to: free, look: "running", isPaused: one.status === "paused" };
      }
      const from = Math.max(free, ms(one.earliest_utc) ?? 0, ms(one.waiting?.clears_utc) ?? 0);
      free = from + (one.duration_s ?? GUESS_S) * 1000;
      return { entry: one, from, to: free, look: one.status === "queued" ? "queued" : "waiting" };
    });
    return [...done, ...planned];
  }

  // robots with something in the queue or armed, then those under way or just done; and, apart, the others
  function split(queue) {
    const named = new Set([...queue.entries, ...queue.ended.filter((one) => one.started_utc && one.state !== "removed")].map((one) => one.robot_id));
    const isBusy = (robot) => named.has(robot.robot_id) || Boolean(robot.arming || robot.now || robot.holds);
    const waits = (robot) => queue.entries.some((one) => one.robot_id === robot.robot_id) || Boolean(robot.arming || robot.holds);
    const busy = queue.robots.filter(isBusy);
    return [[...busy.filter(waits), ...busy.filter((robot) => !waits(robot))], queue.robots.filter((robot) => !isBusy(robot))];
  }

  // an order that can lead to motion carries the newest tick; without one nothing is sent and nothing waits
  async function order(path, body) {
    const tick = window.headland?.tick() ?? null;
    if (tick === null) return { ok: false, outcome: "refused", text: "The link to the server is lost." };
    const answer = await HL.port.api("POST", `/queue/${path}`, { ...body, tick }, OVER_TEN_S);
    answer.outcome ??= answer.status >= 400 && answer.status < 500 ? "declined" : "unknown"; // by the server: no robot was asked
    answer.text ||= "No answer. Look at the queue before you try again.";
    return answer;
  }

  function repeatWords(rule) {
    if (!rule) return "";
    const base = { daily: "every day", workdays: "Mon to Fri", weekly: rule.days.map((one) => DAYS[one]).join(", "), every_n_days: `every ${rule.every_days} days` }[rule.kind];
    return rule.until ? `${base}, until ${rule.until}` : base;
  }

  function conditionWords(rule) {
    const parts = [];
    if (rule.needs_daylight) parts.push("daylight");
    if (rule.rain_below_mm_h !== null) parts.push(`rain below ${rule.rain_below_mm_h} mm/h`);
    if (rule.wind_below_mps !== null) parts.push(`wind below ${rule.wind_below_mps} m/s`);
    if (rule.battery_min !== null) parts.push(`battery at least ${Math.round(rule.battery_min * 100)} %`);
    if (rule.battery_reserve !== null) parts.push(`${Math.round(rule.battery_reserve * 100)} % reserve`);
    if (rule.needs_rtk) parts.push("RTK");
    if (rule.needs_treatment_weather) parts.push("treatment limits");
    return parts.join(", ");
  }

  HL.queue = { load, ms, clock, day, when, fromLocal, toLocal, zoneName, duration, bars, split, order, repeatWords, conditionWords, DAYS };
})();
