// Runs before the first paint: theme and density, so that nothing flashes or jumps. And it watches that the page comes
// to life: on a poor radio a script may be lost, and nobody should have to guess why a screen stays empty.
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

  const LATE_MS = 8000; // after everything was fetched; a screen takes a second
  const AGAIN_S = [2, 5, 15, 30];
  const TRIES_KEY = "headland.load_tries";
  const isAlive = () => Boolean(document.querySelector(".h-app"));
  function tries(count) {
    try {
      if (count === undefined) return Number(sessionStorage.getItem(TRIES_KEY)) || 0;
      sessionStorage.setItem(TRIES_KEY, count);
    } catch {
      // without a store it tries at the first pace for ever
    }
    return 0;
  }
  function tell() {
    if (isAlive() || document.getElementById("h-unloaded")) return;
    const count = tries();
    let left = AGAIN_S[Math.min(count, AGAIN_S.length - 1)];
    const again = () => (tries(count + 1), location.reload());
    const note = Object.assign(document.createElement("div"), { id: "h-unloaded", className: "h-card" });
    const line = document.createElement("p");
    const button = Object.assign(document.createElement("button"), { type: "button", className: "h-btn", textContent: "Load again now" });
    note.setAttribute("role", "alert");
    button.addEventListener("click", again);
    note.append(line, button);
    const say = () => {
      const stop = window.headlandStop ? "STOP has a way of its own and shows below whether it works." : "STOP did not load either: use the button on the robot.";
      line.textContent = `This screen did not load completely. ${stop} Loading again in ${left} s.`;
    };
    say();
    document.body.append(note);
    const timer = setInterval(() => {
      if (isAlive()) return void (clearInterval(timer), note.remove(), tries(0));
      left -= 1;
      if (left <= 0) again();
      else say();
    }, 1000);
  }
  // what is lost later is told by the screen that asked for it
  const lost = () => setTimeout(() => tell(), document.readyState === "complete" ? 0 : 1000);
  const watch = (event) => isAlive() || !(event.target === window || event.target.tagName === "SCRIPT") || lost();
  addEventListener("error", watch, true);
  addEventListener("load", () => setTimeout(() => (isAlive() ? (tries(0), removeEventListener("error", watch, true)) : tell()), LATE_MS));
})();
