// Every robot in three groups: needs you, watch, normal. A list that says what it knows and how old that is.
(() => {
  "use strict";
  const { el, icon, alarm, robotGlyph, text, attr, style, LiveElement, define, words } = HL;

  const GROUPS = [["needs-you", "Needs you"], ["watch", "Watch"], ["normal", "Normal"]];

  function judge(id, robot) {
    const stop = HL.stops.worst(id);
    if (stop?.state === "not-confirmed") return { level: 1, head: "Stop not confirmed", line: "Use the red button on the machine." };
    const silentMs = robot.t === null || robot.t === undefined ? Infinity : HL.port.age(robot.t);
    if (robot.is_registered === false) return { level: 4, head: "New", line: "An admin must accept it before it can be operated." };
    if (robot.is_online === false || silentMs > HL.LOST_MS) return { level: 2, head: Number.isFinite(silentMs) ? `No link for ${words.since(silentMs)}` : "Never heard", line: Number.isFinite(silentMs) ? "Its values are old. Look at its power and radio." : "Not heard since the server started." };
    return { level: robot.level ?? null, head: robot.text || "–", line: wording(robot.why) };
  }

  const wording = (why) => (why ? (typeof why === "string" ? why : why.text) : "");
  const groupOf = (level) => (level === 1 || level === 2 ? "needs-you" : level === 3 || level === 4 ? "watch" : "normal");

  class Row {
    constructor(id) {
      this.sign = el("span");
      this.glyph = el("span", { class: "glyph" });
      this.name = el("span", { class: "name h-ell" });
      this.head = el("span");
      this.line = el("small");
      this.link = el("span", { class: "fig" });
      this.charge = el("i");
      this.soc = el("span");
      this.battery = el("span", { class: "fig" }, el("span", { class: "h-cell" }, this.charge), this.soc);
      this.node = el("div", { class: "h-frow", "data-testid": `fleet-row-${id}` }, this.sign, this.glyph, this.name, el("span", { class: "state" }, this.head, this.line), this.link, this.battery,
        el("a", { class: "h-btn go", href: `/operate/${id}`, "data-testid": `fleet-open-${id}` }, "Open"));
    }
    paint(robot, verdict) {
      const key = `${verdict.level}/${robot.family}`;
      if (key !== this.drawn) {
        this.drawn = key;
        this.sign.replaceChildren(verdict.level ? alarm(verdict.level, 28) : "");
        this.glyph.replaceChildren(robotGlyph(robot.family, 30));
      }
      attr(this.node, "data-level", verdict.level);
      attr(this.node, "data-state", robot.mode ?? "unknown");
      attr(this.node, "data-age-ms", robot.t === null || robot.t === undefined ? null : Math.round(HL.port.age(robot.t)));
      text(this.name, robot.name);
      text(this.head, verdict.head);
      text(this.line, verdict.line);
      text(this.link, robot.is_online === false ? "no link" : robot.rtt_ms === null || robot.rtt_ms === undefined ? "–" : `${Math.round(robot.rtt_ms)} ms`);
      const hasSoc = typeof robot.soc === "number";
      text(this.soc, hasSoc ? `${Math.round(robot.soc * 100)} %` : "–");
      style(this.charge, "width", `${hasSoc ? robot.soc * 100 : 0}%`);
    }
  }

  class Fleet extends LiveElement {
    build() {
      this.rows = new Map();
      this.groups = Object.fromEntries(GROUPS.map(([name, label]) => {
        const count = el("span");
        const list = el("div");
        const node = el("section", { "data-testid": `fleet-group-${name}`, hidden: true }, el("h2", {}, label, count), list);
        return [name, { node, count, list }];
      }));
      this.note = el("div", { class: "h-notice h-card" });
      this.append(...Object.values(this.groups).map((group) => group.node), this.note);
      this.from = performance.now();
    }
    paint() {
      const robots = Object.entries(HL.port.fleet()).map(([id, robot]) => [id, robot, judge(id, robot)]);
      robots.sort((a, b) => (a[2].level ?? 9) - (b[2].level ?? 9) || a[1].name.localeCompare(b[1].name));
      const wanted = { "needs-you": [], watch: [], normal: [] };
      for (const [id, robot, verdict] of robots) {
        if (!this.rows.has(id)) this.rows.set(id, new Row(id));
        this.rows.get(id).paint(robot, verdict);
        wanted[groupOf(verdict.level)].push(this.rows.get(id).node);
      }
      for (const [name, nodes] of Object.entries(wanted)) this.place(this.groups[name], nodes);
      for (const id of [...this.rows.keys()]) if (!HL.port.fleet()[id]) this.rows.delete(id);
      this.say(robots.length);
    }
    // rows change place only while no pointer is over the list: a row must not slip away under a finger
    place(group, nodes) {
      attr(group.node, "hidden", !nodes.length);
      text(group.count, nodes.length);
      const isSame = nodes.length === group.list.children.length && nodes.every((node, i) => node === group.list.children[i]);
      if (!isSame && !(group.list.matches(":hover") && nodes.length === group.list.children.length)) group.list.replaceChildren(...nodes);
    }
    say(count) {
      attr(this.note, "hidden", count > 0);
      if (count) return;
      const isKnown = HL.port.server().isKnown;
      const key = isKnown ? "none" : performance.now() - this.from > 5000 ? "lost" : "loading";
      if (key === this.said) return;
      this.said = key;
      const [sign, head, line] = { none: ["smart_toy", "No robots yet", "Robots that are heard appear here; an admin accepts them."], lost: ["cloud_off", "List did not load", "Server did not answer in 5 s. STOP still works."], loading: ["hourglass_top", "Loading fleet", ""] }[key];
      this.note.replaceChildren(icon(sign, "l"), el("b", { class: "h-t18 h-b" }, head), el("span", { class: "h-2" }, line), key === "loading" ? el("div", { class: "h-skeleton" }, ...[220, 180, 200].map((w) => { const bar = el("i"); bar.style.width = `${w}px`; return bar; })) : "");
    }
  }

  define("hl-fleet", Fleet);
})();
