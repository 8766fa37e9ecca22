// Ground of the Supervisor screen: its style, and elements that come to life when the style is there.
(() => {
  "use strict";
  const { el, define } = HL;
  const waiting = [];
  let isReady = false;

  // drawn before its style is there, everything would jump
  function styled(href) {
    if (!href || document.querySelector(`link[href="${href}"]`)) return Promise.resolve();
    const link = el("link", { rel: "stylesheet", href });
    document.head.append(link);
    return new Promise((resolve) => (link.onload = link.onerror = resolve));
  }

  // defines an element of this screen, as soon as its style is loaded
  function superDefine(tag, kind) {
    if (isReady) define(tag, kind);
    else waiting.push([tag, kind]);
  }

  styled(document.querySelector("[data-super-style]")?.dataset.superStyle).then(() => {
    isReady = true;
    for (const [tag, kind] of waiting.splice(0)) define(tag, kind);
  });

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
