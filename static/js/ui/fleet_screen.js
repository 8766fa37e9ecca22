// The fleet screen comes to life when its style is there; keys: J K next, Enter open, X choose, / find, Esc clear.
(() => {
  "use strict";
  const { el, define } = HL;
  const isTyping = (target) => target instanceof HTMLElement && target.closest("input:not([type=checkbox]), textarea, select, [contenteditable]");
  const list = () => document.querySelector("hl-fleet");

  const KEYS = {
    j: () => list().step(1),
    k: () => list().step(-1),
    x: () => HL.fleet.current && HL.fleet.choose(HL.fleet.current),
    "/": () => document.querySelector('[data-testid="fleet-search"]')?.focus(),
    Enter: (event) => HL.fleet.current && !event.target.closest?.("button, a, [role=button]") && HL.go(`/operate/${HL.fleet.current}`),
    Escape: () => (HL.fleet.chosen.size ? HL.fleet.chooseAll([]) : HL.fleet.setCurrent(null)),
  };

  window.addEventListener("keydown", (event) => {
    if (!list() || HL.view.screen !== "fleet" || event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    if (document.querySelector(".h-scrim")) return; // the sheet has the keys
    if (isTyping(event.target)) {
      if (event.key === "Escape") (HL.fleet.setFilter({ q: "" }), (event.target.value = ""), event.target.blur());
      return;
    }
    const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    if (event.key === "/") event.preventDefault();
    act(event);
  });

  class Fleet extends HL.FleetList {
    build() {
      super.build();
      this.offered = new HL.fleetDuty.Offers(this.offers);
      this.append(el("div", { class: "f-keys h-2 h-t13" }, el("span", { class: "h-key" }, "J"), el("span", { class: "h-key" }, "K"), " next, ", el("span", { class: "h-key" }, "Enter"), " open, ", el("span", { class: "h-key" }, "X"), " choose"));
    }
  }

  // drawn before its style is there, everything would jump
  function styled(href) {
    if (!href || document.querySelector(`link[href="${href}"]`)) return Promise.resolve();
    const link = el("link", { rel: "stylesheet", href });
    document.head.append(link);
    return new Promise((resolve) => (link.onload = link.onerror = resolve));
  }

  styled(document.querySelector("[data-fleet-style]")?.dataset.fleetStyle).then(() => {
    define("hl-fleet", Fleet);
    define("hl-fleet-dock", HL.FleetDock);
    define("hl-fleet-kpis", HL.FleetKpis);
    define("hl-fleet-stop", HL.FleetStop);
    define("hl-fleet-layers", HL.FleetLayers);
    define("hl-wall", HL.Wall);
  });
})();
