// The row of screens in portrait: what people need first, and the rest behind More. On the side everything has room.
(() => {
  "use strict";
  const { el, attr } = HL;
  const LEAST_PX = 66;
  const FIRST = ["operate", "alarms", "fleet", "missions", "maps", "cameras"]; // who cannot do without goes last
  const isRow = () => window.matchMedia("(max-width: 899.98px)").matches;

  /** Which of the names stay in a row of so many places; More takes one when not all do. */
  function staying(names, places) {
    if (names.length <= places) return new Set(names);
    const wanted = [...FIRST.filter((name) => names.includes(name)), ...names.filter((name) => !FIRST.includes(name))];
    return new Set(wanted.slice(0, Math.max(places - 1, 1)));
  }

  function start(rail) {
    const more = el("button", { type: "button", class: "h-nav h-more", "data-testid": "nav-more", "aria-expanded": "false", "aria-label": "More screens", hidden: "" }, el("i", {}), el("span", {}, "More"));
    rail.append(more);
    const links = () => [...rail.querySelectorAll("[data-nav]")];

    function open(isOpen) {
      attr(rail, "data-open", isOpen ? "" : null);
      attr(more, "aria-expanded", String(isOpen));
    }

    function fit() {
      const stays = isRow() ? staying(links().map((link) => link.dataset.nav), Math.floor(rail.clientWidth / LEAST_PX)) : null;
      for (const link of links()) link.classList.toggle("rest", stays !== null && !stays.has(link.dataset.nav));
      attr(more, "hidden", rail.querySelector(".rest") ? null : "");
      if (more.hidden) open(false);
      mark();
    }

    // the screen that is open may be behind More; so may an alarm's count never be
    function mark() {
      attr(more, "aria-current", rail.querySelector(".rest[aria-current]") ? "page" : null);
    }

    more.addEventListener("click", () => open(more.getAttribute("aria-expanded") === "false"));
    rail.addEventListener("click", (event) => event.target.closest("[data-nav]") && open(false));
    document.addEventListener("pointerdown", (event) => !rail.contains(event.target) && open(false), true);
    window.addEventListener("keydown", (event) => event.key === "Escape" && open(false));
    new ResizeObserver(fit).observe(rail);
    return { rail, mark, fit };
  }

  // the screens' scripts come before the frame: the row is found when the first screen shows itself
  let row = null;
  function mark() {
    const rail = document.querySelector(".h-rail");
    if (rail && row?.rail !== rail) (row = start(rail)).fit();
    row?.mark();
  }
  HL.rail = { mark, staying };
})();
