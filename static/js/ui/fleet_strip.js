// Over the map: figures of the fleet now and today, and what became of STOP at each robot.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement } = HL;
  const OLD_MS = 30000; // today's sums come every ten seconds

  class Figure {
    constructor(key, label) {
      this.value = el("b", {});
      this.unit = el("small");
      this.node = el("div", { class: "f-kpi", "data-testid": `fleet-kpi-${key}`, "data-kpi": key }, el("span", { class: "h-h" }, label), el("span", { class: "v" }, this.value, this.unit));
    }
    show(value, unit = "", raw = null) {
      text(this.value, value);
      text(this.unit, unit);
      attr(this.node, "data-value", raw);
    }
  }

  const KPIS = [["working", "Working"], ["area", "Area today"], ["plants", "Trees today"], ["utilisation", "Utilisation"], ["interventions", "Interventions"], ["slowest", "Slowest link"], ["oldest", "Oldest value"]];

  class FleetKpis extends LiveElement {
    build() {
      this.figures = Object.fromEntries(KPIS.map(([key, label]) => [key, new Figure(key, label)]));
      this.more = el("button", { type: "button", class: "h-btn q ico f-kpimore", "data-testid": "fleet-kpi-more", onclick: () => this.unfold(!this.isOpen) }, icon("chevron_right", "m"));
      this.append(...Object.values(this.figures).map((one) => one.node), this.more);
      this.unfold(false);
    }
    // on a tablet the map has the room until somebody asks for every figure
    unfold(isOpen) {
      this.isOpen = isOpen;
      toggle(this, "all", isOpen);
      attr(this.more, "aria-expanded", String(isOpen));
      attr(this.more, "aria-label", isOpen ? "Fewer figures" : "All figures");
      text(this.more.firstChild, isOpen ? "keyboard_arrow_down" : "chevron_right");
    }
    paint() {
      if (this.looked === HL.fleet.looks && this.day === HL.fleet.day) return;
      [this.looked, this.day] = [HL.fleet.looks, HL.fleet.day];
      const now = HL.fleetOrder.figures(HL.fleet.items);
      const { figures: f } = this;
      f.working.show(now.working, `of ${now.total}`, now.working);
      f.slowest.show(now.slowestMs === null ? "–" : Math.round(now.slowestMs), now.slowestMs === null ? "" : "ms", now.slowestMs);
      f.oldest.show(now.oldestMs === null ? "–" : HL.words.age(now.oldestMs), "", now.oldestMs);
      this.today(now);
    }
    // sums that did not arrive lately are not shown as if they had
    today(now) {
      const { day } = HL.fleet;
      const isOld = !day || performance.now() - day.at > OLD_MS;
      const { figures: f } = this;
      const area = isOld ? { text: "–", unit: "" } : HL.units.area(day.area_m2);
      f.area.show(area.text, area.unit, isOld ? null : day.area_m2);
      attr(f.plants.node, "hidden", !now.planters);
      f.plants.show(isOld ? "–" : day.plants, "", isOld ? null : day.plants);
      const share = isOld ? null : day.utilisation;
      f.utilisation.show(share === null ? "–" : Math.round(share * 100), share === null ? "" : "%", share);
      const rate = isOld ? null : day.interventions_per_hour;
      f.interventions.show(isOld ? "–" : rate === null ? day.interventions : rate.toFixed(1), isOld ? "" : rate === null ? "today" : "per robot hour", isOld ? null : day.interventions);
    }
  }

  const list = (names) => (names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);

  // counts that are honest: who stands, who did not confirm, who was not reached
  class FleetStop extends LiveElement {
    build() {
      this.head = el("b", { class: "h-t18" });
      this.lines = el("div", { class: "h-col" });
      this.append(el("div", { class: "h-row" }, icon("front_hand", "f"), this.head), this.lines);
    }
    paint() {
      const state = HL.fleet.stop;
      if (this.seen?.[0] === state && this.seen[1] === HL.fleet.freeze) return;
      this.seen = [state, HL.fleet.freeze];
      const pressed = new Set((state?.steps ?? []).map((step) => step.robot));
      const robots = (state?.robots ?? []).filter((one) => pressed.has(one.id));
      const isFrozen = Boolean(HL.fleet.freeze);
      attr(this, "hidden", !robots.length && !isFrozen);
      if (!robots.length && !isFrozen) return;
      const standing = robots.filter((one) => one.is_standing);
      const silent = robots.filter((one) => one.state === "standstill" && one.is_linked && !one.is_standing);
      const offline = robots.filter((one) => !one.is_linked);
      const failing = robots.filter((one) => one.state === "not-confirmed" && one.is_linked);
      const waiting = robots.filter((one) => ["sent", "acknowledged"].includes(one.state) && one.is_linked);
      attr(this, "data-state", failing.length || offline.length || silent.length ? "not-confirmed" : waiting.length ? "sent" : robots.length ? "standstill" : "frozen");
      attr(this, "data-standing", standing.length);
      attr(this, "data-total", robots.length);
      text(this.head, robots.length ? `${standing.length} of ${robots.length} standing` : "Queue is frozen");
      const lines = [
        failing.length ? `NOT CONFIRMED: ${list(failing.map((one) => one.name))}. Use the button on the machine.` : "",
        offline.length ? `No link: ${list(offline.map((one) => one.name))}. Not counted as stopped; the stop goes first when ${offline.length === 1 ? "it returns" : "they return"}.` : "",
        silent.length ? `Safety controller silent: ${list(silent.map((one) => one.name))}. Not counted as standing; look before you walk up.` : "",
        waiting.length ? `Waiting for ${list(waiting.map((one) => one.name))}.` : "",
        isFrozen ? "The mission queue is frozen until somebody releases it under Missions, Queue." : "",
      ].filter(Boolean);
      const key = lines.join("|");
      if (key === this.key) return;
      this.key = key;
      this.lines.replaceChildren(...lines.map((line) => el("span", { class: "h-t14" }, line)));
    }
  }

  Object.assign(HL, { FleetKpis, FleetStop });
})();
