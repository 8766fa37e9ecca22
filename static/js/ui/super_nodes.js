// Software nodes: life cycle, rate, load, when heard, restarts, and what is wrong. A row opens the node's sheet.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, toggle, LiveElement, words } = HL;
  const NS = "http://www.w3.org/2000/svg";
  const LATE_PERIODS = 1.5;
  const SILENT_PERIODS = 3;
  const LIVES = {
    unknown: ["Unknown", ""],
    stopped: ["Stopped", ""],
    starting: ["Starting", "M8 8V1a7 7 0 0 1 7 7z"],
    started: ["Started", "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1z"],
    stopping: ["Stopping", "M8 1a7 7 0 0 0 0 14z"],
    failure: ["Failure", "cross"],
  };
  const COUNTED = { started: "started", starting: "starting", stopping: "stopping", stopped: "stopped", failure: "failed", unknown: "unknown" };

  // ○ stopped, ◔ starting, ● started, ◑ stopping, ⊗ failure; dashed while nothing is known
  function glyph(state) {
    const svg = document.createElementNS(NS, "svg");
    const add = (tag, values) => {
      const part = document.createElementNS(NS, tag);
      for (const [key, value] of Object.entries(values)) part.setAttribute(key, value);
      svg.append(part);
    };
    for (const [key, value] of Object.entries({ width: 16, height: 16, viewBox: "0 0 16 16", "aria-hidden": "true" })) svg.setAttribute(key, value);
    add("circle", { cx: 8, cy: 8, r: 6.6, fill: "none", stroke: "currentColor", "stroke-width": 1.8, ...(state === "unknown" ? { "stroke-dasharray": "2.4 2.4" } : {}) });
    const [, shape] = LIVES[state] ?? LIVES.unknown;
    if (shape === "cross") add("path", { d: "M5 5l6 6M11 5l-6 6", stroke: "currentColor", "stroke-width": 2 });
    else if (shape) add("path", { d: shape, fill: "currentColor" });
    return svg;
  }

  // fresh | late | stale | missing, by the period the node declares
  function heard(node) {
    const ageMs = HL.port.age(node.t);
    const state = !Number.isFinite(ageMs) ? "missing" : ageMs > SILENT_PERIODS * node.period_ms ? "stale" : ageMs > LATE_PERIODS * node.period_ms ? "late" : "fresh";
    return { ageMs, state };
  }

  const lifeWord = (node) => (heard(node).state === "stale" ? `Was ${LIVES[node.state][0].toLowerCase()}` : LIVES[node.state][0]);
  const number = (value, digits = 0) => (value === null || value === undefined ? "–" : value.toFixed(digits));
  const rate = (hz) => (hz === null || hz === undefined ? "–" : hz >= 100 ? hz.toFixed(0) : hz.toFixed(1));
  const all = () => HL.port.inside(HL.view.robot).nodes?.nodes;
  const find = (name) => all()?.find((one) => one.name === name);

  // "Waiting for first state", "State data stopped 41 s ago", or why there is nothing to show; empty when all is well
  function notice(what) {
    const { mode, link } = HL.port.robot(HL.view.robot);
    const state = HL.linkState();
    if (state === "server-lost") return `State data stopped ${words.since(HL.port.server().silentMs)} ago`;
    if (state === "robot-lost") return `State data stopped ${words.since(HL.port.age(link?.t))} ago`;
    if (!mode) return "Waiting for first state";
    return what === null ? "empty" : "";
  }

  class Nodes extends LiveElement {
    build() {
      this.sum = el("span", { class: "h-t13 h-2 h-ell sub" });
      this.logs = el("button", { type: "button", class: "h-btn", "data-testid": "logs-open", onclick: () => HL.superLogs.open() }, icon("lists", "m"), "Log");
      this.restart = el("button", { type: "button", class: "h-btn", "data-testid": "nodes-restart", onclick: () => HL.superRestart.open() }, "Restart…");
      this.note = el("div", { class: "s-say h-2 h-t14", role: "status" });
      const head = ["Node", "Life cycle", "Hz", "CPU %", "Heard", "Restarts"].map((word, i) => el("th", { scope: "col", class: i > 1 ? "num" : null }, word));
      this.body = el("tbody");
      this.table = el("table", { class: "s-nodetable" }, el("thead", {}, el("tr", {}, ...head)), this.body);
      this.rows = new Map();
      this.append(el("div", { class: "s-head" }, el("b", {}, "Nodes"), this.sum, el("span", { class: "h-sp" }), this.logs, this.restart), this.note, el("div", { class: "s-scroll" }, this.table));
    }
    paint() {
      const nodes = all();
      const said = notice(HL.port.inside(HL.view.robot).nodes ?? (HL.port.inside(HL.view.robot).nodes === undefined ? undefined : null));
      text(this.note, said === "empty" ? `${HL.view.name()} tells nothing of its nodes.` : said);
      attr(this.note, "hidden", !said);
      attr(this.table, "hidden", !nodes?.length);
      toggle(this, "stale", Boolean(said) && Boolean(nodes));
      text(this.sum, nodes ? summary(nodes) : "");
      const off = HL.superRestart.refusal() || (nodes?.length ? "" : "No node is known yet.");
      attr(this.restart, "aria-disabled", off ? "true" : null);
      attr(this.restart, "title", off || null);
      this.keep(nodes ?? []);
      for (const node of nodes ?? []) paintRow(this.rows.get(node.name), node);
    }
    keep(nodes) {
      const names = nodes.map((one) => one.name);
      if (names.join() === this.names) return;
      this.names = names.join();
      for (const name of names) if (!this.rows.has(name)) this.rows.set(name, row(name));
      this.body.replaceChildren(...names.map((name) => this.rows.get(name).node));
    }
  }

  function summary(nodes) {
    const counts = {};
    for (const node of nodes) counts[node.state] = (counts[node.state] ?? 0) + 1;
    return Object.entries(COUNTED).filter(([state]) => counts[state]).map(([state, word]) => `${counts[state]} ${word}`).join(", ");
  }

  function row(name) {
    const sign = el("span", { class: "sign" });
    const label = el("span", { class: "h-ell" });
    const life = el("span", { class: "life" });
    const word = el("span");
    const cells = { rate: el("td", { class: "num" }), cpu: el("td", { class: "num" }), age: el("td", { class: "num age" }), restarts: el("td", { class: "num" }) };
    const finding = el("div", { class: "finding h-t12 h-2" });
    const node = el("tr", { "data-testid": `node-${name}`, tabindex: 0, role: "button", onclick: () => open(name), onkeydown: (event) => (event.key === "Enter" || event.key === " ") && (event.preventDefault(), open(name)) },
      el("th", { scope: "row" }, el("span", { class: "name" }, sign, label), finding), el("td", {}, el("span", { class: "name" }, life, word)), cells.rate, cells.cpu, cells.age, cells.restarts);
    return { node, sign, label, life, word, finding, ...cells };
  }

  function paintRow(row, node) {
    const { ageMs, state } = heard(node);
    attr(row.node, "data-state", node.state);
    attr(row.node, "data-level", node.level);
    attr(row.node, "data-age-ms", Number.isFinite(ageMs) ? Math.round(ageMs) : null);
    attr(row.node, "data-fresh", state);
    attr(row.node, "aria-label", `${node.label}, ${lifeWord(node)}${node.finding ? `. ${node.finding}` : ""}`);
    if (row.drawn !== `${node.state}|${node.level}`) {
      row.drawn = `${node.state}|${node.level}`;
      row.sign.replaceChildren(...(node.level ? [alarm(node.level, 20)] : []));
      row.life.replaceChildren(glyph(node.state));
    }
    text(row.label, node.label);
    text(row.word, lifeWord(node));
    text(row.rate, rate(node.rate_hz));
    text(row.cpu, number(node.cpu_pct));
    text(row.age, state === "missing" ? "never" : words.age(ageMs));
    text(row.restarts, number(node.restarts));
    text(row.finding, node.finding);
    attr(row.finding, "hidden", !node.finding);
  }

  function open(name) {
    const node = find(name);
    if (!node) return;
    HL.sheet({
      title: node.label, hook: "node-sheet",
      body: [el("hl-super-node", { "data-node": name })],
      buttons: [["Log", () => HL.superLogs.open(name)], ["Close", (close) => close(), true]],
    });
  }

  HL.superDefine("hl-super-nodes", Nodes);
  Object.assign(HL, { superNodes: { glyph, heard, lifeWord, rate, number, find, all, notice, open } });
})();
