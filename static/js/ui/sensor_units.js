// Values of stations in the units a person chose: the server sends m/s and °C, everything else comes as it is shown.
(() => {
  "use strict";
  const SPEEDS = { "m/s": 1, "km/h": 3.6, mph: 2.236936 };
  const SAME = { from: (value) => value, back: (value) => value };

  // {unit, from(server) -> shown, back(shown) -> server}
  function of(unit) {
    if (unit === "m/s") {
      const chosen = HL.preferences.get("speed");
      return { unit: chosen, from: (value) => value * SPEEDS[chosen], back: (value) => value / SPEEDS[chosen] };
    }
    if (unit === "°C" && HL.preferences.get("temperature") === "°F") return { unit: "°F", from: (value) => value * 1.8 + 32, back: (value) => (value - 32) / 1.8 };
    return { unit: unit ?? "", ...SAME };
  }

  const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

  // {text, unit} of one value; missing is never a zero
  function shown(value, unit, digits = 1) {
    const own = of(unit);
    return isNumber(value) ? { text: own.from(value).toFixed(digits), unit: own.unit } : { text: "––", unit: "" };
  }
  function words(value, unit, digits = 1) {
    const one = shown(value, unit, digits);
    return one.unit ? `${one.text} ${one.unit}` : one.text;
  }
  const digits = (quantity) => HL.sensorRules.QUANTITIES[quantity]?.digits ?? 1;

  // the same choice inside a sentence; a limit that follows a value is in the value's unit, though it does not name it
  const WITH_LIMIT = /(-?\d+(?:\.\d+)?) (m\/s|°C)(, limit )(-?\d+(?:\.\d+)?)|(-?\d+(?:\.\d+)?) (m\/s|°C)/g;
  function sentence(said) {
    return (said ?? "").replace(WITH_LIMIT, (_, value, unit, limit, bound, lone, its) => {
      const own = of(unit ?? its);
      if (own.unit === (unit ?? its)) return _;
      return limit ? `${own.from(Number(value)).toFixed(1)} ${own.unit}${limit}${own.from(Number(bound)).toFixed(1)}` : `${own.from(Number(lone)).toFixed(1)} ${own.unit}`;
    });
  }

  HL.sensorUnits = { sentence, of, shown, words, digits, isNumber };
})();
