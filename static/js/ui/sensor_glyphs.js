// Signs of stations: a picture by kind, an outline by state. The map draws the same ones.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const NS = "http://www.w3.org/2000/svg";
  // in a box of 24 units
  const PICTURES = {
    weather: "M7 19.500a5 5 0 0 1-.600-9.960A6.500 6.500 0 0 1 18.900 9.200 5.200 5.200 0 0 1 18.500 19.500z",
    soil: "M12 1c3.600 4.600 6 7.700 6 10.500a6 6 0 0 1-12 0C6 8.700 8.400 5.600 12 1zM2 20h20v2.500H2zM5 16h3v2.500H5zM16 16h3v2.500h-3z",
    respiration: "M7 2l4.500 5.500H8.500V16h-3V7.500H2.500zM17 2l4.500 5.500h-3V16h-3V7.500h-3zM2 19h20v2.500H2z",
    camera: "M3 7h4l2-3h6l2 3h4v14H3zM12 9.500a4.500 4.500 0 1 0 0 9 4.500 4.500 0 1 0 0-9zM12 11.700a2.300 2.300 0 1 1 0 4.600 2.300 2.300 0 1 1 0-4.600z",
  };
  const OUTLINES = {
    fresh: "M18 1a17 17 0 1 0 0 34 17 17 0 1 0 0-34z",
    late: "M18 2a16 16 0 1 0 0 32 16 16 0 1 0 0-32z",
    silent: "M18 0 36 18 18 36 0 18z",
    never: "M5 2h26a3 3 0 0 1 3 3v26a3 3 0 0 1-3 3H5a3 3 0 0 1-3-3V5a3 3 0 0 1 3-3z",
  };
  const WORDS = { fresh: "reports", late: "late", silent: "silent", never: "never heard" };

  function svg(tag, attributes, ...children) {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(attributes)) if (value !== null && value !== undefined) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }

  // the sign of a station in a list
  class StationSign {
    constructor(size = 40) {
      this.outline = svg("path", { class: "o" });
      this.picture = svg("path", { class: "p", "fill-rule": "evenodd", transform: "translate(8.400 8.400) scale(.8)" });
      this.node = svg("svg", { class: "sn-sign", width: size, height: size, viewBox: "-1 -1 38 38", role: "img" }, this.outline, this.picture);
    }
    paint(kind, state) {
      attr(this.node, "data-state", state);
      attr(this.node, "aria-label", `${HL.sensorRules.KINDS[kind] ?? "Station"}, ${WORDS[state] ?? state}`);
      attr(this.outline, "d", OUTLINES[state] ?? OUTLINES.never);
      attr(this.picture, "d", PICTURES[kind] ?? PICTURES.weather);
    }
  }

  // the way the wind blows; bearing is where it comes from
  class WindArrow {
    constructor() {
      this.arrow = svg("path", { d: "M12 1 19 21 12 16.500 5 21z" });
      this.node = svg("svg", { class: "sn-wind", width: 30, height: 30, viewBox: "0 0 24 24", role: "img" }, this.arrow);
    }
    paint(bearing) {
      attr(this.node, "aria-label", `from ${HL.sensorRules.compass(bearing)}`);
      attr(this.arrow, "transform", `rotate(${Math.round(bearing + 180)} 12 12)`);
    }
  }

  // battery of a station, and how it says that it is low
  class BatteryLine {
    constructor() {
      this.level = el("i");
      this.words = el("span");
      this.node = el("span", { class: "sn-battery" }, el("span", { class: "sn-cell", "aria-hidden": "true" }, this.level), this.words);
    }
    paint(station) {
      const isKnown = HL.sensorUnits.isNumber(station.battery);
      attr(this.node, "hidden", !isKnown);
      if (!isKnown) return;
      HL.style(this.level, "width", `${Math.round(station.battery * 100)}%`);
      text(this.words, `${Math.round(station.battery * 100)} %`);
      attr(this.node, "data-low", Boolean(station.battery_low));
      attr(this.node, "aria-label", `Battery ${Math.round(station.battery * 100)} %${station.battery_low ? ", low" : ""}`);
    }
  }

  HL.sensorGlyphs = { PICTURES, WORDS, svg, StationSign, WindArrow, BatteryLine };
})();
