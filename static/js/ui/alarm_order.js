// Which alarms are listed, in which order, and what is folded under its cause in a flood. Pure.
(() => {
  "use strict";
  const ACTIVE = ["unacknowledged", "acknowledged", "returned", "latched"];
  const ASIDE = ["shelved", "suppressed", "out_of_service"];
  const RANK = { unacknowledged: 0, returned: 1, latched: 2, acknowledged: 3 };

  const isActive = (one) => ACTIVE.includes(one.state);
  const isAside = (one) => ASIDE.includes(one.state);
  const isUnseen = (one) => one.state === "unacknowledged" || one.state === "returned";

  // Whether a step in its life is said anew: it came, nobody answered it, or it is back from where it was put and still so.
  const BACK = ["unshelved", "unsuppressed", "in_service"];
  const isNews = ({ what, state }) => !ASIDE.includes(state) && (what === "raised" || what === "escalated" || (BACK.includes(what) && state === "unacknowledged"));

  // it was told on because nobody answered, and still nobody does
  const isUnanswered = (one) => Boolean(one.escalated) && isUnseen(one);

  // the most urgent first; of those what nobody has seen, what is so before what is over, and told on before the others; then the newest
  function compare([a, one], [b, other]) {
    return one.priority - other.priority || (RANK[one.state] ?? 4) - (RANK[other.state] ?? 4) || isUnanswered(other) - isUnanswered(one) || other.raised - one.raised || (a < b ? -1 : 1);
  }

  // filter: {robot, priority, q}
  function matches(one, { robot = "", priority = 0, q = "" } = {}) {
    if (robot && one.source !== robot) return false;
    if (priority && one.priority !== priority) return false;
    return !q || `${one.title} ${one.name} ${one.text}`.toLowerCase().includes(q.toLowerCase());
  }

  const worst = (entries) => [...entries].sort(compare)[0] ?? null;

  // -> [{id, one, isKid, folds: [ids]}]; open: ids of causes whose followers are shown
  function rows(alarms, { isWanted = isActive, filter, isFlood = false, open = new Set() } = {}) {
    const entries = Object.entries(alarms).filter(([, one]) => isWanted(one) && matches(one, filter));
    if (!isFlood) return entries.sort(compare).map(([id, one]) => ({ id, one, isKid: false, folds: [], follows: 0 }));
    const groups = new Map();
    for (const entry of entries) {
      const cause = entry[1].first || entry[0];
      if (!groups.has(cause)) groups.set(cause, []);
      groups.get(cause).push(entry);
    }
    const ordered = [...groups.entries()].map(([cause, members]) => [cause, members.sort(([, one], [, other]) => (one.place ?? 1) - (other.place ?? 1) || one.raised - other.raised), worst(members)]);
    ordered.sort((a, b) => compare(a[2], b[2]));
    return ordered.flatMap(([, [head, ...kids]]) => family(head, kids, open.has(head[0])));
  }

  // critical ones are never folded away
  function family([id, one], kids, isOpen) {
    const hidden = isOpen ? [] : kids.filter(([, kid]) => kid.priority > 1).map(([kid]) => kid);
    const shown = kids.filter(([kid]) => !hidden.includes(kid));
    return [{ id, one, isKid: false, folds: hidden, follows: kids.length }, ...shown.map(([kid, entry]) => ({ id: kid, one: entry, isKid: true, folds: [], follows: 0 }))];
  }

  const nth = (number) => `${number}${[11, 12, 13].includes(number % 100) ? "th" : ["th", "st", "nd", "rd"][number % 10] ?? "th"}`;
  const lower = (title) => (/^[A-Z][a-z ]/.test(title) ? title[0].toLowerCase() + title.slice(1) : title);

  // {isFirst, text}: "First out, 1 of 3", "2nd, after no data link"
  function sequence(one, firstTitle) {
    if (!one.group || one.group < 2) return { isFirst: false, text: "" };
    if (one.place === 1) return { isFirst: true, text: `First out, 1 of ${one.group}` };
    return { isFirst: false, text: `${nth(one.place)}${firstTitle ? `, after ${lower(firstTitle)}` : ` of ${one.group}`}` };
  }

  HL.alarmOrder = { isActive, isAside, isUnseen, isUnanswered, isNews, compare, matches, worst, rows, sequence };
})();
