// A button with a panel below it: one at a time, Escape and a touch elsewhere close it.
(() => {
  "use strict";
  const { el, attr } = HL;
  let open = null;

  // dropdown(button, fill() -> nodes) -> {node, close}
  function dropdown(button, fill, side = "") {
    const panel = el("div", { class: `h-menu ${side}`.trim(), hidden: true });
    const node = el("div", { class: "m-drop" }, button, panel);
    attr(button, "aria-haspopup", "true");
    attr(button, "aria-expanded", "false");
    const menu = { node, panel, close };
    function close() {
      if (panel.hidden) return;
      if (panel.contains(document.activeElement)) button.focus({ preventScroll: true });
      panel.hidden = true;
      attr(button, "aria-expanded", "false");
      if (open === menu) open = null;
    }
    button.addEventListener("click", () => {
      const wasOpen = !panel.hidden;
      open?.close();
      if (wasOpen) return;
      panel.replaceChildren(...fill(close));
      panel.hidden = false;
      open = menu;
      attr(button, "aria-expanded", "true");
      panel.querySelector("a, button, input")?.focus({ preventScroll: true });
    });
    return menu;
  }

  document.addEventListener("pointerdown", (event) => open && !open.node.contains(event.target) && open.close());
  document.addEventListener("keydown", (event) => event.key === "Escape" && open?.close());

  HL.maps.dropdown = dropdown;
})();
