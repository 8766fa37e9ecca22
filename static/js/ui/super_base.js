// Ground of Supervisor and Twin: their style, and elements that come to life when the style is there.
(() => {
  "use strict";
  const { el, define } = HL;
  const styles = new Map();

  // drawn before its style is there, everything would jump
  function styled(href) {
    if (!styles.has(href)) {
      const link = el("link", { rel: "stylesheet", href });
      styles.set(href, new Promise((resolve) => (link.onload = link.onerror = resolve)));
      document.head.append(link);
    }
    return styles.get(href);
  }

  // defines an element of the screen that is open, as soon as the styles of that screen are loaded
  function superDefine(tag, kind) {
    const named = document.querySelector("[data-screen-style]")?.dataset.screenStyle.split(" ") ?? [];
    Promise.all(named.map(styled)).then(() => define(tag, kind));
  }

  // a segmented control: seg("View", [["chart", "Chart"], ...], "chart", (key) => ...) -> {node, choose(key)}
  function seg(label, choices, first, chosen, hook) {
    const buttons = choices.map(([key, word]) => el("button", { type: "button", "data-key": key, "data-testid": `${hook}-${key}`, onclick: () => choose(key) }, word));
    const node = el("div", { class: "h-seg", role: "group", "aria-label": label }, ...buttons);
    function mark(key) {
      for (const button of buttons) {
        HL.toggle(button, "on", button.dataset.key === key);
        HL.attr(button, "aria-pressed", button.dataset.key === key ? "true" : "false");
      }
    }
    function choose(key) {
      mark(key);
      chosen(key);
    }
    mark(first);
    return { node, choose, mark };
  }

  function svg(tag, attributes, ...children) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [key, value] of Object.entries(attributes)) if (value !== null && value !== undefined) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }

  // wall clock of a moment on the console's clock
  const wallOf = (t) => new Date(Date.now() - HL.port.age(t));

  Object.assign(HL, { superDefine, superSeg: seg, svg, wallOf });
})();
