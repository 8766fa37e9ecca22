// Times and sentences as people read them.
(() => {
  "use strict";

  // 0.2 s, 12 s, 2:14, 1 h 08
  function age(ms) {
    if (ms === null || ms === undefined || !Number.isFinite(ms)) return "never";
    const s = Math.max(0, ms) / 1000;
    if (s < 9.95) return `${s.toFixed(1)} s`;
    if (s < 60) return `${Math.floor(s)} s`;
    return s < 3600 ? clock(s) : `${Math.floor(s / 3600)} h ${pad(Math.floor((s % 3600) / 60))}`;
  }

  // whole seconds, for banners: 12 s, 2:14, 1 h 08
  const since = (ms) => (ms < 60000 ? `${Math.max(0, Math.floor(ms / 1000))} s` : age(ms));

  // 0:16, 2:14, 1 h 08
  function clock(s) {
    const whole = Math.max(0, Math.floor(s));
    return whole < 3600 ? `${Math.floor(whole / 60)}:${pad(whole % 60)}` : `${Math.floor(whole / 3600)} h ${pad(Math.floor((whole % 3600) / 60))}`;
  }

  // 3 h 26 min
  function left(s) {
    if (s === null || s === undefined) return "–";
    const minutes = Math.max(0, Math.round(s / 60));
    return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${pad(minutes % 60)} min`;
  }

  const pad = (number) => String(number).padStart(2, "0");
  const wall = (date) => `${pad(date.getHours())}:${pad(date.getMinutes())}`;
  // 24 Nov 2026: in this order and with the month's name nobody takes one for the other
  const date = (at) => at.toLocaleDateString("en-GB", { day: "numeric", month: "short", year: "numeric" });
  // 14:36 today, Tue 14:36 on another day of the week to come, 24 Nov 14:36 later
  function day(at) {
    const days = Math.round((new Date(at).setHours(0, 0, 0, 0) - new Date().setHours(0, 0, 0, 0)) / 86400000);
    if (days === 0) return wall(at);
    return `${at.toLocaleDateString("en-GB", days > 0 && days < 7 ? { weekday: "short" } : { day: "numeric", month: "short" })} ${wall(at)}`;
  }
  const wallSeconds = (date) => `${wall(date)}:${pad(date.getSeconds())}`;
  const initials = (name) => name.split(/\s+/).filter(Boolean).map((part) => part[0]).slice(0, 2).join("").toUpperCase() || "?";

  Object.assign(HL, { words: { age, since, clock, left, wall, date, day, wallSeconds, initials } });
})();
