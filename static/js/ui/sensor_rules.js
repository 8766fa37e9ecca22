// What counts for field stations, without a page: ages that run on, states, which station stands for a quantity, what is said.
(() => {
  "use strict";
  const LATE_PERIODS = 1.5; // the console's own rule, hmi/domain/sensors/freshness.py
  const SILENT_PERIODS = 3;
  const STATES = ["fresh", "late", "silent", "never"];
  const ANSWER_OLD_S = 30; // three answers missed: what they said no longer counts as now
  const KINDS = { weather: "Weather", soil: "Soil", respiration: "Respiration", camera: "Camera" };
  // quantity -> what its tile shows: digits, the range of its bar, and whether it cannot be below zero
  const QUANTITIES = {
    air_temperature: { label: "Air", digits: 1, range: [-10, 40] },
    wind_speed: { label: "Wind", digits: 1, range: [0, 15], isFloored: true },
    wind_gust: { label: "Gusts", digits: 1, range: [0, 20], isFloored: true },
    wind_bearing: { label: "Wind from", digits: 0, range: [0, 360], isFloored: true },
    rain_rate: { label: "Rain", digits: 1, range: [0, 10], isFloored: true },
    air_humidity: { label: "Humidity", digits: 0, range: [0, 100], isFloored: true },
    radiation: { label: "Radiation", digits: 0, range: [0, 1000], isFloored: true },
    soil_moisture: { label: "Soil", digits: 1, range: [0, 50], isFloored: true },
    soil_temperature: { label: "Soil temperature", digits: 1, range: [0, 35] },
    co2: { label: "CO2", digits: 0, range: [300, 1500] },
    h2o: { label: "H2O", digits: 1, range: [0, 30], isFloored: true },
  };
  const ORDER = Object.keys(QUANTITIES);
  const BESIDE = new Set(["wind_gust", "wind_bearing", "soil_temperature"]); // stand on the tile of another, where all stations are shown

  const rank = (state) => Math.max(0, STATES.indexOf(state));

  // seconds since it was measured: what the answer said, and the time since that was asked for; null when never
  function ageS(said, passedS) {
    return said === null || said === undefined || !Number.isFinite(said) ? null : said + Math.max(0, passedS);
  }

  // ms of the server's clock, by which everything it tells was measured: a tablet's own may be wrong
  function nowMs(nowUtc, passedS) {
    const at = Date.parse(nowUtc ?? "");
    return Number.isFinite(at + passedS) ? at + Math.max(0, passedS) * 1000 : Date.now();
  }

  // the older of what the server said and what its age says now: between two answers values go on ageing
  function stateNow(said, age, periodS) {
    if (age === null) return "never";
    const p = periodS > 0 ? periodS : Infinity;
    const seen = age > SILENT_PERIODS * p ? "silent" : age > LATE_PERIODS * p ? "late" : "fresh";
    return STATES[Math.max(rank(said), rank(seen))];
  }

  // stations as they are now, passedS after the answer that told of them was asked for
  function aged(stations, passedS) {
    return stations.map((one) => {
      const age = ageS(one.age_s, passedS);
      const values = (one.values ?? []).map((value) => {
        const own = ageS(value.age_s, passedS);
        return { ...value, age: own, state: stateNow(value.state ?? one.state, own, one.period_s) };
      });
      return { ...one, age, state: stateNow(one.state, age, one.period_s), values };
    });
  }

  const place = (value) => [ORDER.indexOf(value.quantity) < 0 ? ORDER.length : ORDER.indexOf(value.quantity), value.depth_m ?? 0, value.key];
  function inOrder(a, b) {
    const [one, other] = [place(a.value ?? a), place(b.value ?? b)];
    const at = one.findIndex((part, i) => part !== other[i]);
    return at < 0 ? 0 : one[at] < other[at] ? -1 : 1;
  }

  const weight = ({ station, value }) => rank(value.state) * 2 + (value.is_over ? 0 : 1) + (station.is_accepted ? 0 : 100);

  // one tile for each quantity and depth: of the chosen station, else the station whose word counts most
  function tiles(stations, chosen) {
    const found = new Map();
    for (const station of stations) {
      if (chosen ? station.id !== chosen : !station.is_accepted) continue;
      for (const value of station.values) {
        if (!chosen && BESIDE.has(value.quantity)) continue;
        if (chosen && value.quantity === "wind_bearing") continue; // the arrow on the wind says it
        if (!found.has(value.key)) found.set(value.key, []);
        found.get(value.key).push({ station, value });
      }
    }
    return [...found.values()]
      .map((all) => {
        const [best] = [...all].sort((a, b) => weight(a) - weight(b) || a.station.name.localeCompare(b.station.name));
        return { ...best, all };
      })
      .sort(inOrder);
  }

  // another value of the same station, at the same depth if it has one
  const beside = ({ station, value }, quantity) => station.values.find((one) => one.quantity === quantity && (one.depth_m ?? null) === (value.depth_m ?? null)) ?? null;

  const FAR = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
  const compass = (deg) => FAR[Math.round((((deg % 360) + 360) % 360) / 45) % 8];

  // share of the bar, 0 to 100
  function along(value, [low, high]) {
    return Math.min(100, Math.max(0, ((value - low) / (high - low)) * 100));
  }
  // the bar of a value: where it stands and which part is within its limit; null without a number
  function bar(value) {
    const { range } = QUANTITIES[value.quantity] ?? {};
    if (!range || !Number.isFinite(value.value)) return null;
    const { low = null, high = null } = value.limit ?? {};
    const limits = [low, high].filter((one) => one !== null && one !== undefined);
    return { ptr: along(value.value, range), ok: [low === null ? 0 : along(low, range), high === null ? 100 : along(high, range)], limits: limits.map((one) => along(one, range)) };
  }

  // what a forecast is measured against: the strictest of the limits that treatment waits for; others only warn
  function treatmentLimits(stations, quantities) {
    const found = {};
    for (const quantity of quantities) {
      const limits = stations.filter((one) => one.is_accepted).flatMap((one) => one.values).filter((value) => value.quantity === quantity && value.limit?.is_treatment).map((value) => value.limit.high);
      const highs = limits.filter(Number.isFinite);
      if (highs.length) found[quantity] = Math.min(...highs);
    }
    return found;
  }

  // the newest word of any accepted weather station; null while one of them reports, or where there is none
  function weatherProblem(stations, atTime) {
    const weather = stations.filter((one) => one.is_accepted && one.kind === "weather");
    if (!weather.length || weather.some((one) => rank(one.state) < rank("silent"))) return null;
    const heard = weather.map((one) => Date.parse(one.heard_utc ?? "")).filter(Number.isFinite);
    return heard.length ? `No weather since ${atTime(new Date(Math.max(...heard)))}. Rain stop may be late.` : "No weather was heard yet. Rain stop may be late.";
  }

  // the gate as it counts now: an answer that is old says nothing about now
  function gateNow(gate, passedS, askedAt) {
    if (!gate) return { state: "unknown", sentence: "The server says nothing about treatment.", facts: [] };
    if (passedS <= ANSWER_OLD_S) return gate;
    return { state: "unknown", sentence: `Not known since ${askedAt}: the server does not answer.`, facts: (gate.facts ?? []).map((fact) => ({ ...fact, ok: null })) };
  }

  // what a row says of its station: the server's sentence, else the browser's own while the next answer is awaited
  function sentence(station, since) {
    if (station.sentence) return station.sentence;
    if (station.state === "never") return "Nothing was heard of it yet.";
    if (station.state === "silent") return `${station.name} silent for ${since(station.age * 1000)}.`;
    return "";
  }

  const NOTICE = {
    sent: (text) => `Told, no answer yet: ${text}`,
    acknowledged: (text) => `Knows: ${text}`,
    refused: (text) => `Refused the notice: ${text}`,
    unconfirmed: (text) => `Not confirmed, it may not know: ${text}`,
  };
  const noticeWords = (notice) => (notice && NOTICE[notice.state] ? NOTICE[notice.state](notice.text || "treatment under way") : "");

  // what a person typed: a comma is a point; NaN when it is no number, null when it is empty
  function number(text) {
    const plain = String(text ?? "").trim().replace(",", ".");
    if (!plain) return null;
    return /^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain) ? Number(plain) : NaN;
  }

  // "9 stations, 1 silent, 1 new"
  function summary(stations) {
    const known = stations.filter((one) => one.is_accepted);
    const count = (state) => known.filter((one) => one.state === state).length;
    const fresh = stations.length - known.length;
    const parts = [["late", "late"], ["silent", "silent"], ["never", "never heard"]].map(([state, words]) => (count(state) ? `${count(state)} ${words}` : ""));
    return [`${known.length} ${known.length === 1 ? "station" : "stations"}`, ...parts, fresh ? `${fresh} new` : ""].filter(Boolean).join(", ");
  }

  HL.sensorRules = { STATES, KINDS, QUANTITIES, ORDER, ANSWER_OLD_S, rank, ageS, nowMs, stateNow, aged, tiles, beside, compass, bar, treatmentLimits, weatherProblem, gateNow, sentence, noticeWords, number, summary };
})();
