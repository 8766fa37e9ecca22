// The stations: new ones to accept first, then each with its state, its battery and what a person has to know of it.
(() => {
  "use strict";
  const { el, icon, text, attr, words, LiveElement } = HL;
  const R = HL.sensorRules;
  const KIND_ORDER = Object.keys(R.KINDS);
  const NARROW = matchMedia("(max-width: 899.98px)");
  const NO_ACCEPT = "Planners accept new stations.";

  class Row {
    constructor(id) {
      this.sign = new HL.sensorGlyphs.StationSign(38);
      this.battery = new HL.sensorGlyphs.BatteryLine();
      this.name = el("b", { class: "h-t16 h-b h-ell" });
      this.where = el("span", { class: "h-t13 h-2 h-ell" });
      this.age = el("span");
      this.said = el("span", { class: "said" });
      this.notice = el("span", { class: "notice" });
      this.button = el("button", { type: "button", class: "sn-row", "data-testid": `sensor-${id}`, onclick: () => pick(id) },
        this.sign.node,
        el("span", { class: "sn-names" }, this.name, this.where),
        el("span", { class: "figures" }, el("span", { class: "h-age" }, icon("schedule", "s"), this.age), this.battery.node),
        this.said, this.notice);
      this.accept = el("button", { type: "button", class: "h-btn pri", "data-testid": `sensor-accept-${id}`, onclick: () => HL.sensorSheets.accept(HL.sensors.station(id)) }, "Accept");
      this.node = el("li", { class: "sn-item" }, this.button, this.accept);
    }

    paint(one, isChosen, mayAccept) {
      this.sign.paint(one.kind, one.state);
      attr(this.button, "data-state", one.state);
      attr(this.button, "data-age-ms", one.age === null ? null : Math.round(one.age * 1000));
      attr(this.button, "data-value", one.battery ?? "");
      attr(this.button, "aria-pressed", String(isChosen));
      HL.toggle(this.button, "late", one.state === "late");
      text(this.name, one.name || one.id);
      text(this.where, [R.KINDS[one.kind] ?? "Station", one.parcel_name || one.parcel || "no field"].join(" · "));
      text(this.age, one.age === null ? "never" : words.age(one.age * 1000));
      this.battery.paint(one);
      const said = R.sentence(one, words.since);
      text(this.said, said);
      attr(this.said, "hidden", !said);
      attr(this.said, "data-level", one.state === "silent" || one.battery_low ? 3 : null);
      const notice = R.noticeWords(one.notice);
      text(this.notice, notice);
      attr(this.notice, "hidden", !notice);
      attr(this.notice, "data-state", one.notice?.state ?? "none");
      attr(this.accept, "hidden", one.is_accepted);
      this.accept.disabled = !mayAccept;
      attr(this.accept, "title", mayAccept ? null : NO_ACCEPT);
    }
  }

  // where the values stand above the list they are brought into sight
  function pick(id) {
    HL.sensors.choose(HL.sensors.chosen === id ? null : id);
    if (HL.sensors.chosen && NARROW.matches) requestAnimationFrame(() => document.querySelector(".sn-values")?.scrollIntoView({ block: "start" }));
  }

  class List extends LiveElement {
    build() {
      this.rows = new Map();
      this.sum = el("span", { class: "h-t14 h-2", "data-testid": "sensors-summary", role: "status" });
      this.all = el("button", { type: "button", class: "h-btn", "data-testid": "sensors-all", onclick: () => HL.sensors.choose(null) }, "Show all");
      this.fresh = el("ul", { class: "sn-list" });
      this.freshHead = el("h2", { class: "sn-head" }, "New, not accepted yet");
      this.why = el("p", { class: "h-t13 h-2 sn-why" }, NO_ACCEPT);
      this.known = el("ul", { class: "sn-list" });
      this.append(el("div", { class: "sn-listhead" }, this.sum, el("span", { class: "h-sp" }), this.all), this.freshHead, this.why, this.fresh, this.known);
    }

    paint() {
      const { found, chosen } = HL.sensors;
      if (!found) return;
      const all = HL.sensors.stations().sort((a, b) => KIND_ORDER.indexOf(a.kind) - KIND_ORDER.indexOf(b.kind) || a.name.localeCompare(b.name, undefined, { numeric: true }));
      const fresh = all.filter((one) => !one.is_accepted);
      text(this.sum, R.summary(all));
      this.all.disabled = !chosen;
      this.arrange(this.fresh, fresh);
      this.arrange(this.known, all.filter((one) => one.is_accepted));
      const mayAccept = HL.sensors.may("accept");
      attr(this.freshHead, "hidden", !fresh.length);
      attr(this.why, "hidden", !fresh.length || mayAccept);
      for (const one of all) this.rows.get(one.id).paint(one, one.id === chosen, mayAccept);
      for (const id of [...this.rows.keys()]) if (!all.some((one) => one.id === id)) this.rows.delete(id);
    }

    // rows move only when stations come, go or are accepted
    arrange(place, stations) {
      const key = stations.map((one) => one.id).join();
      if (place.hlKey === key) return;
      place.hlKey = key;
      place.replaceChildren(...stations.map(({ id }) => {
        if (!this.rows.has(id)) this.rows.set(id, new Row(id));
        return this.rows.get(id).node;
      }));
    }
  }

  HL.SensorList = List;
})();
