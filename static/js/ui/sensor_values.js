// What is measured: the chosen station or all of them as tiles, one of them over time, and the hours to come.
(() => {
  "use strict";
  const { el, icon, text, attr, words, LiveElement } = HL;
  const R = HL.sensorRules;

  const every = (s) => (s >= 5400 ? `every ${Math.round(s / 3600)} h` : s >= 90 ? `every ${Math.round(s / 60)} min` : `every ${Math.round(s)} s`);

  class Values extends LiveElement {
    build() {
      this.heading = el("b", { class: "h-t18 h-b h-ell" });
      this.line = el("span", { class: "h-t14 h-2 sn-titleline" });
      this.close = el("button", { type: "button", class: "h-btn ico", "aria-label": "Show all stations", "data-testid": "sensor-close", onclick: () => HL.sensors.choose(null) }, icon("close"));
      this.head = el("div", { class: "sn-title" }, (this.sign = new HL.sensorGlyphs.StationSign(36)).node, el("span", { class: "sn-names" }, this.heading, this.line), el("span", { class: "h-sp" }), this.close);
      this.tiles = new HL.SensorTiles();
      this.camera = el("div", { class: "h-card sn-camera", "data-testid": "sensor-pictures" }, icon("photo_camera", "l"), el("span", { class: "sn-names" }, (this.pictures = el("b", { class: "h-t16 h-b" })), (this.picturesLine = el("span", { class: "h-t14 h-2" }))), el("span", { class: "h-sp" }), el("a", { class: "h-btn", href: "/cameras", "data-testid": "sensor-cameras" }, icon("grid_view", "m"), "Open Cameras"));
      this.none = el("div", { class: "h-card sn-none", "data-testid": "sensors-novalues" }, icon("hourglass_top", "l"), (this.noneWords = el("span", { class: "h-t16" })));
      this.curve = new HL.SensorCurve();
      this.forecast = new HL.SensorForecast();
      this.append(this.head, this.camera, this.none, this.tiles.node, this.curve.node, this.forecast.node);
    }

    paint() {
      const { found, chosen, shown } = HL.sensors;
      if (!found) return;
      const stations = HL.sensors.stations();
      const one = chosen ? stations.find((other) => other.id === chosen) : null;
      attr(this, "data-chosen", one?.id ?? null);
      attr(this.head, "hidden", !one);
      attr(this.camera, "hidden", one?.kind !== "camera");
      if (one) this.paintOne(one);
      const count = this.tiles.paint(stations, one?.id ?? null, shown);
      attr(this.tiles.node, "hidden", !count);
      attr(this.none, "hidden", count > 0 || one?.kind === "camera");
      text(this.noneWords, one ? `${one.name} has measured nothing yet. It reports ${every(one.period_s)}.` : "Nothing was measured yet. Each station brings its values with its next report.");
      this.curve.paint(stations);
      this.forecast.paint(found.forecast, R.treatmentLimits(stations, ["wind_speed", "rain_rate", "air_temperature"]));
    }

    paintOne(one) {
      this.sign.paint(one.kind, one.state);
      text(this.heading, one.name || one.id);
      const heard = one.age === null ? "never heard" : `heard ${words.age(one.age * 1000)} ago`;
      const battery = HL.sensorUnits.isNumber(one.battery) ? `battery ${Math.round(one.battery * 100)} %` : "";
      text(this.line, [one.parcel_name || one.parcel || "no field", heard, battery, one.model].filter(Boolean).join(" · "));
      if (one.kind !== "camera") return;
      text(this.pictures, `${one.pictures_today ?? 0} of ${one.pictures_limit ?? "–"} pictures today`);
      text(this.picturesLine, HL.sensorDock.said(one.id) || (one.camera ? "Its pictures are on Cameras." : "Its pictures reach Cameras after the first one."));
    }
  }

  // what can be done with the chosen station; what cannot stays in place with its reason
  const NOBODY = "Choose a station.";
  const said = new Map(); // station -> what came of the last picture asked for
  let isAsking = false;

  class Dock extends LiveElement {
    build() {
      const button = (hook, sign, label, act) => el("button", { type: "button", class: "h-btn op", "data-testid": hook, onclick: act }, icon(sign), label);
      this.limits = button("sensors-limits", "straighten", "Limits", () => HL.sensorLimits(HL.sensors.may("limits")));
      this.edit = button("sensor-edit-open", "edit", "Edit", () => HL.sensorSheets.edit(this.station()));
      this.calibrate = button("sensor-calibrate", "tune", "Calibrate", () => HL.sensorCalibration(this.station()));
      this.trigger = button("sensor-trigger", "photo_camera", "Take a picture", () => this.take());
      this.why = el("span", { class: "h-hint sn-hint", role: "status", "data-testid": "sensors-hint" });
      this.append(this.limits, this.edit, this.calibrate, this.trigger, this.why);
    }

    station() {
      return HL.sensors.chosen ? HL.sensors.station(HL.sensors.chosen) : null;
    }

    paint() {
      const { found } = HL.sensors;
      attr(this, "hidden", !found?.stations?.length);
      if (!found) return;
      const one = this.station();
      const isNew = Boolean(one) && !one.is_accepted;
      const reason = {
        edit: !one ? NOBODY : isNew ? "Accept it first." : HL.sensors.may("accept") ? "" : "Planners edit stations.",
        calibrate: !one ? NOBODY : isNew ? "Accept it first." : !one.values.length ? "It measures no values." : HL.sensors.may("calibrate") ? "" : "Planners calibrate.",
        trigger: !one ? NOBODY : one.kind !== "camera" ? "It has no camera." : isNew ? "Accept it first." : !HL.sensors.may("trigger") ? "Operators take pictures." : isAsking ? "Waiting for the station" : "",
      };
      attr(this.trigger, "hidden", Boolean(one) && one.kind !== "camera");
      for (const [key, words] of Object.entries(reason)) {
        this[key].disabled = Boolean(words);
        attr(this[key], "title", words || null);
      }
      const hints = [...new Set(Object.entries(reason).filter(([key]) => !this[key].hidden).map(([, words]) => words).filter(Boolean))];
      text(this.why, one && said.get(one.id) ? said.get(one.id) : hints.join(" "));
    }

    async take() {
      const one = this.station();
      if (!one || isAsking) return;
      isAsking = true;
      said.set(one.id, "Asked for a picture. Waiting for the station.");
      HL.repaint();
      const { words: answer } = await HL.sensorSheets.trigger(one);
      isAsking = false;
      said.set(one.id, `${HL.words.wall(new Date())}: ${answer}`);
      HL.repaint();
    }
  }

  HL.SensorValues = Values;
  HL.SensorDock = Dock;
  HL.sensorDock = { said: (id) => said.get(id) ?? "" };
})();
