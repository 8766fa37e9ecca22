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

  // Makes a drawing like another one: a node with the key of one that is there is changed, not replaced, so that a tap, a
  // tooltip and the focus on it survive.
  function svgInto(node, wanted) {
    for (const { name, value } of wanted.attributes) if (node.getAttribute(name) !== value) node.setAttribute(name, value);
    if (!wanted.children.length) {
      if (node.children.length || node.textContent !== wanted.textContent) node.textContent = wanted.textContent;
      return;
    }
    const kept = new Map();
    for (const child of node.children) kept.set(keyOf(child), [...(kept.get(keyOf(child)) ?? []), child]);
    const list = [...wanted.children].map((child) => {
      const same = kept.get(keyOf(child))?.shift();
      if (same) svgInto(same, child);
      return same ?? child;
    });
    for (const gone of kept.values()) for (const child of gone) child.remove();
    list.forEach((child, i) => node.children[i] !== child && node.insertBefore(child, node.children[i] ?? null));
  }
  const keyOf = (node) => `${node.tagName} ${node.dataset.key ?? ""}`;

  // wall clock of a moment on the console's clock
  const wallOf = (t) => new Date(Date.now() - HL.port.age(t));

  Object.assign(HL, { superDefine, superSeg: seg, svg, svgInto, wallOf });
})();
