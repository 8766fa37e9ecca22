// Alarms as the live lane tells them, their counts in the top bar, and the badge of the rail.
(() => {
  "use strict";
  const { el, alarm, attr, LiveElement, define } = HL;
  const EMPTY = Object.freeze({});
  const OLD_MS = 10000; // five missed rounds of the supervision
  const LEVELS = [1, 2, 3, 4];

  const topic = () => window.headland.state("alarms") || EMPTY;
  const all = () => topic().alarms || EMPTY;
  const summary = () => topic().summary || null;
  const isUnseen = (one) => one.state === "unacknowledged" || one.state === "returned";

  // how old the list is, however it came to be: a supervision that stands still, or a lane that does
  function ageMs() {
    const said = summary();
    return said ? Math.max(HL.port.age(said.checked), HL.port.server().silentMs) : null;
  }
  const isOld = () => (ageMs() ?? 0) > OLD_MS;

  // per priority: how many are active, how many of them nobody has seen
  const counts = () => LEVELS.map((level) => summary()?.counts?.[level] ?? [0, 0]);

  class AlarmCounts extends LiveElement {
    build() {
      this.link = el("a", { href: "/alarms" });
      this.append(this.link);
    }
    paint() {
      const found = counts();
      const state = !summary() ? "loading" : isOld() ? "stale" : "ok";
      attr(this, "data-state", state);
      const key = `${found}/${state}`;
      if (key === this.shown) return;
      this.shown = key;
      const active = LEVELS.filter((level) => found[level - 1][0]);
      attr(this, "data-value", found.map(([count]) => count).join());
      attr(this.link, "aria-label", (state === "stale" ? "Old list. " : "") + (active.length ? `Active alarms: ${active.map((level) => `${found[level - 1][0]} of priority ${level}, ${found[level - 1][1]} not acknowledged`).join("; ")}` : "No active alarms"));
      this.link.replaceChildren(...active.map((level) => el("span", {}, alarm(level, 26, found[level - 1][1] ? "unacknowledged" : "acknowledged"), el("b", {}, found[level - 1][0]))));
      badge(LEVELS.find((level) => found[level - 1][1]) ?? null, active.length > 0);
    }
  }

  function badge(worst, isAny) {
    const link = document.querySelector('[data-nav="alarms"]');
    if (!link) return;
    attr(link, "data-state", worst ? "unacknowledged" : isAny ? "acknowledged" : "none");
    attr(link, "data-value", worst);
    link.querySelector(".h-badge")?.remove();
    if (worst) link.append(el("span", { class: "h-badge" }, alarm(worst, 24, "unacknowledged")));
  }

  // sound, spoken words and the strip on Operate come after the first picture
  async function lateScripts() {
    await HL.port.firstPicture();
    const code = document.querySelector("hl-alarms")?.dataset.code;
    if (code) HL.load(code);
  }

  define("hl-alarms", AlarmCounts);
  HL.alarms = { all, summary, counts, ageMs, isOld, isUnseen };
  if (HL.config.user) lateScripts();
})();
