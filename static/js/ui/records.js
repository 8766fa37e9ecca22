// Tables of records from REST: loading, empty, error with a way to try again.
(() => {
  "use strict";
  const { el, icon } = HL;

  function table(columns, rows) {
    return el("div", { class: "h-tablewrap" }, el("table", { class: "h-table" },
      el("thead", {}, el("tr", {}, ...columns.map((name) => el("th", { scope: "col" }, name)))),
      el("tbody", {}, ...rows.map(({ hook, cells }) => el("tr", { "data-testid": hook }, ...cells.map((cell, i) => el("td", { "data-of": columns[i] }, cell)))))));
  }

  const skeleton = () => el("div", { class: "h-card h-skeleton", "aria-label": "Loading" }, ...["100%", "82%", "92%"].map((width) => { const bar = el("i"); bar.style.width = width; return bar; }));

  function failure(what, answer, again) {
    return el("div", { class: "h-card h-notice", role: "alert" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, `${what} did not load`), el("span", { class: "h-2" }, answer.text || "Server did not answer. STOP still works."), el("button", { type: "button", class: "h-btn", onclick: again }, icon("refresh", "m"), "Try again"));
  }

  const empty = (head, line) => el("div", { class: "h-card h-notice" }, el("b", { class: "h-t18 h-b" }, head), el("span", { class: "h-2" }, line));

  // fills `place` with what GET path answers; `draw(answer)` makes the nodes. Whether it did
  async function load(place, what, path, draw) {
    place.replaceChildren(skeleton());
    const answer = await HL.port.api("GET", path);
    if (!place.isConnected) return false;
    place.replaceChildren(...[answer.ok ? draw(answer) : failure(what, answer, () => load(place, what, path, draw))].flat());
    return answer.ok;
  }

  const list = (answer, key) => (Array.isArray(answer.data) ? answer.data : answer[key] ?? []);
  const when = (utc) => (utc ? `${HL.words.date(new Date(utc))}, ${HL.words.wallSeconds(new Date(utc))}` : "–");

  HL.records = { table, load, empty, list, when };
})();
