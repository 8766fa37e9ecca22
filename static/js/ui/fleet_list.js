// Every robot in three sections: needs you, watch, normal. The list says what it knows and how old that is.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement, words } = HL;
  const { Row, Cell, Notice } = HL.fleetRows;
  const HELD_MS = 3000; // after a touch rows hold still this long: there is no hover to tell
  const LATE_MS = 5000;
  const WIDE_PX = 600;
  const HEIGHTS = { head: 40, fold: 56, "needs-you": [100, 66], row: [76, 56], cells: 56 };
  const LARGER = 1.125; // type in the sun
  const GAP = 4;

  class Head {
    constructor(line) {
      this.title = el("span");
      this.count = el("span", { class: "count" });
      this.note = el("span", { class: "note h-ell" });
      this.node = el("div", { class: "f-head", role: "listitem" }, el("h2", {}, this.title, " ", this.count), this.note);
      if (line.hook) attr(this.node, "data-testid", line.hook);
    }
    paint(line) {
      text(this.title, line.title);
      text(this.count, line.count);
      text(this.note, line.note || "");
    }
  }

  class Fold {
    constructor(line) {
      this.sign = el("span", { class: "sign" });
      this.title = el("b", { class: "h-ell" });
      this.count = el("span", { class: "h-2" });
      this.arrow = icon("keyboard_arrow_down");
      this.node = el("button", { type: "button", class: "f-fold", "data-testid": `fleet-fold-${line.section}`, onclick: () => this.turn() }, this.arrow, this.title, this.count);
    }
    turn() {
      const { open } = HL.fleet;
      if (!open.delete(this.section)) open.add(this.section);
      HL.fleet.look();
    }
    paint(line) {
      this.section = line.section;
      attr(this.node, "aria-expanded", String(!line.folded));
      text(this.arrow, line.folded ? "chevron_right" : "keyboard_arrow_down");
      text(this.title, line.title);
      text(this.count, line.count === 1 ? "1 robot" : `${line.count} robots`);
    }
  }

  class Cells {
    constructor() {
      this.cells = new Map();
      this.node = el("div", { class: "f-cells" });
    }
    paint(line) {
      const kept = line.items.map((one) => {
        if (!this.cells.has(one.id)) this.cells.set(one.id, new Cell(one.id));
        const cell = this.cells.get(one.id);
        cell.paint(one);
        return cell.node;
      });
      const isSame = kept.length === this.node.children.length && kept.every((node, i) => node === this.node.children[i]);
      if (isSame) return;
      this.node.replaceChildren(...kept);
      this.node.style.setProperty("--columns", line.columns);
      const ids = new Set(line.items.map((one) => one.id));
      for (const id of [...this.cells.keys()]) if (!ids.has(id)) this.cells.delete(id);
    }
  }

  class RowLine {
    constructor(line) {
      this.row = line.item.isNotice ? new Notice(line.item.id) : new Row(line.item.id);
      this.node = this.row.node;
    }
    paint(line) {
      toggle(this.node, "tall", line.isTall);
      this.row.paint(line.item);
    }
  }

  const MAKE = { head: (line) => new Head(line), fold: (line) => new Fold(line), cells: () => new Cells(), row: (line) => new RowLine(line) };

  class FleetList extends LiveElement {
    build() {
      this.note = el("div", { class: "f-note", hidden: true });
      this.offers = el("div", { class: "f-offers" });
      this.place = el("div", { class: "f-list", role: "list", "aria-label": "Robots", "data-testid": "fleet-list", tabindex: "-1" });
      this.blank = el("div", { class: "h-notice h-card f-blank", hidden: true });
      this.said = el("div", { class: "h-vh", role: "status", "aria-live": "polite" });
      this.find = new HL.FleetFilter();
      this.append(this.find.node, this.offers, this.note, this.place, this.blank, this.said);
      this.scroll = new HL.FleetScroll(this.place, (line) => MAKE[line.kind](line), () => (this.onLook?.(), HL.repaint()));
      this.place.addEventListener("pointerdown", () => (this.touchedAt = performance.now()));
      this.held = [];
      this.from = performance.now();
    }
    enter() {
      this.onLook = () => ((this.isDue = true), this.find.paint(), this.offered?.paint());
      HL.fleet.listeners.add(this.onLook);
      HL.fleet.begin();
      this.isDue = true;
    }
    leave() {
      HL.fleet.listeners.delete(this.onLook);
      HL.fleet.end();
    }
    isHeld() {
      return this.place.matches(":hover") || performance.now() - (this.touchedAt ?? -Infinity) < HELD_MS;
    }
    paint() {
      this.warn();
      if (!this.isDue) return;
      this.isDue = false;
      const { filter, groups, open, order } = HL.fleet;
      const key = JSON.stringify([filter, [...open]]);
      const isHeld = Boolean(this.isHeld() && key === this.key && this.held.length);
      const isAnyWay = HL.fleet.isNarrowed(filter) || filter.sort === "group"; // what they go by is not counted
      const made = [key, order, this.scroll.width, isInSun(), isAnyWay && HL.fleet.looks].join("|");
      if (made === this.made && groups === this.groups && (isHeld || !this.wasHeld)) return this.refresh();
      [this.made, this.groups, this.wasHeld] = [made, groups, isHeld];
      const items = HL.fleet.visible();
      this.isNarrow = !items.length && HL.fleet.isNarrowed(HL.fleet.filter);
      const now = HL.fleetOrder.sections(items, { sort: filter.sort, groups, open, notices: HL.fleet.notices });
      const { sections, moved } = isHeld ? HL.fleetOrder.hold(this.held, now) : { sections: now, moved: 0 };
      this.key = key;
      this.held = sections;
      this.moved = moved;
      this.scroll.set(this.lines(sections));
      this.say(items.length);
      this.announce(now);
    }
    // the same robots in the same places: only what is in sight is written again
    refresh() {
      for (const line of this.scroll.lines) if (line.from) line.note = this.noteOf(line.from);
      this.scroll.draw();
      this.say(this.shownCount);
    }
    lines(sections) {
      const { width } = this.scroll;
      const isWide = width >= WIDE_PX;
      toggle(this.place, "wide", isWide);
      const columns = width >= WIDE_PX ? 3 : width >= 300 ? 2 : 1;
      const lines = [];
      for (const section of sections) {
        const count = section.count ?? section.items.length;
        if (!count && (section.key !== "needs-you" || this.isNarrow)) continue;
        lines.push(section.canFold ? { key: `fold ${section.key}`, kind: "fold", section: section.key, height: HEIGHTS.fold, gap: GAP, title: section.title, count, folded: section.folded }
          : { key: `head ${section.key}`, kind: "head", height: HEIGHTS.head, title: section.title, count, note: this.noteOf(section), from: section, hook: `fleet-group-${section.key}` });
        if (section.kind === "cells") this.addCells(lines, section, columns);
        else for (const item of section.items) lines.push(rowLine(section, item, isWide));
      }
      this.ids = sections.flatMap((section) => section.items.filter((one) => !one.isNotice).map((one) => one.id));
      return lines;
    }
    addCells(lines, section, columns) {
      for (let i = 0; i < section.items.length; i += columns) {
        const items = section.items.slice(i, i + columns);
        lines.push({ key: `cells ${section.key} ${i}`, kind: "cells", height: HEIGHTS.cells, gap: GAP, items, columns, keys: items.map((one) => one.id) });
      }
    }
    noteOf(section) {
      if (section.key === "needs-you") return this.moved ? "order waits while you point at it" : section.items.length > 1 ? "by priority, then time until help is needed" : section.items.length ? "" : this.isUnsure ? "not known" : "Nobody";
      if (section.key !== "normal") return "";
      const { newestMs, oldestMs } = HL.fleetOrder.figures(HL.fleet.items);
      return newestMs === null ? "" : `newest data ${words.age(newestMs)}, oldest ${words.age(oldestMs)}`;
    }
    // an old list says so, and since when
    warn() {
      const { silentMs, isKnown } = HL.port.server();
      const isOld = isKnown && silentMs > HL.LOST_MS;
      const total = HL.fleet.items.length;
      const shown = this.shownCount ?? total;
      const alarmsMs = HL.alarms.ageMs() ?? 0;
      const isBlind = !isOld && HL.alarms.isOld();
      this.isUnsure = isOld || isBlind;
      const isPart = !isOld && !isBlind && HL.fleet.isNarrowed(HL.fleet.filter) && shown < total;
      const isNew = !isOld && !isBlind && !isPart && performance.now() - this.from < LATE_MS;
      const loaded = isNew ? HL.fleet.items.filter((one) => Number.isFinite(one.ageMs)).length : total;
      const isLoading = loaded < total;
      const key = isOld ? `old ${Math.floor(silentMs / 60000)}` : isBlind ? `blind ${Math.floor(alarmsMs / 1000)}` : isPart ? `part ${shown} ${total} ${shown ? "" : HL.fleet.filter.q}` : isLoading ? `load ${loaded} ${total}` : "";
      toggle(this, "old", isOld);
      attr(this.note, "hidden", !key);
      if (key === this.noted) return;
      this.noted = key;
      const again = (label, act) => el("button", { type: "button", class: "h-btn", "data-testid": "fleet-note-act", onclick: act }, label);
      if (isOld) this.note.replaceChildren(icon("cloud_off", "m"), el("span", {}, `List is from ${words.wall(new Date(Date.now() - silentMs))}.`), again("Try again", () => window.dispatchEvent(new Event("online"))));
      else if (isBlind) this.note.replaceChildren(icon("warning", "m"), el("span", {}, `Alarms are ${words.since(alarmsMs)} old. Do not rely on them.`));
      else if (isPart) this.note.replaceChildren(el("span", {}, shown ? `You see ${shown} of ${total} robots.` : HL.fleet.filter.q ? `No robot, mission or field is called “${HL.fleet.filter.q}”.` : "No robot fits these filters."), again("Show all", () => HL.fleet.setFilter({ ...HL.fleet.NO_FILTER, sort: HL.fleet.filter.sort })));
      else if (isLoading) this.note.replaceChildren(icon("hourglass_top", "m"), el("span", {}, `${total} robots, ${loaded} loaded`));
    }
    say(count) {
      this.shownCount = count;
      const total = HL.fleet.items.length;
      attr(this.blank, "hidden", total > 0);
      attr(this.place, "hidden", !total && !HL.fleet.notices.length);
      if (total) return;
      const isKnown = HL.port.server().isKnown && Boolean(window.headland.state("fleet"));
      const key = isKnown ? "none" : performance.now() - this.from > LATE_MS ? "lost" : "loading";
      if (key === this.blankKey) return;
      this.blankKey = key;
      const [sign, head, line] = { none: ["smart_toy", "No robots yet", "Robots that are heard appear here; an admin accepts them."], lost: ["cloud_off", "List did not load", "Server did not answer in 5 s. STOP still works."], loading: ["hourglass_top", "Loading fleet", ""] }[key];
      const add = key === "none" && HL.fleet.can("manage_robots") ? el("a", { class: "h-btn", href: "/admin" }, "Add a robot") : "";
      this.blank.replaceChildren(icon(sign, "l"), el("b", { class: "h-t18 h-b" }, head), el("span", { class: "h-2" }, line), add, key === "loading" ? el("div", { class: "h-skeleton" }, ...[220, 180, 200].map((w) => { const bar = el("i"); bar.style.width = `${w}px`; return bar; })) : "");
    }
    // who newly needs somebody is spoken once
    announce(sections) {
      const needs = sections.find((section) => section.key === "needs-you")?.items ?? [];
      const fresh = this.known ? needs.filter((one) => !this.known.has(one.id)) : [];
      this.known = new Set(needs.map((one) => one.id));
      if (fresh.length) text(this.said, fresh.slice(0, 3).map((one) => `${one.robot.name}: ${one.verdict.head}`).join(". "));
    }
    // keys: next and previous in the order that is shown
    step(by) {
      const ids = this.ids ?? [];
      if (!ids.length) return;
      const at = ids.indexOf(HL.fleet.current);
      const next = ids[at < 0 ? (by > 0 ? 0 : ids.length - 1) : Math.min(ids.length - 1, Math.max(0, at + by))];
      this.place.focus({ preventScroll: true }); // Enter is the list's now, not that of a button left behind
      HL.fleet.setCurrent(next);
      this.scroll.reveal(`row ${next}`);
      this.scroll.reveal(next);
      HL.fleetMap.show(next);
      text(this.said, `${HL.fleet.name(next)}: ${HL.fleet.item(next)?.verdict.head ?? ""}`);
    }
  }

  const isInSun = () => document.documentElement.dataset.theme === "sunlight";

  function rowLine(section, item, isWide) {
    const [narrow, wide] = section.key === "needs-you" ? HEIGHTS["needs-you"] : HEIGHTS.row;
    return { key: `row ${item.id}`, kind: "row", height: Math.round((isWide ? wide : narrow) * (isInSun() ? LARGER : 1)), gap: GAP, item, isTall: section.key === "needs-you" };
  }

  HL.FleetList = FleetList;
})();
