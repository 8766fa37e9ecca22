// SI inside, the person's units on the screen.
(() => {
  "use strict";
  const SPEEDS = { "m/s": [1, 2], "km/h": [3.6, 1], mph: [2.236936, 1] };
  const AREAS = { ha: [1e-4, 2], ac: [2.471054e-4, 2] };
  const LENGTHS = { m: [1, 1], ft: [3.28084, 0] };

  const chosen = (key) => HL.preferences.get(key);

  function scaled(table, unit, value) {
    const [factor, digits] = table[unit];
    return { text: (value * factor).toFixed(digits), unit };
  }

  const speed = (mps) => scaled(SPEEDS, chosen("speed"), mps);
  const area = (m2) => scaled(AREAS, chosen("area"), m2);
  const length = (m) => scaled(LENGTHS, chosen("length"), m);
  const temperature = (c) => (chosen("temperature") === "°F" ? { text: (c * 1.8 + 32).toFixed(0), unit: "°F" } : { text: c.toFixed(0), unit: "°C" });

  // A tile's number: kinds that people choose a unit for are made here, everything else comes worded.
  function tile(entry) {
    if (typeof entry.value === "number" && Number.isFinite(entry.value)) {
      if (entry.kind === "speed") return speed(entry.value);
      if (entry.kind === "temperature") return temperature(entry.value);
      if (entry.kind === "length" && entry.unit === "m") return length(entry.value);
    }
    return { text: entry.text ?? "–", unit: entry.unit ?? "" };
  }

  // "set 0.45 m/s", "interlock ok, 41 °C": the same choice inside a sentence
  const IN_TEXT = [
    [/(-?\d+(?:\.\d+)?) m\/s/g, speed],
    [/(-?\d+(?:\.\d+)?) °C/g, temperature],
  ];
  function sentence(words) {
    return IN_TEXT.reduce((done, [pattern, make]) => done.replace(pattern, (_, n) => Object.values(make(Number(n))).join(" ")), words || "");
  }

  Object.assign(HL, { units: { speed, area, length, temperature, tile, sentence } });
})();
