// One robot in the list: a row when it needs somebody, a cell when it does not. Made once, written when it differs.
(() => {
  "use strict";
  const { el, alarm, robotGlyph, text, attr, style, toggle } = HL;

  const waited = (since) => (typeof since === "number" ? HL.words.clock(HL.port.age(since) / 1000) : "");
  const percent = (soc) => (typeof soc === "number" ? `${Math.round(soc * 100)} %` : "–");

  class Part {
    constructor(id, className) {
      this.id = id;
      this.box = el("input", { type: "checkbox", "data-testid": `fleet-pick-${id}`, onchange: () => HL.fleet.choose(id, this.box.checked) });
      this.glyph = el("span", { class: "glyph" });
      this.name = el("span", { class: "name h-ell" });
      this.node = el("div", { class: className, "data-testid": `fleet-row-${id}`, role: "listitem", onclick: (event) => this.tapped(event), ondblclick: () => HL.go(`/operate/${id}`) });
    }
    tapped(event) {
      if (event.target.closest("button, a, label, input")) return;
      HL.fleet.setCurrent(this.id);
      HL.fleetMap.show(this.id);
    }
    common(one) {
      const { robot, verdict } = one;
      if (this.family !== robot.family) {
        this.family = robot.family;
        this.glyph.replaceChildren(robotGlyph(robot.family, this.size));
      }
      const isChosen = HL.fleet.chosen.has(this.id);
      if (this.box.checked !== isChosen) this.box.checked = isChosen;
      attr(this.box, "aria-label", `Choose ${robot.name}`);
      attr(this.node, "data-level", verdict.level);
      attr(this.node, "data-state", robot.mode ?? "unknown");
      attr(this.node, "data-age-ms", Number.isFinite(one.ageMs) ? Math.round(HL.port.age(robot.t)) : null);
      attr(this.node, "aria-current", HL.fleet.current === this.id ? "true" : null);
      toggle(this.node, "chosen", isChosen);
      toggle(this.node, "lost", Boolean(verdict.isLost));
      text(this.name, robot.name);
    }
  }

  class Row extends Part {
    constructor(id) {
      super(id, "f-row");
      this.size = 28;
      this.sign = el("span", { class: "sign" });
      this.head = el("span", { class: "head" });
      this.line = el("span", { class: "line" });
      this.wait = el("b");
      this.waiting = el("span", { class: "wait" }, this.wait, el("small", {}, "waiting"));
      this.link = el("span", { class: "link" });
      this.charge = el("i");
      this.cell = el("span", { class: "h-cell" }, this.charge);
      this.soc = el("span");
      this.more = el("button", { type: "button", class: "h-btn q ico more", "data-testid": `fleet-menu-${id}`, "aria-haspopup": "dialog", onclick: () => HL.fleetMenu(id) }, "⋯");
      this.node.append(el("label", { class: "pick" }, this.box), this.sign, this.glyph, this.name, el("span", { class: "state" }, this.head, this.line), this.waiting,
        el("span", { class: "fig" }, this.link, el("span", { class: "soc" }, this.cell, this.soc)), el("a", { class: "h-btn go", href: `/operate/${id}`, "data-testid": `fleet-open-${id}` }, "Open"), this.more);
    }
    paint(one) {
      const { robot, verdict } = one;
      this.common(one);
      const key = `${verdict.level}/${verdict.look}`;
      if (key !== this.drawn) {
        this.drawn = key;
        this.sign.replaceChildren(verdict.level ? alarm(verdict.level, 26, verdict.look) : "");
      }
      text(this.head, verdict.head);
      text(this.line, verdict.line);
      attr(this.node, "title", [verdict.head, verdict.line].filter(Boolean).join(". "));
      const asks = verdict.group === "needs-you" && (verdict.waits || !verdict.isLost) && typeof verdict.since === "number";
      attr(this.waiting, "hidden", !asks);
      if (asks) text(this.wait, waited(verdict.since));
      text(this.link, verdict.isLost ? "no link" : typeof robot.rtt_ms === "number" ? `${Math.round(robot.rtt_ms)} ms` : "–");
      text(this.soc, percent(robot.soc));
      toggle(this.cell, "low", typeof robot.soc === "number" && robot.soc < 0.25);
      style(this.charge, "width", `${typeof robot.soc === "number" ? Math.round(robot.soc * 100) : 0}%`); // the browser rounds what it gives back
      attr(this.more, "aria-label", `More for ${robot.name}`);
    }
  }

  class Cell extends Part {
    constructor(id) {
      super(id, "f-cell");
      this.size = 20;
      this.what = el("span", { class: "what h-ell" });
      this.more = el("button", { type: "button", class: "h-btn q ico more", "data-testid": `fleet-menu-${id}`, "aria-haspopup": "dialog", onclick: () => HL.fleetMenu(id) }, "⋯");
      this.node.append(el("label", { class: "pick" }, this.box, this.glyph), el("span", { class: "h-col" }, this.name, this.what), this.more);
    }
    paint(one) {
      this.common(one);
      text(this.what, one.verdict.head);
      attr(this.node, "title", [one.robot.name, one.verdict.head, one.verdict.line].filter(Boolean).join(". "));
      attr(this.more, "aria-label", `More for ${one.robot.name}`);
    }
  }

  // an alarm of the console or a station: nothing to choose, it opens the list of alarms
  class Notice {
    constructor(id) {
      this.sign = el("span", { class: "sign" });
      this.name = el("span", { class: "name h-ell" });
      this.head = el("span", { class: "head" });
      this.line = el("span", { class: "line" });
      this.wait = el("b");
      this.waiting = el("span", { class: "wait" }, this.wait, el("small", {}, "waiting"));
      this.node = el("div", { class: "f-row", "data-testid": `fleet-notice-${id}`, role: "listitem", onclick: (event) => event.target.closest("a") || HL.go("/alarms") }, this.sign, this.name,
        el("span", { class: "state" }, this.head, this.line), this.waiting, el("a", { class: "h-btn go", href: "/alarms" }, "Open"));
    }
    paint({ robot, verdict }) {
      const key = `${verdict.level}/${verdict.look}`;
      if (key !== this.drawn) this.sign.replaceChildren(alarm(verdict.level, 26, verdict.look));
      this.drawn = key;
      attr(this.node, "data-level", verdict.level);
      attr(this.node, "title", [verdict.head, verdict.line].filter(Boolean).join(". "));
      text(this.name, robot.name);
      text(this.head, verdict.head);
      text(this.line, verdict.line);
      text(this.wait, waited(verdict.since));
    }
  }

  HL.fleetRows = { Row, Cell, Notice };
})();
