// Alarms in words: states, times, how long.
(() => {
  "use strict";
  const { words } = HL;
  const pad = (number) => String(number).padStart(2, "0");
  const DAY_MS = 86400000;

  // 14:36:43 today, "18 May 14:36" before
  function raised(ms) {
    if (!ms) return "–";
    const [at, today] = [new Date(ms), new Date()];
    if (at.toDateString() === today.toDateString()) return words.wallSeconds(at);
    return `${at.toLocaleDateString("en-GB", { day: "numeric", month: "short" })} ${words.wall(at)}`;
  }
  // 14:36:40.91
  const precise = (ms) => `${words.wallSeconds(new Date(ms))}.${pad(Math.floor((ms % 1000) / 10))}`;
  const stamp = (ms) => (ms ? `${new Date(ms).toLocaleDateString("en-GB", { day: "2-digit", month: "short" })} ${words.wallSeconds(new Date(ms))}` : "–");

  // 0:08, 24:48, 3 h 07, 2 d 4 h
  function lasting(one) {
    const ageMs = HL.port.age(one.t);
    if (!Number.isFinite(ageMs)) return "–";
    if (ageMs < DAY_MS) return words.clock(ageMs / 1000);
    return `${Math.floor(ageMs / DAY_MS)} d ${Math.floor((ageMs % DAY_MS) / 3600000)} h`;
  }

  const clock = (s) => (s === null || s === undefined ? "––" : words.clock(s));
  const when = (ms) => (ms ? words.wall(new Date(ms)) : "");

  const STATES = {
    unacknowledged: ["notifications_active", () => "Active, not acknowledged"],
    acknowledged: ["done", (one) => `Active, acknowledged ${words.initials(one.seen_by || "?")}`],
    returned: ["undo", () => "Returned, not acknowledged"],
    latched: ["lock", () => "Returned, waits to be cleared"],
    shelved: ["snooze", (one) => `Shelved by ${words.initials(one.shelf?.by || "?")} until ${when(one.shelf?.until)}`],
    suppressed: ["volume_off", () => "Suppressed by its cause"],
    out_of_service: ["do_not_disturb_on", (one) => `Out of service${one.out_of_service?.by ? `, ${words.initials(one.out_of_service.by)}` : ""}`],
    normal: ["check", () => "Normal again"],
  };
  const sign = (state) => (STATES[state] ?? STATES.normal)[0];
  const state = (one) => (HL.alarmOrder.isUnanswered(one) ? (one.state === "returned" ? "Returned, nobody answered" : "Nobody answered") : (STATES[one.state] ?? STATES.normal)[1](one));

  // who did it and why, in full
  function story(one) {
    if (one.shelf && one.state === "shelved") return `Shelved by ${one.shelf.by} until ${when(one.shelf.until)}: ${one.shelf.reason}`;
    if (one.out_of_service) return `Taken out of service by ${one.out_of_service.by}: ${one.out_of_service.reason}`;
    if (one.seen_by && one.seen_at) return `Acknowledged by ${one.seen_by} at ${raised(one.seen_at)}`;
    return "";
  }

  // what is so now, if the title does not say it already
  const now = (one) => (one.text && one.text.replace(/\.$/, "") !== one.title.replace(/\.$/, "") ? one.text : "");

  // what the one button of a row does now: [label, verb], or null
  function answer(one) {
    if (one.state === "unacknowledged") return ["Ack", "acknowledge"];
    return one.state === "returned" || one.state === "latched" ? ["Clear", "clear"] : null;
  }

  HL.alarmWords = { raised, precise, stamp, lasting, clock, when, sign, state, story, now, answer };
})();
