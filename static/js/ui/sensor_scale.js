// The rules of a chart, without a page: runs between gaps, scales with round numbers, times along the foot, what lies under a finger.
(() => {
  "use strict";
  const GAP_STEPS = 1.75; // one missing step is two steps wide
  const LIMIT_REACH = 3; // a limit may make the scale so many times as high as the values; beyond that it stands at the edge
  const HEADROOM = 0.06;
  const PLACES = [0, 1, 0.75, 0.5, 0.25]; // for the name of a line, from its right end: at the ends first
  const HOUR = 3600000;
  const DAY = 24 * HOUR;
  const SPANS = { "24h": { ms: DAY, label: "24 h", every: 60000 }, "7d": { ms: 7 * DAY, label: "7 days", every: 300000 }, season: { ms: null, label: "Season", every: 900000 } };

  // [[utc, mean, min, max]] -> points; a null mean stays, it is a gap that was said
  function read(points) {
    return (points ?? []).map(([utc, mean, low, high]) => ({ t: Date.parse(utc), mean: mean ?? null, low: low ?? mean ?? null, high: high ?? mean ?? null }))
      .filter((one) => Number.isFinite(one.t)).sort((a, b) => a.t - b.t);
  }

  // what is drawn in one stroke: nothing is joined across a missing value or a missing time
  function runs(points, stepS) {
    const found = [];
    let run = [];
    const end = () => (run.length && found.push(run), (run = []));
    for (const point of points) {
      if (point.mean === null) {
        end();
        continue;
      }
      if (run.length && point.t - run[run.length - 1].t > stepS * 1000 * GAP_STEPS) end();
      run.push(point);
    }
    end();
    return found;
  }

  const steps = (raw) => {
    const power = 10 ** Math.floor(Math.log10(raw));
    return [1, 2, 2.5, 5, 10].map((one) => one * power).find((one) => one >= raw * 0.999);
  };

  // as many as tell one mark from the next: 2.5 needs one, 10 none
  const digits = (step) => (String(Number(step.toPrecision(3))).split(".")[1] ?? "").length;

  // {low, high, ticks}: round numbers that hold every value, and the limits where those are near
  function scale(points, limits, { isFloored = false, count = 4 } = {}) {
    const drawn = points.filter((one) => one.mean !== null);
    let [low, high] = drawn.length ? [Math.min(...drawn.map((one) => one.low)), Math.max(...drawn.map((one) => one.high))] : [0, 1];
    const wide = Math.max(high - low, Math.abs(high) * 0.1, 1e-6);
    for (const limit of [limits?.low, limits?.high]) {
      if (limit === null || limit === undefined) continue;
      if (!drawn.length || (limit <= high + wide * LIMIT_REACH && limit >= low - wide * LIMIT_REACH)) [low, high] = [Math.min(low, limit), Math.max(high, limit)];
    }
    const room = Math.max(high - low, wide) * HEADROOM;
    low = isFloored && low >= 0 ? 0 : low - room;
    high += room;
    const step = steps((high - low) / count);
    const from = Math.floor(low / step + 1e-9) * step;
    const to = Math.ceil(high / step - 1e-9) * step;
    const ticks = Array.from({ length: Math.round((to - from) / step) + 1 }, (_, i) => Number((from + i * step).toPrecision(12)));
    return { low: from, high: to, step, ticks };
  }

  // limits as lines: with the name a person knows them by, and where they are beyond the scale, at its edge
  function limitLines(limits, { low, high }, words) {
    return [["low", "Least"], ["high", "Limit"]].filter(([key]) => Number.isFinite(limits?.[key])).map(([key, name]) => {
      const value = limits[key];
      const beyond = value > high ? "above" : value < low ? "below" : "";
      return { value, at: Math.min(high, Math.max(low, value)), beyond, text: `${name} ${words(value)}${beyond ? `, ${beyond} this scale` : ""}` };
    });
  }

  // from and to in ms: the last 24 h, the last 7 days, or all there is of the season
  function reach(points, span, now) {
    const { ms } = SPANS[span];
    if (ms) return [now - ms, now];
    return points.length ? [Math.min(points[0].t, now - DAY), now] : [now - 90 * DAY, now];
  }

  const pad = (n) => String(n).padStart(2, "0");
  const MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
  const WEEK = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];

  // marks along the foot, in this tablet's time, never closer than apartPx
  function times(from, to, widePx, apartPx = 64) {
    const most = Math.max(2, Math.floor(widePx / apartPx));
    const long = to - from;
    const hours = [1, 2, 3, 4, 6, 12].find((one) => long / (one * HOUR) <= most);
    const found = [];
    if (hours && long <= 2 * DAY) {
      const at = new Date(from);
      at.setMinutes(0, 0, 0);
      for (; at <= to; at.setHours(at.getHours() + 1)) if (at >= from && at.getHours() % hours === 0) found.push({ t: at.getTime(), text: `${pad(at.getHours())}:00`, isDay: at.getHours() === 0 });
      return found;
    }
    const days = [1, 2, 7, 14, 28, 56].find((one) => long / (one * DAY) <= most) ?? 112;
    const at = new Date(from);
    at.setHours(0, 0, 0, 0);
    for (; at <= to; at.setDate(at.getDate() + 1)) {
      const isMarked = days <= 2 ? Math.round((at - new Date(at.getFullYear(), 0, 1)) / DAY) % days === 0 : at.getDay() === 1 && Math.round((at.getTime() / DAY - 4) / 7) % (days / 7) === 0;
      if (isMarked && at >= from) found.push({ t: at.getTime(), text: days <= 2 ? `${WEEK[at.getDay()]} ${at.getDate()}` : `${at.getDate()} ${MONTHS[at.getMonth()]}`, isDay: true });
    }
    return found;
  }

  // treatments that reach into the picture, cut at its edges; one without an end lasts until now
  function bands(treatments, from, to) {
    return (treatments ?? []).map((one) => ({ from: Math.max(from, Date.parse(one.from_utc)), to: Math.min(to, one.to_utc ? Date.parse(one.to_utc) : to), text: one.text, isOpen: !one.to_utc }))
      .filter((one) => one.to > one.from);
  }

  // the point nearest to a time: {point}, or {gap: true} where nothing was measured
  function under(points, t, stepS) {
    const near = points.filter((one) => one.mean !== null).reduce((best, one) => (best && Math.abs(best.t - t) <= Math.abs(one.t - t) ? best : one), null);
    if (!near) return null;
    return Math.abs(near.t - t) <= stepS * 1000 * (GAP_STEPS / 2) ? { point: near } : { gap: true, t };
  }

  // the next point to one side, over gaps too; null beyond the last
  function beyond(points, t, way) {
    const drawn = points.filter((one) => one.mean !== null);
    return (way > 0 ? drawn.find((one) => one.t > t) : drawn.findLast((one) => one.t < t)) ?? null;
  }

  // where the name of a line covers the least: {x, foot} of its beginning, from the right end to the left
  // dots: {x, y} of what is drawn; feet: where the name may stand, best first; the ends of the line, width and height of the name
  function freest(dots, { feet, left, right, wide, high }) {
    const covered = ({ x, foot }) => dots.filter((one) => one.x >= x && one.x <= x + wide && one.y >= foot - high && one.y <= foot + 4).length;
    const places = feet.flatMap((foot) => PLACES.map((share) => ({ x: right - wide - share * Math.max(0, right - wide - left), foot })));
    return places.reduce((best, place) => (covered(place) < covered(best) ? place : best));
  }

  HL.sensorScale = { SPANS, read, runs, scale, digits, limitLines, freest, reach, times, bands, under, beyond };
})();
