// What a robot's row says, and in which order rows stand. Pure: no DOM, no lane; the caller gives states and times.
(() => {
  "use strict";
  const SOON_S = 900; // a robot that needs somebody within a quarter of an hour is watched
  const LOST_MS = 3500;
  const FOLD_ABOVE = 200; // robots beyond which those that need nobody fold into groups
  const STANDS = 3; // how urgent a robot is that only waits for somebody
  const OVER = "Nobody has acknowledged it.";
  // What it says of itself may not hold while one of these does: what to do is what the alarm says, not what clears its hold.
  const UNSAFE = new Set(["stop-not-confirmed", "moves-after-stop", "tool-on-unasked", "outside-fence"]);
  const ACTIVE = { unacknowledged: 0, latched: 1, acknowledged: 2, returned: 3 };
  const FAMILIES = { weeder: "Weeders", planter: "Planters", uav: "UAVs", other: "Other robots" };
  const names = new Intl.Collator("en", { numeric: true });
  const orInfinity = (value) => (typeof value === "number" ? value : Infinity);

  // the worst alarm of each source: {robot id: alarm with its id}
  function worstAlarms(alarms) {
    const worst = {};
    for (const [id, alarm] of Object.entries(alarms || {})) {
      if (!alarm || !(alarm.state in ACTIVE)) continue;
      const held = worst[alarm.source];
      if (!held || compareAlarms(alarm, held) < 0) worst[alarm.source] = { ...alarm, id };
    }
    return worst;
  }

  // Alarms of priority 1 and 2 that are of no robot, of the console or a station, stand in the list like robots.
  function notices(alarms, robots) {
    const all = Object.entries(alarms || {}).filter(([, one]) => one && one.state in ACTIVE && one.priority <= 2 && !(one.source in robots));
    return all.map(([id, one]) => noticeOf({ ...one, id })).filter((one) => one.verdict.group === "needs-you");
  }
  function noticeOf(alarm) {
    const robot = { name: alarm.name, why: "" };
    return { id: alarm.id, isNotice: true, robot, ageMs: 0, verdict: judge(robot, { ageMs: 0, alarm }) };
  }

  // it was told on because nobody answered, and still nobody does
  const isUnanswered = (alarm) => Boolean(alarm?.escalated) && (alarm.state === "unacknowledged" || alarm.state === "returned");
  // what is over, answered or not, hides nothing that is so now
  const compareAlarms = (a, b) => a.priority - b.priority || ACTIVE[a.state] - ACTIVE[b.state] || isUnanswered(b) - isUnanswered(a) || a.raised - b.raised;

  // "about 1 min", for how long clearing takes
  const about = (s) => (s === null || s === undefined ? "" : s < 45 ? `about ${s} s` : `about ${Math.max(1, Math.round(s / 60))} min`);
  const inTime = (s) => (s < 60 ? "now" : `in ${Math.round(s / 60)} min`);

  // parts as sentences, one after the other; the last keeps its end
  const said = (...parts) => parts.filter(Boolean).map((part, i, all) => (i === all.length - 1 || /[.!?…]$/.test(part) ? part : `${part}.`)).join(" ");

  // what clears it, who can, how long it takes
  function advice(robot) {
    const parts = [robot.clears, robot.who && robot.who !== "nobody" ? `Who: ${robot.who}` : "", about(robot.takes_s)];
    return parts.filter(Boolean).map((part) => part.replace(/\.$/, "")).join(". ");
  }

  // {level, head, line, since (console ms), look, waits, helpS, group}; `ageMs` of the newest heartbeat, Infinity if never
  function judge(robot, { ageMs, stop = null, alarm = null, words, responsible = "" }) {
    const found = verdict(robot, ageMs, stop, alarm, words);
    found.isUnanswered = Boolean(found.alarm) && isUnanswered(alarm);
    if (found.isUnanswered) found.line = `Nobody answered${responsible ? `, responsible: ${responsible}` : ""}. ${found.line}`;
    const isSoon = !found.level && typeof robot.help_s === "number" && robot.help_s <= SOON_S && robot.mode === "auto";
    if (isSoon) Object.assign(found, { level: 4, head: `Needs somebody ${inTime(robot.help_s)}`, line: "Battery at its reserve, or the mission ends" });
    found.helpS = found.level === 1 || found.waits ? 0 : orInfinity(robot.help_s);
    const isUrgent = found.level === 1 || (found.level === 2 && !found.isOver);
    found.group = isUrgent || found.waits ? "needs-you" : found.level ? "watch" : "normal";
    return found;
  }

  function verdict(robot, ageMs, stop, alarm, words) {
    if (stop?.state === "not-confirmed") return { level: 1, head: "Stop not confirmed", line: "Use the red button on the machine", since: stop.t ?? null, look: "unacknowledged", waits: true, isLost: robot.is_online === false || ageMs > LOST_MS };
    if (robot.is_registered === false) return { level: 4, head: "New robot", line: "An admin must accept it before it can be operated", since: null, waits: false };
    if (robot.is_online === false || ageMs > LOST_MS) return lost(robot, ageMs, alarm, words);
    if (alarm && isAlarmFirst(robot, alarm)) return ofAlarm(robot, alarm);
    if (needs(robot) || alarm) return ofRobot(robot, alarm);
    return { level: null, head: robot.task || robot.text || "–", line: robot.why || "", since: robot.since ?? null, waits: false };
  }

  // an alarm whose cause is gone, which nobody has seen yet
  const isOver = (alarm) => alarm.state === "returned";
  const unseen = (alarm) => (isUnanswered(alarm) ? "" : OVER); // where that is said in front
  const needs = (robot) => Boolean(robot.waits || robot.level);
  // how urgent it is that it stands; what is more urgent has an alarm of its own
  const standing = (robot) => (!robot.why || !needs(robot) ? Infinity : robot.waits ? STANDS : Math.max(STANDS, robot.level));
  const isHeld = (robot) => Boolean(robot.why) && robot.code !== "charging"; // what only charges is held by nothing
  const isAlarmFirst = (robot, alarm) => (isOver(alarm) ? !needs(robot) && !isHeld(robot) : alarm.priority < standing(robot));
  // "person-ahead" of the hold "person_ahead": the same in other words
  const isOwn = (robot, alarm) => alarm.code === (robot.code || "").replaceAll("_", "-");

  // Why it stands, what clears it, who can; then what an alarm says beside it that is no more urgent, or over.
  function ofRobot(robot, alarm) {
    const level = robot.waits ? Math.min(STANDS, robot.level ?? STANDS) : robot.level;
    const found = { level, head: robot.why || robot.fault || robot.text, line: advice(robot), since: robot.since ?? null, look: "acknowledged", waits: Boolean(robot.waits) };
    if (!alarm) return found;
    if (isOver(alarm)) {
      if (needs(robot)) return { ...found, line: said(found.line, `${alarm.title}: over`, OVER) };
      const line = said(found.line, `${alarm.title}: over`, unseen(alarm));
      return { ...found, level: alarm.priority, line, since: alarm.t ?? null, look: alarm.state, alarm: alarm.id, isOver: true };
    }
    const isEqual = alarm.priority === standing(robot);
    const same = { ...found, level: standing(robot), ...(isEqual && { look: alarm.state }) };
    if (!isOther(robot, alarm)) return { ...same, alarm: alarm.id };
    return { ...same, line: said(found.line, alarm.title, news(alarm), isUnanswered(alarm) && "Nobody answered") };
  }

  // whether why it stands says anything that the alarm does not
  const isOther = (robot, alarm) => robot.why && !isOwn(robot, alarm) && !starts(robot.why, alarm.title) && !(alarm.text || "").includes(robot.why.replace(/\.$/, ""));

  // The answer stands before the words of the alarm: those are cut off where there is little room.
  function ofAlarm(robot, alarm) {
    const level = alarm.priority;
    const about = { level, since: alarm.t ?? null, look: alarm.state, waits: Boolean(robot.waits), alarm: alarm.id };
    if (isOver(alarm)) return { ...about, isOver: true, head: `${alarm.title}: over`, line: said("It is gone again.", unseen(alarm)) };
    if (UNSAFE.has(alarm.code)) return { ...about, head: alarm.title, line: said(...(alarm.steps ?? []), news(alarm)) };
    return { ...about, head: alarm.title, line: said(isOther(robot, alarm) && robot.why, advice(robot), news(alarm)) || robot.why };
  }

  // What a text adds to its title: one that only says the title again is no news, nor is its beginning if that does.
  const plain = (words) => (words || "").toLowerCase().replace(/^(the|its|it) /, "").replace(/\b(is|has|are) /g, "").replace(/[.…\s]+$/, "");
  const starts = (text, title) => plain(text).startsWith(plain(title)) && plain(text).length < plain(title).length + 4;
  function news({ title, text }) {
    if (!text || starts(text, title)) return "";
    const [first, ...rest] = text.split(": ");
    const more = rest.join(": ");
    return more && starts(first, title) ? more[0].toUpperCase() + more.slice(1) : text;
  }

  // It is silent. What it was last heard doing comes first if that is critical: nobody walks up to it for its radio.
  function lost(robot, ageMs, alarm, words) {
    const isKnown = Number.isFinite(ageMs);
    const silent = isKnown ? `No link for ${words.since(ageMs)}` : "Never heard";
    const found = { level: alarm ? Math.min(2, alarm.priority) : 2, head: silent, since: robot.t ?? null, look: "acknowledged", waits: false, isLost: true, alarm: alarm?.id };
    const isCritical = alarm?.priority === 1 && alarm.code !== "link-lost";
    if (isCritical && isOver(alarm)) return { ...found, line: said("Look before you walk up to it", `${alarm.title}: over`, unseen(alarm)) };
    if (isCritical) return { ...found, head: alarm.title, line: said(silent, alarm.steps?.[0], `Last heard: ${alarm.text || alarm.title}`), look: alarm.state };
    if (alarm?.priority <= 2 && !isOver(alarm)) found.look = alarm.state;
    return { ...found, line: isKnown ? "Its values are old. Look at its power and radio" : "Not heard since the server started" };
  }

  // priority, then what is so before what is over, then how soon help is needed, then who waits longest, then by name
  function byAttention(a, b) {
    return (a.verdict.level ?? 9) - (b.verdict.level ?? 9) || Boolean(a.verdict.isOver) - Boolean(b.verdict.isOver) || Boolean(b.verdict.isUnanswered) - Boolean(a.verdict.isUnanswered) || cmp(a.verdict.helpS, b.verdict.helpS) || cmp(orInfinity(a.verdict.since), orInfinity(b.verdict.since)) || byName(a, b);
  }
  const cmp = (a, b) => (a === b ? 0 : a < b ? -1 : 1);
  const byName = (a, b) => (a.rank !== undefined && b.rank !== undefined ? a.rank - b.rank : names.compare(a.robot.name, b.robot.name) || cmp(a.id, b.id));

  // comparing names as people count is dear: their order is worked out once for the same names
  let ranked = { size: -1, names: new Map() };
  function rank(items) {
    if (items.length === ranked.size && items.every((one) => one.rank !== undefined && ranked.names.get(one.id) === one.robot.name)) return items;
    const order = [...items].sort((a, b) => names.compare(a.robot.name, b.robot.name) || cmp(a.id, b.id));
    ranked = { size: items.length, names: new Map(items.map((one) => [one.id, one.robot.name])) };
    order.forEach((one, i) => (one.rank = i));
    return items;
  }

  // whether a robot's place in the list differs by it: of those that need nobody only by what says so
  function isMoved(before, now) {
    return before.level !== now.level || before.group !== now.group || before.isOver !== now.isOver || before.isUnanswered !== now.isUnanswered || (now.group !== "normal" && (before.helpS !== now.helpS || before.since !== now.since));
  }

  function matches(item, query) {
    if (!query) return true;
    const { robot, verdict: v } = item;
    const hay = [item.id, robot.name, robot.field, robot.mission?.name, robot.text, robot.task, v.head, item.responsible].join(" ").toLowerCase();
    return query.toLowerCase().split(/\s+/).filter(Boolean).every((word) => hay.includes(word));
  }

  // filter: {q, families: [], group: id or "", mine, state: "" | "needs" | "working" | "idle" | "offline"}
  function passes(item, filter, { me = "", groups = [] } = {}) {
    const { robot, verdict: v } = item;
    if (!matches(item, filter.q)) return false;
    if (filter.families?.length && !filter.families.includes(robot.family)) return false;
    if (!isIn(groups, filter.group, item.id)) return false;
    if (filter.mine && item.duty?.user !== me) return false;
    if (filter.state === "needs") return v.group === "needs-you";
    if (filter.state === "working") return isWorking(robot) && !v.isLost;
    if (filter.state === "idle") return !isWorking(robot) && !v.isLost;
    return filter.state === "offline" ? Boolean(v.isLost) : true;
  }

  // a group that is not known, or not yet, hides nobody
  const isIn = (groups, id, robot) => groups.find((one) => one.id === id)?.robots.includes(robot) ?? true;
  const isWorking = (robot) => robot.mode === "auto" && robot.mission?.status === "running";

  // the first saved group that holds it, else its field, else its kind
  function homeOf(item, groups) {
    const group = groups.find((one) => one.robots.includes(item.id));
    return group?.name || item.robot.field || FAMILIES[item.robot.family] || FAMILIES.other;
  }

  // -> [{key, title, items, kind: "rows" | "cells", folded}] in the order they are read
  function sections(items, { sort = "attention", groups = [], open = new Set(), notices = [] } = {}) {
    if (sort === "name" || sort === "group") {
      const rows = sort === "name" ? [{ key: "all", title: "All robots", kind: "rows", items: [...items].sort(byName) }] : gather([...items].sort(byAttention), groups, "rows", () => false);
      return notices.length ? [{ key: "needs-you", title: "Needs you", kind: "rows", items: [...notices].sort(byAttention) }, ...rows] : rows;
    }
    const of = (group) => [...(group === "needs-you" ? notices : []), ...items.filter((one) => one.verdict.group === group)].sort(byAttention);
    const normal = of("normal").sort(byName);
    const isFolded = items.length > FOLD_ABOVE;
    const rest = isFolded ? gather(normal, groups, "cells", (key) => !open.has(key)) : [];
    return [
      { key: "needs-you", title: "Needs you", kind: "rows", items: of("needs-you") },
      { key: "watch", title: "Watch", kind: "rows", items: of("watch") },
      { key: "normal", title: "Normal", kind: "cells", items: isFolded ? [] : normal, count: normal.length },
      ...rest,
    ];
  }

  function gather(items, groups, kind, isFolded) {
    const homes = new Map();
    for (const one of items) {
      const home = homeOf(one, groups);
      if (!homes.has(home)) homes.set(home, []);
      homes.get(home).push(one);
    }
    return [...homes].sort((a, b) => names.compare(a[0], b[0])).map(([title, found]) => {
      const key = `in-${title}`;
      return { key, title, kind, items: isFolded(key) ? [] : found, count: found.length, folded: isFolded(key), canFold: kind === "cells" };
    });
  }

  // Rows hold still under the pointer: those known keep their order and place, new ones come last.
  function hold(before, now) {
    const place = new Map(before.flatMap((section) => section.items.map((one) => [one.id, section.key])));
    const fresh = new Map(now.flatMap((section) => section.items.map((one) => [one.id, one])));
    const kept = before.map((section) => ({ ...section, items: section.items.filter((one) => fresh.has(one.id)).map((one) => fresh.get(one.id)) }));
    let moved = 0;
    for (const section of now) {
      for (const one of section.items) {
        if (!place.has(one.id)) (kept.find((k) => k.key === section.key) ?? kept.at(-1))?.items.push(one);
        else if (place.get(one.id) !== section.key) moved += 1;
      }
    }
    return { sections: kept, moved };
  }

  // worst of several, for clusters and folded groups: {level, look, count}
  function worst(items) {
    const found = items.filter((one) => one.verdict.level).sort(byAttention)[0];
    return { level: found?.verdict.level ?? null, look: found?.verdict.look ?? null, count: items.length };
  }

  // what the strip says live: {total, working, slowestMs, oldestMs, newestMs, offline}
  function figures(items) {
    if (!counted.has(items)) counted.set(items, count(items));
    return counted.get(items);
  }
  const counted = new WeakMap(); // one look is asked about many times

  function count(items) {
    const found = { total: items.length, working: 0, offline: 0, slowestMs: null, oldestMs: null, newestMs: null, planters: false };
    for (const { robot, verdict: v, ageMs } of items) {
      if (robot.family === "planter") found.planters = true;
      if (v.isLost || robot.is_registered === false) {
        found.offline += 1;
        continue;
      }
      if (isWorking(robot)) found.working += 1;
      if (typeof robot.rtt_ms === "number") found.slowestMs = Math.max(found.slowestMs ?? 0, robot.rtt_ms);
      if (!Number.isFinite(ageMs)) continue;
      found.oldestMs = Math.max(found.oldestMs ?? 0, ageMs);
      found.newestMs = Math.min(found.newestMs ?? Infinity, ageMs);
    }
    return found;
  }

  HL.fleetOrder = { judge, rank, worstAlarms, notices, sections, passes, matches, hold, isMoved, worst, figures, advice, homeOf, isWorking, FAMILIES, FOLD_ABOVE };
})();
