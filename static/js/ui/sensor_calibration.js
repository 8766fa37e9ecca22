// Calibration of one value of a station: measured times gain plus offset, with a reason, and who set what before.
(() => {
  "use strict";
  const { el } = HL;
  const U = HL.sensorUnits;
  const USUAL = { offset: 0, gain: 1 };
  const REACH = [0.1, 10]; // a gain beyond this means a broken probe, not a wrong one

  class Calibration {
    constructor(station) {
      this.station = station;
      this.values = station.values.filter((one) => one.quantity !== "wind_bearing");
      this.form = new HL.SensorForm("calibration");
      this.pick = this.form.pick("key", "Value", this.values.map((one) => [one.key, one.label || one.key]), HL.sensors.shown?.station === station.id ? HL.sensors.shown.key : this.values[0]?.key);
      if (!this.pick.node.value) this.pick.node.value = this.values[0]?.key ?? "";
      this.offset = this.form.number("offset", "Offset", 0);
      this.gain = this.form.number("gain", "Gain", 1);
      this.note = this.form.input("note", "Why, and how it was measured", "", { maxlength: "200", placeholder: "Gravimetric sample, three cores" });
      this.now = el("p", { class: "h-t16", role: "status", "data-testid": "calibration-now" });
      this.history = el("div", { "data-testid": "calibration-history" });
      this.pick.node.addEventListener("change", () => this.fill());
      this.form.open({
        title: `Calibrate ${station.name}`,
        body: [el("p", { class: "h-t14 h-2" }, "Shown is measured × gain + offset, from the next value on. What was recorded stays as it was."), this.pick.label, this.now, el("div", { class: "sn-pairs" }, this.offset.label, this.gain.label), this.note.label, this.history],
        label: "Save calibration",
        save: () => this.order(),
      });
      this.fill();
      this.load();
    }

    value() {
      return this.values.find((one) => one.key === this.pick.node.value);
    }

    async load() {
      await HL.records.load(this.history, "History", `${HL.sensorSheets.path(this.station)}/calibration`, (answer) => {
        this.known = HL.records.list(answer, "calibrations");
        this.fill();
        return this.table();
      });
    }

    mine(value = this.value()) {
      return (this.known ?? []).filter((one) => one.quantity === value?.quantity && (one.depth_m ?? null) === (value?.depth_m ?? null));
    }

    // what holds now; what a person typed is never written over
    fill() {
      const value = this.value();
      if (!value) return;
      const holds = this.mine()[0] ?? USUAL;
      const isOther = this.filled !== `${value.key}|${Boolean(this.known)}`;
      const isTouched = this.filled?.startsWith(`${value.key}|`) && (this.offset.node.value !== this.before?.[0] || this.gain.node.value !== this.before?.[1]);
      if (isOther && !isTouched) [this.offset.node.value, this.gain.node.value] = this.before = [String(holds.offset), String(holds.gain)];
      this.filled = `${value.key}|${Boolean(this.known)}`;
      this.offset.label.firstChild.textContent = `Offset, ${value.unit || "no unit"}`;
      HL.text(this.now, `Now it shows ${U.isNumber(value.value) ? `${value.value} ${value.unit}` : "nothing"}, with gain ${holds.gain} and offset ${holds.offset}.`);
      if (this.known) this.history.replaceChildren(this.table());
    }

    table() {
      const rows = this.mine().map((one) => ({ cells: [HL.records.when(one.at), one.by || "–", String(one.offset), String(one.gain), one.note || "–"] }));
      return rows.length ? HL.records.table(["When", "Who", "Offset", "Gain", "Why"], rows) : el("p", { class: "h-t14 h-2" }, "It was never calibrated here.");
    }

    order() {
      const value = this.value();
      const found = this.form.numbers(["offset", "gain"], ["offset", "gain"]);
      if (!found) return null;
      if (found.gain < REACH[0] || found.gain > REACH[1]) return this.form.tell(`Gain is between ${REACH[0]} and ${REACH[1]}. Beyond that look at the probe.`, "gain");
      const note = this.note.node.value.trim();
      if (!note) return this.form.tell("Say why. It is kept with who and when.", "note");
      return { method: "PUT", path: `${HL.sensorSheets.path(this.station)}/calibration`, body: { quantity: value.quantity, depth_m: value.depth_m ?? null, ...found, note }, done: `${value.label || value.key} of ${this.station.name} is calibrated from its next value on.` };
    }
  }

  HL.sensorCalibration = (station) => new Calibration(station);
})();
