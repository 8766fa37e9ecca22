// Ground of all screens: making nodes, and one write pass a frame for everything that lives.
window.HL = (() => {
  "use strict";
  const config = window.HEADLAND || { rights: [], apiPath: "/api/v1" };
  const REPAINT_MS = 200; // ages are shown to a tenth of a second below 10 s, and nobody reads faster
  const views = new Set();
  let isAsked = false;
  let paintedAt = -Infinity;

  // el("b", {class: "x", "data-a": 1, onclick: f}, "text", node): text is always text, never markup
  function el(tag, props, ...children) {
    const node = document.createElement(tag);
    for (const [key, value] of Object.entries(props || {})) {
      if (value === null || value === undefined || value === false) continue;
      if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
      else node.setAttribute(key, value === true ? "" : value);
    }
    node.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
    return node;
  }

  // writes only what differs, so that an unchanged screen costs no layout
  function text(node, value) {
    const string = value === null || value === undefined ? "" : String(value);
    if (node.hlText !== string) {
      node.hlText = string;
      node.textContent = string;
    }
  }

  function attr(node, name, value) {
    if (value === null || value === undefined || value === false) {
      if (node.hasAttribute(name)) node.removeAttribute(name);
    } else {
      const string = value === true ? "" : String(value);
      if (node.getAttribute(name) !== string) node.setAttribute(name, string);
    }
  }

  function style(node, name, value) {
    if (node.style.getPropertyValue(name) !== value) node.style.setProperty(name, value);
  }

  function toggle(node, name, on) {
    if (node.classList.contains(name) !== Boolean(on)) node.classList.toggle(name, Boolean(on));
  }

  function repaint() {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(paintAll);
  }

  function paintAll() {
    isAsked = false;
    paintedAt = performance.now();
    for (const view of [...views]) {
      try {
        view.paint();
      } catch (error) {
        console.error(view.localName, error); // one broken view must not take the others along
      }
    }
  }

  class LiveElement extends HTMLElement {
    connectedCallback() {
      if (!this.isBuilt) {
        this.isBuilt = true;
        this.build();
      }
      views.add(this);
      this.enter();
      repaint();
    }
    disconnectedCallback() {
      views.delete(this);
      this.leave();
    }
    build() {} // once: make the nodes
    enter() {} // each time it enters the page
    leave() {} // each time it leaves: give back listeners and timers
    paint() {} // at most once a frame: compare and write
  }

  const define = (tag, kind) => customElements.get(tag) || customElements.define(tag, kind);
  const emit = (name, detail) => window.dispatchEvent(new CustomEvent(name, { detail }));
  // ages run on; without asking for a frame, because often nothing differs and then none is drawn
  setInterval(() => isAsked || document.hidden || performance.now() - paintedAt < REPAINT_MS / 2 || paintAll(), REPAINT_MS);

  return { config, el, text, attr, style, toggle, repaint, LiveElement, define, emit };
})();
