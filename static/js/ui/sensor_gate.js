// The line on top: may treatment go on, and why not; below it what is wrong with the weather or the answer itself.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, LiveElement } = HL;
  const R = HL.sensorRules;
  const SIGNS = { open: "check", waits: "pause", unknown: "help" };

  class Gate extends LiveElement {
    build() {
      this.sign = icon("help", "l");
      this.head = el("b", { class: "h-t18 h-b h-nw" });
      this.line = el("span", { class: "h-t16 sn-gateline" });
      this.facts = el("span", { class: "sn-facts" });
      this.strip = el("div", { class: "sn-strip", role: "alert", "data-testid": "sensors-strip", hidden: true }, alarm(3, 22), (this.stripWords = el("span", {})), el("span", { class: "h-sp" }), (this.again = el("button", { type: "button", class: "h-btn", onclick: () => HL.sensors.load() }, icon("refresh", "m"), "Try again")));
      this.row = el("div", { class: "sn-gate", role: "status", "data-testid": "sensors-gate" }, this.sign, this.head, this.line, el("span", { class: "h-sp" }), this.facts);
      this.append(this.row, this.strip);
    }

    paint() {
      const { found, problem } = HL.sensors;
      const hasStations = Boolean(found?.stations?.length);
      attr(this, "hidden", !hasStations);
      if (!hasStations) return;
      const passed = HL.sensors.passedS();
      const gate = R.gateNow(found.gate, passed, HL.sensors.askedAt());
      attr(this.row, "data-state", gate.state);
      text(this.sign, SIGNS[gate.state] ?? "help");
      text(this.head, `Treatment: ${gate.state}`);
      text(this.line, HL.sensorUnits.sentence(gate.sentence).replace(/: waits$/, "")); // the head says it
      this.paintFacts(gate.facts ?? []);
      const isOld = Boolean(problem) || passed > R.ANSWER_OLD_S;
      const weather = R.weatherProblem(HL.sensors.stations(), HL.words.day);
      const words = isOld ? `Values are from ${HL.sensors.askedAt()}. ${problem?.text || "The server does not answer."}` : weather ?? "";
      attr(this.strip, "hidden", !words);
      text(this.stripWords, words);
      attr(this.again, "hidden", !isOld);
    }

    paintFacts(facts) {
      const key = JSON.stringify(facts) + HL.preferences.get("speed") + HL.preferences.get("temperature");
      if (key === this.drawn) return;
      this.drawn = key;
      this.facts.replaceChildren(...facts.map(({ label, text: words, ok }) => el("span", { class: "sn-fact", "data-ok": ok === true ? "yes" : ok === false ? "no" : "unknown" }, icon(ok === true ? "check" : ok === false ? "pause" : "help", "s"), el("span", {}, el("b", {}, label), " ", HL.sensorUnits.sentence(words)))));
    }
  }

  HL.SensorGate = Gate;
})();
