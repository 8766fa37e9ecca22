// The slab and the stop-all segment: their own root after #q-app, above everything, on every screen.
(() => {
  "use strict";
  const parts = (window.headlandStopParts = window.headlandStopParts || {});
  const SVG = "http://www.w3.org/2000/svg";
  const OUTER = "M20 3h24l17 17v24L44 61H20L3 44V20z";
  const INNER = "M23.5 11.5h17l12 12v17l-12 12h-17l-12-12v-17z";
  const ICONS = {
    octagon: [["path", { d: OUTER, class: "rim" }], ["path", { d: INNER, class: "sign" }], ["rect", { x: 23, y: 23, width: 18, height: 18, class: "core" }]],
    lock: [["path", { d: "M20 28v-8a12 12 0 0 1 24 0v8", class: "bow" }], ["path", { d: "M14 28h36a3 3 0 0 1 3 3v25a3 3 0 0 1-3 3H14a3 3 0 0 1-3-3V31a3 3 0 0 1 3-3zm18 10a5.5 5.5 0 1 0 0 11 5.5 5.5 0 0 0 0-11z", class: "solid" }]],
    hand: [
      ["path", { d: "M21 32V15M31 30V8M41 31V13M50 36V21", class: "finger" }],
      ["path", { d: "M16.5 29.5h38v12.500a18 18 0 0 1-18 18h-4.500c-6 0-10-2.500-13.500-7L8 40.500c-2.600-4 2.400-7.600 5.500-4.800l3 2.800z", class: "solid" }],
    ],
  };
  const ICON_OF = { standstill: "lock", "not-confirmed": "hand" };

  function element(tag, attributes = {}, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }

  function icon(name) {
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", "0 0 64 64");
    svg.setAttribute("aria-hidden", "true");
    svg.setAttribute("class", `hl-stop-icon ${name}`);
    for (const [tag, attributes] of ICONS[name]) {
      const shape = document.createElementNS(SVG, tag);
      for (const [key, value] of Object.entries(attributes)) shape.setAttribute(key, value);
      svg.append(shape);
    }
    return svg;
  }

  const text = (node, value) => node.textContent !== value && (node.textContent = value);
  const hide = (node, isHidden) => node.hidden !== isHidden && (node.hidden = isHidden); // writing the same still costs a frame
  function attribute(node, name, value) {
    if (value === null || value === undefined) node.removeAttribute(name);
    else if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
  }

  class Button {
    // `onPress` is called at pointer down, at Enter or Space down, and for a click that no pointer made (switch control).
    constructor(hook, onPress) {
      this.node = element("button", { type: "button", class: `hl-${hook}`, "data-testid": hook, tabindex: "1" });
      let last = -Infinity;
      const press = (event) => {
        event.preventDefault();
        last = performance.now();
        onPress();
      };
      this.node.addEventListener("pointerdown", press);
      this.node.addEventListener("keydown", (event) => ["Enter", " "].includes(event.key) && !event.repeat && press(event));
      this.node.addEventListener("click", (event) => performance.now() - last > 1000 && press(event));
      this.node.addEventListener("contextmenu", (event) => event.preventDefault());
    }

    sign(name) {
      if (this.shown === name) return;
      this.shown = name;
      const old = this.node.querySelector("svg");
      if (old) old.replaceWith(icon(name));
      else this.face.prepend(icon(name));
    }
  }

  class Slab {
    constructor({ onPress, onPressAll }) {
      document.getElementById("headland-stop")?.remove(); // a second copy of the script must not make a second slab
      this.slab = new Button("stop", onPress);
      this.all = new Button("stop-all", onPressAll);
      [this.word, this.scope, this.line] = [element("span", { class: "w" }), element("span", { class: "sc" }), element("span")];
      this.dot = element("i");
      this.slab.face = element("span", { class: "face" }, element("span", { class: "words" }, this.word, this.scope, element("span", { class: "st" }, this.dot, this.line)));
      this.slab.node.append(this.slab.face);
      [this.first, this.second] = [element("span"), element("span")];
      this.all.face = element("span", { class: "face" }, this.first, this.second);
      this.all.node.append(this.all.face);
      this.news = element("div", { class: "hl-stop-news", role: "status", "aria-live": "polite" });
      this.alarm = element("div", { class: "hl-stop-news", role: "alert" });
      this.root = element("div", { id: "headland-stop", role: "region", "aria-label": "Software stop" }, this.slab.node, this.all.node, this.news, this.alarm);
      this.attach();
      new MutationObserver(() => this.attach()).observe(document.body, { childList: true });
    }

    // Screens, dialogs and reconnects may rebuild the page around it: it is always there.
    attach() {
      if (this.root.parentNode !== document.body) document.body.append(this.root);
    }

    draw(view, all, isAll, now) {
      const [word, scope, line, hasDot] = isAll ? parts.words.all(all, now) : parts.words.one(view, now);
      const state = isAll ? all.state : view.state;
      const said = [word, scope, line, hasDot, state, isAll, isAll || [view.id, view.name, view.isStanding], parts.words.segment(all), all.state, all.standing, all.total, all.failing].join("|");
      if (said === this.drawn) return; // ten looks a second, and mostly it says the same
      this.drawn = said;
      attribute(this.slab.node, "data-state", state);
      attribute(this.slab.node, "data-scope", isAll ? "all" : view.id);
      attribute(this.slab.node, "aria-label", `${word} ${isAll ? "" : view.name}. ${scope} ${line}`);
      attribute(this.slab.node, "data-hollow", state === "no-link" || (state === "standstill" && !isAll && !view.isStanding) ? "" : null);
      attribute(this.slab.face, "data-testid", isAll ? "stop-all" : null);
      for (const node of isAll ? [this.slab.node, this.slab.face] : [this.all.node]) count(node, all);
      if (!isAll) count(this.slab.node, null);
      if (!isAll) count(this.slab.face, null);
      text(this.word, word);
      text(this.scope, scope);
      text(this.line, line);
      attribute(this.scope, "data-long", scope.length > 20 ? "" : null);
      attribute(this.line, "data-long", line.length > 25 ? "" : null);
      hide(this.dot, !hasDot);
      this.slab.sign(ICON_OF[state] || "octagon");
      this.drawSegment(all, isAll);
      this.announce(state, `${isAll ? "" : `${view.name}: `}${scope}. ${line}`);
    }

    drawSegment(all, isAll) {
      hide(this.all.node, isAll);
      if (isAll) return;
      const [first, second] = parts.words.segment(all);
      attribute(this.all.node, "aria-label", `STOP ALL. ${first} ${second}`);
      text(this.first, first);
      text(this.second, second);
      this.all.sign(ICON_OF[all.state] || "octagon");
    }

    announce(state, sentence) {
      if (state === this.said) return;
      const isFirst = this.said === undefined;
      this.said = state;
      text(this.alarm, state === "not-confirmed" ? `Stop not confirmed. Use the red button on the machine.` : "");
      if (!isFirst && state !== "not-confirmed") text(this.news, sentence);
    }
  }

  function count(node, all) {
    attribute(node, "data-standing", all?.standing);
    attribute(node, "data-total", all?.total);
    attribute(node, "data-failing", all?.failing.length ? all.failing.join(", ") : null);
    if (!all) return;
    attribute(node, "data-state", all.state);
    attribute(node, "title", all.failing.length ? `Not confirmed: ${all.failing.join(", ")}` : null);
  }

  Object.assign(parts, { Slab, element, attribute, text });
})();
