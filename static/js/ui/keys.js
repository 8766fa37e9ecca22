// Keys from anywhere: g then a letter moves, ? lists. STOP's own keys belong to STOP. Last file: the screens start here.
(() => {
  "use strict";
  const { el } = HL;
  const WAIT_MS = 1500;
  const PLACES = { o: "operate", f: "fleet", t: "twin", m: "maps", i: "missions", a: "alarms", s: "supervisor", c: "cameras", n: "sensors" };
  const LIST = [
    ["Pause", "STOP (also Ctrl + .)"], ["g o", "Operate"], ["g f", "Fleet"], ["g c", "Cameras"], ["g t", "Twin"], ["g m", "Maps"], ["g i", "Missions"], ["g a", "Alarms"], ["g s", "Supervisor"], ["g n", "Sensors"], ["?", "This list"], ["Esc", "Close, let go"],
    ["J K Enter", "Fleet, Cameras: next, before, open"], ["X /", "Fleet: choose, find"], ["Hold Enter 1.5 s", "Confirm a slide"], ["Hold arrows", "Drive, in manual"],
  ];
  let leaderAt = -Infinity;

  const isTyping = (target) => target instanceof HTMLElement && target.closest("input, textarea, select, [contenteditable]");

  function showKeys() {
    HL.sheet({
      title: "Keys",
      hook: "keys-list",
      body: [el("div", { class: "h-col" }, ...LIST.map(([keys, what]) => el("div", { class: "h-row h-t16" }, el("span", { class: "h-key" }, keys), what)))],
      buttons: [["Close", (close) => close(), true]],
    });
  }

  window.addEventListener("keydown", (event) => {
    if (isTyping(event.target) || event.ctrlKey || event.altKey || event.metaKey || !HL.config.user) return;
    if (event.key === "?") return showKeys();
    const isLed = performance.now() - leaderAt < WAIT_MS;
    leaderAt = event.key === "g" ? performance.now() : -Infinity;
    if (isLed && PLACES[event.key]) document.querySelector(`[data-nav="${PLACES[event.key]}"]`)?.click();
    return undefined;
  });

  HL.showKeys = showKeys;
  HL.startScreens();
})();
