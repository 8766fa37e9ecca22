// The numbers of a plan beside its picture: path, time, turns, ground, energy with reserve; and the row orders compared.
(() => {
  "use strict";
  const { el, icon, attr, text, words } = HL;
  const { NAMES } = HL.planner;

  const SOON_S = 2; // before that nobody counts
  const LONG_S = 6;
  const MANY_S = 360000; // of a hundred hours nobody counts the minutes

  // how far a planner service is, in its words and per cent: {text, share}
  const stepWords = (step) => (step.share > 0 && step.share < 1 ? `${step.text}, ${Math.round(100 * step.share)} %` : step.text);

  // where a plan was made, if a planner service is set: a warning where it was not made there
  function place(s) {
    if (!s.planned_at) return [];
    const isHere = s.planned_at.where === "here";
    return [el("div", { class: `h-row h-t14 ${isHere ? "h-b" : "h-2"}`, "data-testid": "plan-place", "data-where": s.planned_at.where }, icon(isHere ? "cloud_off" : "check", "m"), el("span", {}, s.planned_at.text))];
  }

  // what is said over the empty picture; whoever waits long learns how long it can take; step: of a planner service
  function planningWords(pattern, done, seconds, step) {
    if (step) return `${NAMES[step.pattern]}: ${stepWords(step)}`;
    const name = `Planning ${NAMES[pattern].toLowerCase()}`;
    if (seconds < SOON_S) return name;
    return `${name}, ${seconds} s. ${done} of ${Object.keys(NAMES).length} row orders are done.${seconds < LONG_S ? "" : " A large field with narrow rows takes up to a minute each; Cancel planning ends it at once."}`;
  }

  const share = (part, whole) => (whole > 0 ? (100 * part) / whole : 0);
  const kwh = (j) => (j / 3.6e6).toFixed(1);
  const hours = (s) => [Math.floor(Math.round(s / 60) / 60), String(Math.round(s / 60) % 60).padStart(2, "0")].join(":");
  // the last word is the unit: 6 h 12 and min
  const time = (s) => (s >= MANY_S ? [String(Math.round(s / 3600)), "h"] : [words.left(s).replace(/ min$/, ""), "min"]);
  const km = (m) => (m >= 1000 ? [(m / 1000).toFixed(2), "km"] : [m.toFixed(0), "m"]);

  function card(hook, label, [number, unit], line, value) {
    return el("div", { class: "h-card p-stat", "data-testid": `plan-stat-${hook}`, "data-value": value }, el("div", { class: "h-h" }, label), el("div", { class: "p-big" }, number, " ", el("small", {}, unit)), el("div", { class: "h-t12 h-2" }, line));
  }

  function cards(s) {
    const area = HL.units.area(s.covered_m2);
    const turning = Math.max(0, s.duration_s - s.working_s);
    const wanted = s.wanted_m2 ?? s.area_m2;
    const missed = s.missed_m2 ?? Math.max(0, wanted - s.covered_m2);
    const overlap = el("span", { "data-testid": "plan-stat-overlap", "data-value": share(s.overlap_m2, s.area_m2) / 100 }, `overlap ${share(s.overlap_m2, s.area_m2).toFixed(1)}`);
    const more = s.seedlings === undefined ? [] : [card("seedlings", "Seedlings", [String(s.seedlings), ""], `one every ${s.plant_spacing_m.toFixed(2)} m`, s.seedlings)];
    return el("div", { class: "p-stats" },
      card("length", "Path", km(s.length_m), `${s.rows} rows${HL.planner.ALONG[s.rows_along] ?? ""}, ${s.headland_passes} ${s.headland_passes === 1 ? "lap" : "laps"}, ${km(s.working_length_m).join(" ")} worked`, s.length_m),
      card("time", "Time", time(s.duration_s), `${words.left(s.working_s)} work, ${words.left(turning)} turns`, s.duration_s),
      card("turns", "Turns", [String(s.turns), ""], `${s.turns ? `${(turning / s.turns).toFixed(0)} s each with ways, ` : ""}${HL.plan.stops(s)}`, s.turns),
      card("coverage", "Covered", [share(wanted - missed, wanted).toFixed(1), "%"], el("span", {}, overlap, `, missed ${share(missed, wanted).toFixed(1)}, ${area.text} ${area.unit}`), share(wanted - missed, wanted) / 100),
      ...more);
  }

  // mission from the left, reserve hatched from the right; more than one battery fills the bar
  function energy(s) {
    const battery = s.battery_j || s.energy_j / Math.max(1e-9, s.battery_share);
    const reserve = s.reserve_share ?? 0.15;
    const used = Math.min(1, s.battery_share);
    const bar = el("div", { class: "p-bar", role: "img", "aria-label": `Mission ${Math.round(100 * s.battery_share)} %, reserve ${Math.round(100 * reserve)} %` }, el("i", { class: "used" }), el("i", { class: "reserve" }));
    bar.style.setProperty("--used", `${100 * used}%`);
    bar.style.setProperty("--reserve", `${100 * reserve}%`);
    const isOver = s.battery_share + reserve > 1;
    return el("div", { class: "h-card p-energy", "data-testid": "plan-stat-energy", "data-value": s.energy_j, "data-state": isOver ? "over" : "enough" },
      el("div", { class: "h-h" }, "Energy", el("span", { class: "h-end h-t14 h-b p-ink" }, `${kwh(s.energy_j)} kWh of ${kwh(battery)}`)), bar,
      el("div", { class: "h-row h-t13 h-2 p-shares" }, el("span", {}, `mission ${Math.round(100 * s.battery_share)} %`), el("span", { class: "h-end" }, `reserve to get home ${Math.round(100 * reserve)} %`)),
      isOver ? el("div", { class: "h-t13 h-b p-ink" }, `Takes ${Math.ceil(s.battery_share / Math.max(0.05, 1 - reserve))} ${s.is_tank ? "tanks" : "battery charges"}. Split the field, or ${s.is_tank ? "refuel" : "charge"} on the way.`) : "",
      s.energy_basis ? el("div", { class: "h-t12 h-2", "data-testid": "plan-energy-basis" }, s.energy_basis) : "");
  }

  // one line for each row order; a tap shows it
  class Compare {
    constructor(choose) {
      this.choose = choose;
      this.body = el("tbody");
      this.state = el("span", { class: "h-t13 h-2 h-end", role: "status", "data-testid": "plan-progress" });
      this.node = el("section", { class: "p-compare", hidden: true }, el("h3", { class: "h-t16 h-b h-row" }, "Compare", this.state),
        el("table", {}, el("thead", {}, el("tr", {}, ...["", "Time", "Path", "Turns", "kWh"].map((name, k) => el("th", { scope: "col", class: k ? "num" : "" }, k ? name : el("span", { class: "h-sr" }, "Row order"))))), this.body));
    }

    // answers: by pattern; chosen: the one in the picture; isPlanning
    paint(answers, chosen, isPlanning) {
      this.node.hidden = !answers.size && !isPlanning;
      const patterns = Object.keys(NAMES).filter((pattern) => answers.has(pattern) || isPlanning);
      if (!isPlanning) text(this.state, "");
      this.body.replaceChildren(...patterns.map((pattern) => this.row(pattern, answers, chosen)));
    }

    // one short line beside the heading: its width must not push the rows about
    progress(done, seconds, step) {
      const isUnder = step?.share > 0 && step.share < 1;
      const since = isUnder ? `, next ${Math.round(100 * step.share)} %` : seconds < SOON_S ? "" : `, ${seconds} s`;
      text(this.state, `${done} of ${Object.keys(NAMES).length} planned${since}`);
    }

    row(pattern, answers, chosen) {
      const answer = answers.get(pattern);
      const state = answer?.state ?? "planning";
      const s = answer?.statistics;
      const isShown = pattern === chosen;
      const name = el("button", { type: "button", class: "p-pick", disabled: state !== "planned", "aria-pressed": isShown ? "true" : "false", onclick: () => this.choose(pattern) }, NAMES[pattern]);
      const row = el("tr", { "data-testid": `plan-compare-${pattern}`, "data-state": state, "aria-current": isShown ? "true" : null });
      if (s) row.append(el("td", {}, name), ...[hours(s.duration_s), (s.length_m / 1000).toFixed(2), s.turns, kwh(s.energy_j)].map((value) => el("td", { class: "num" }, String(value))));
      else row.append(el("td", { colspan: "5" }, name, el("div", { class: "p-why" }, why(answer, answers))));
      if (s) row.addEventListener("click", (event) => event.target.closest("button") || this.choose(pattern));
      attr(row, "data-value", s ? s.duration_s : null);
      return row;
    }
  }

  // what all row orders are refused for is said once
  function why(answer, answers) {
    if (!answer) return "planning";
    const first = answer.text && Object.keys(NAMES).map((pattern) => answers.get(pattern)).find((one) => one?.text === answer.text);
    if (first && first !== answer) return "for the same reason";
    return answer.state === "same" ? `the same path as ${NAMES[answer.as].toLowerCase()}` : answer.text;
  }

  Object.assign(HL.planner, { cards, energy, Compare, planningWords, place, hours });
})();
