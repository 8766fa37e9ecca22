// Sheets and toasts. They end above the dock: STOP is never covered, and nothing uses the browser's top layer.
(() => {
  "use strict";
  const { el, icon, LiveElement, define } = HL;
  const TOAST_MS = 6000;
  let open = null;

  // sheet({title, body: [nodes], buttons: [[label, action, isPrimary]]}) -> close()
  function sheet({ title, body = [], buttons = [], hook = "dialog" }) {
    close();
    const back = document.activeElement;
    const foot = buttons.map(([label, act, isPrimary]) =>
      el("button", { type: "button", class: isPrimary ? "h-btn pri" : "h-btn", onclick: () => act(done) }, label),
    );
    const box = el("section", { class: "h-sheet", role: "dialog", "aria-modal": "false", "aria-label": title, "data-testid": hook, tabindex: "-1" });
    box.append(el("h2", {}, title), ...body, foot.length ? el("div", { class: "foot" }, ...foot) : "");
    const scrim = el("div", { class: "h-scrim", onpointerdown: (event) => event.target === scrim && done() }, box);
    function done() {
      scrim.remove();
      if (open === done) open = null;
      // the button may have been made anew meanwhile: the one of the same name stands for it
      const opener = back?.isConnected ? back : document.querySelector(`[data-testid="${back?.dataset?.testid}"]`);
      opener?.focus({ preventScroll: true });
    }
    document.body.append(scrim);
    open = done;
    (box.querySelector("[autofocus]") || box).focus({ preventScroll: true });
    return done;
  }

  function close() {
    open?.();
  }

  class Toasts extends LiveElement {
    show(message, sign = "info") {
      const note = el("div", { class: "h-toast" }, icon(sign, "m"), el("span", {}, message));
      this.append(note);
      while (this.children.length > 3) this.firstElementChild.remove();
      setTimeout(() => note.remove(), TOAST_MS);
    }
  }

  const toast = (message, sign) => document.querySelector("hl-toasts")?.show(message, sign);

  // Escape is spent on the sheet: the screen beneath must not take it for its own
  window.addEventListener("keydown", (event) => event.key === "Escape" && open && (event.preventDefault(), close()));
  define("hl-toasts", Toasts);
  Object.assign(HL, { sheet, closeSheet: close, toast });
})();
