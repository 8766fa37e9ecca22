// What a state is: what it does, how long it takes, what leads in and out.
(() => {
  "use strict";
  const { el, text, words } = HL;
  const KINDS = { simple: "State", composite: "State with states in it", parallel: "All its regions run at once", region: "Region", final: "End" };

  const part = (head, ...rows) => (rows.length ? el("section", { class: "s-sheetpart" }, el("h3", {}, head), ...rows) : null);
  const line = (left, right) => el("div", { class: "s-sheetline" }, el("span", { class: "h-2" }, left), el("span", { class: "h-b" }, right));

  function move(facts, one, isOut, open) {
    const other = facts.byId.get(isOut ? one.target : one.source);
    return el("div", { class: "s-move" }, el("span", {}, el("b", {}, one.event || "by itself"), one.guard ? el("span", { class: "h-2" }, ` if ${one.guard}`) : ""), el("button", { type: "button", class: "h-btn s-goto", onclick: () => open(other.id) }, `${isOut ? "to" : "from"} ${other?.label ?? "?"}`));
  }

  function stateSheet(chart, facts, id, active) {
    const state = facts.byId.get(id);
    if (!state) return;
    const since = active?.states.find(([one]) => one === id)?.[1];
    const { out, into } = HL.chartFacts.moves(chart, id);
    const open = (other) => stateSheet(chart, facts, other, active);
    const last = el("div", { class: "s-lasttimes", role: "status" }, "Loading");
    HL.sheet({
      title: state.label,
      hook: "state-sheet",
      body: [
        el("p", { class: "h-2 h-t14" }, [facts.path(id).slice(0, -1).map((one) => one.label).join(", "), KINDS[state.kind], state.subsystem].filter(Boolean).join(" · ")),
        part("Time", line("Now", since === undefined ? "not active" : `active for ${words.age(HL.port.age(since))}`), line("Normal", state.normal_s ? HL.chartFacts.span(state.normal_s) : "no usual time"), line("Last times, 1 h", last)),
        part("On entry", ...state.entry.map((what) => el("div", {}, what))),
        part("On exit", ...state.exit.map((what) => el("div", {}, what))),
        part("Leads to", ...out.map((one) => move(facts, one, true, open))),
        part("Comes from", ...into.map((one) => move(facts, one, false, open))),
      ].filter(Boolean),
      buttons: [["Close", (close) => close(), true]],
    });
    lastTimes(id, last);
  }

  async function lastTimes(id, node) {
    const answer = await HL.port.api("GET", `/robots/${HL.view.robot}/state-times?minutes=60`);
    if (!answer.ok) return text(node, answer.text);
    const own = answer.data.intervals.filter((one) => one.state === id && one.end !== null);
    const all = answer.data.per_state.find((one) => one.state === id);
    if (!own.length) return text(node, "none on record");
    const shown = own.slice(-5).reverse().map((one) => HL.chartFacts.span((one.end - one.start) / 1000)).join(", ");
    return text(node, `${shown}; mean ${HL.chartFacts.span(all?.mean_s ?? 0)} of ${own.length}`);
  }

  HL.stateSheet = stateSheet;
})();
