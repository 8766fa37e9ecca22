// Hand-over between people and shifts: who is responsible, offers to take over, and the shift book.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const MOST_NAMES = 8;
  const LEFT_KEY = "headland.fleet.freed"; // robot id -> since when it is left without anybody here
  const names = (robots) => robots.map(HL.fleet.name).join(", ");
  const someNames = (robots) => names(robots.slice(0, MOST_NAMES)) + (robots.length > MOST_NAMES ? ` and ${robots.length - MOST_NAMES} more` : "");
  const count = (robots) => (robots.length === 1 ? HL.fleet.name(robots[0]) : `${robots.length} robots`);
  const time = (ms) => (ms ? HL.words.wall(new Date(ms)) : "");
  const WORDS = { taken: "took", released: "gave up", offered: "offered", accepted: "took over", declined: "declined", withdrawn: "withdrew the offer of" };

  async function post(path, body) {
    const answer = await HL.port.api("POST", `/fleet/duty/${path}`, body);
    if (!answer.ok) HL.toast(answer.text, "block");
    await HL.fleet.loadDuty();
    return answer;
  }

  const take = (robots) => post("handover", { robots, to_user: HL.fleet.me() });
  const withdraw = (robots) => post("decline", { robots });
  const release = (robots) => post("release", { robots });

  async function handOver(robots) {
    if (!robots.length) return;
    await HL.fleet.loadDuty();
    const me = HL.fleet.me();
    const person = el("select", { class: "h-select", "data-testid": "duty-person" }, ...[...HL.fleet.people].sort((a, b) => (a.id === me) - (b.id === me)).map((one) => el("option", { value: one.id }, one.id === HL.fleet.me() ? `${one.name} (me)` : `${one.name}, ${one.role}`)));
    const note = el("textarea", { class: "h-input f-text", maxlength: "500", rows: "3", placeholder: "What the next one should know", "aria-label": "Note", "data-testid": "duty-note" });
    const said = el("span", { class: "h-error", role: "alert" });
    const go = async (close) => {
      const answer = await HL.port.api("POST", "/fleet/duty/handover", { robots, to_user: person.value, note: note.value.trim() });
      if (!answer.ok) return text(said, answer.text);
      await HL.fleet.loadDuty();
      close();
      return HL.toast(person.value === HL.fleet.me() ? `You are responsible for ${count(robots)}` : `Offered. You stay responsible until it is taken over.`, "badge");
    };
    HL.sheet({
      title: `Hand over ${count(robots)}`, hook: "duty-sheet",
      body: [el("p", { class: "h-2 h-t16" }, names(robots)), el("label", { class: "h-field" }, "To", person), el("label", { class: "h-field" }, "Note", note), el("p", { class: "h-2 h-t14" }, "Responsibility is not control: it moves nothing. Whoever gives stays responsible until the other takes over."), said, book()],
      buttons: [["Cancel", (close) => close()], ["Hand over", go, true]],
    });
  }

  function book() {
    const lines = HL.fleet.book.slice(0, 8);
    if (!lines.length) return "";
    return el("details", { class: "f-book" }, el("summary", {}, "Shift book"), el("ul", { "data-testid": "duty-book" }, ...lines.map((line) => el("li", { class: "h-t14" }, el("b", {}, time(line.at)), ` ${line.by} ${WORDS[line.what] ?? line.what} ${count(line.robots)}${line.what === "offered" ? ` to ${line.to}` : ""}${line.note ? `: ${line.note}` : ""}`))));
  }

  // offers to me, in one line each person and note
  function offers() {
    const mine = Object.entries(HL.fleet.duty).filter(([, duty]) => duty.offer?.to === HL.fleet.me());
    const kept = new Map();
    for (const [robot, { offer }] of mine) {
      const key = `${offer.by}|${offer.note}`;
      if (!kept.has(key)) kept.set(key, { ...offer, robots: [] });
      kept.get(key).robots.push(robot);
    }
    return [...kept.values()];
  }

  // What lost its person, for those who see to that; not what is offered to somebody, or was left so here.
  function freed() {
    if (!HL.fleet.can("take_lease")) return [];
    const left = HL.keep.read(LEFT_KEY, {});
    const known = HL.port.fleet();
    return Object.entries(HL.fleet.freed).filter(([robot, { since }]) => robot in known && !HL.fleet.duty[robot]?.offer && left[robot] !== since).map(([robot]) => robot);
  }

  function freedLine(robots) {
    const sinces = robots.map((robot) => HL.fleet.freed[robot].since);
    const leave = () => (HL.keep.write(LEFT_KEY, Object.fromEntries(Object.entries(HL.fleet.freed).map(([robot, { since }]) => [robot, since]))), HL.fleet.changed());
    return el("div", { class: "f-offer", role: "alert", "data-testid": "duty-freed" }, icon("badge"), el("span", { class: "h-col" }, el("b", {}, `Nobody is responsible for ${count(robots)} any more`), el("span", { class: "h-t14" }, [`Since ${time(Math.min(...sinces))}`, robots.length > 1 ? someNames(robots) : ""].filter(Boolean).join(" · "))),
      el("span", { class: "h-sp" }), el("button", { type: "button", class: "h-btn pri", "data-testid": "duty-freed-take", onclick: () => take(robots) }, "I am responsible"), el("button", { type: "button", class: "h-btn", "data-testid": "duty-freed-give", onclick: () => handOver(robots) }, "Hand over"), el("button", { type: "button", class: "h-btn", "data-testid": "duty-freed-leave", onclick: leave }, "Leave it"));
  }

  class Offers {
    constructor(place) {
      this.place = place;
    }
    paint() {
      const found = offers();
      const lost = freed();
      const key = JSON.stringify([found, lost]);
      if (key === this.key) return;
      this.key = key;
      this.place.replaceChildren(...(lost.length ? [freedLine(lost)] : []), ...found.map((one) => el("div", { class: "f-offer", role: "alert", "data-testid": "duty-offer" }, icon("badge"), el("span", { class: "h-col" }, el("b", {}, `${one.by} hands over ${count(one.robots)}`), el("span", { class: "h-t14" }, [one.note, one.robots.length > 1 ? someNames(one.robots) : ""].filter(Boolean).join(" · "))),
        el("span", { class: "h-sp" }), el("button", { type: "button", class: "h-btn pri", "data-testid": "duty-accept", onclick: () => post("accept", { robots: one.robots }) }, "Take over"), el("button", { type: "button", class: "h-btn", onclick: () => post("decline", { robots: one.robots }) }, "Not me"))));
    }
  }

  // one line about a robot, for its menu
  function line(id) {
    const duty = HL.fleet.duty[id];
    const offer = duty?.offer ? ` Offered to ${duty.offer.to_name}.` : "";
    if (!duty?.user) return `Nobody is responsible.${offer}`;
    return `${duty.user === HL.fleet.me() ? "You are" : `${duty.name} is`} responsible since ${time(duty.since)}.${offer}${duty.note ? ` Note: ${duty.note}` : ""}`;
  }

  // who offered it, or is responsible, may take the offer back
  function canWithdraw(id) {
    const duty = HL.fleet.duty[id];
    return Boolean(duty?.offer) && [duty.user, duty.offer.by_id].includes(HL.fleet.me());
  }

  HL.fleetDuty = { handOver, take, release, withdraw, canWithdraw, line, Offers };
})();
