// The hours to come, each with what treatment waits for; a forecast that is old or failed says so and looks so.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle } = HL;
  const U = HL.sensorUnits;
  const MOST = 24;
  const OFF = "No forecast set. The setting forecast_url of the server names its address; an admin sets it.";

  class Forecast {
    constructor() {
      this.said = el("span", { class: "h-t14 h-2" });
      this.sign = icon("info", "m");
      this.hours = el("ol", { class: "sn-hours", tabindex: "0", "aria-label": "Hours to come" });
      this.node = el("section", { class: "h-card sn-forecast", "aria-label": "Forecast", "data-testid": "sensors-forecast" }, el("div", { class: "sn-forehead" }, el("b", { class: "h-t14 h-b h-row" }, "Forecast", this.sign), this.said), this.hours);
    }

    paint(forecast, limits) {
      const state = forecast?.state ?? "off";
      const hours = state === "off" ? [] : (forecast.hours ?? []).filter((one) => Date.parse(one.utc) > HL.sensors.now() - 3600000).slice(0, MOST);
      attr(this.node, "data-state", state);
      toggle(this.node, "stale", state === "old" || state === "failed");
      text(this.said, state === "off" ? forecast?.sentence || OFF : U.sentence(forecast.sentence) || (state === "fresh" ? "" : "This forecast is old."));
      text(this.sign, state === "fresh" ? "schedule" : state === "off" ? "info" : "sync_problem");
      attr(this.hours, "hidden", !hours.length);
      const key = JSON.stringify([hours, limits, HL.preferences.get("speed"), HL.preferences.get("temperature")]);
      if (key === this.drawn) return;
      this.drawn = key;
      this.hours.replaceChildren(...hours.map((one) => this.hour(one, limits)));
    }

    hour(one, limits) {
      const over = (key) => U.isNumber(one[key]) && U.isNumber(limits[key]) && one[key] > limits[key];
      const figure = (key, unit, digits) => el("span", { class: over(key) ? "over" : null, title: over(key) ? "over the limit of treatment" : null }, over(key) ? "◆ " : "", U.words(one[key], unit, digits));
      return el("li", {}, el("b", {}, HL.words.wall(new Date(one.utc))), figure("air_temperature", "°C", 0), figure("wind_speed", "m/s", 1), figure("rain_rate", "mm/h", 1));
    }
  }

  HL.SensorForecast = Forecast;
})();
