// Signs: icons by name, alarm glyphs (shape is priority, fill and ring are state), robots by family.
(() => {
  "use strict";
  const { el } = HL;
  const NS = "http://www.w3.org/2000/svg";

  const icon = (name, look = "") => el("i", { class: `h-i ${look}`.trim(), "aria-hidden": "true" }, name);

  function svg(tag, attributes, ...children) {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }

  const SHAPES = {
    1: "M3 3h18v18H3z",
    2: "M12 1.5 23.5 22H.5z",
    3: "M12 .5 23.5 12 12 23.5.5 12z",
    4: "M12 2a10 10 0 1 0 0 20 10 10 0 0 0 0-20z",
  };
  const RINGS = {
    1: "M-1-1h26v26H-1z",
    2: "M12-4.5 28 25.3H-4z",
    3: "M12-4.5 28.5 12 12 28.5-4.5 12z",
    4: "M12-2a14 14 0 1 0 0 28 14 14 0 0 0 0-28z",
  };

  // state is the ISA state: a ring means that nobody has seen it, hollow that its condition is gone, dashes that it is put aside
  const RINGED = ["unacknowledged", "returned"];
  const BLINK_MS = 1000;
  const ASIDE = ["shelved", "suppressed", "out_of_service"];

  function alarm(level, size = 26, state = "acknowledged") {
    const isAside = ASIDE.includes(state);
    const isHollow = isAside || state === "returned" || state === "latched";
    const colour = `var(--hl-p${level})`;
    const sign = svg("svg", { class: "h-ag", width: size, height: size, viewBox: "-5 -5 34 34", role: "img", "data-state": state, "aria-label": `priority ${level}, ${state.replaceAll("_", " ")}` });
    sign.append(svg("path", { class: isAside ? "aside" : "", d: SHAPES[level], fill: isHollow ? "none" : colour, stroke: isAside ? "currentColor" : colour, "stroke-width": isHollow ? 2.5 : 1 }));
    if (RINGED.includes(state)) {
      const ring = svg("path", { class: "ring", d: RINGS[level] });
      ring.style.animationDelay = `-${Math.round(performance.now() % BLINK_MS)}ms`; // all blink as one
      sign.append(ring);
    }
    const number = svg("text", { x: 12, y: level === 2 ? 20 : 16.8, fill: isHollow ? "currentColor" : `var(--hl-on-p${level})` });
    number.textContent = level;
    sign.append(number);
    return sign;
  }

  const BODIES = {
    weeder: "M-9-9.5a2.5 2.5 0 0 1 2.5-2.5h13a2.5 2.5 0 0 1 2.5 2.5v19a2.5 2.5 0 0 1-2.5 2.5h-13a2.5 2.5 0 0 1-2.5-2.5zM-14-12h4.4v24H-14zM9.6-12H14v24H9.6z",
    planter: "M-11-13h22v26h-22zM-16-12h4.4v24H-16zM11.6-12H16v24h-4.4z",
    uav: "M0-15 12 13 0 7-12 13z",
  };

  function robot(family, size = 28) {
    const sign = svg("svg", { width: size, height: size, viewBox: "-17 -15 34 30", "aria-hidden": "true" });
    sign.append(svg("path", { d: BODIES[family] || BODIES.weeder, fill: "var(--hl-sel)" }));
    if (family !== "uav") sign.append(svg("path", { d: "M0-7.5 5.4 4.5 0 1.6-5.4 4.5z", fill: "var(--hl-on-sel)" }));
    return sign;
  }

  Object.assign(HL, { icon, alarm, robotGlyph: robot });
})();
