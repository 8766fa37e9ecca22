// Runs before the first paint: theme and density, so that nothing flashes or jumps.
(() => {
  const root = document.documentElement;
  let kept = {};
  try {
    kept = JSON.parse(localStorage.getItem("headland.preferences") || "{}") || {};
  } catch {
    kept = {};
  }
  const desk = matchMedia("(min-width: 1600px) and (pointer: fine)");
  const fit = () => (root.dataset.density = desk.matches ? "desk" : "glove");
  root.dataset.theme = ["day", "night", "sunlight"].includes(kept.theme) ? kept.theme : "day";
  root.lang = "en";
  desk.addEventListener("change", fit);
  fit();
})();
