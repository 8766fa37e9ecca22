// Where the supervisor is: outermost state first, the innermost marked, with its time.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle, LiveElement, define, words } = HL;
  const LOOKS = { manual: "manual", stopped: "p3", "not-confirmed": "p1" };

  class StatePath extends LiveElement {
    build() {
      this.since = el("span", { class: "h-t13 h-b" });
      this.since.style.color = "var(--hl-ink)";
      this.age = el("span");
      this.path = el("div", { class: "h-path" });
      new ResizeObserver(() => ((this.drawn = null), HL.repaint())).observe(this);
      this.addEventListener("click", () => HL.view.robot && HL.go(`/supervisor/${HL.view.robot}`));
      this.addEventListener("keydown", (event) => event.key === "Enter" && this.click());
      for (const [name, value] of [["role", "link"], ["tabindex", "0"], ["title", "Open the supervisor"]]) attr(this, name, value);
      this.append(el("div", { class: "h-h" }, el("span", {}, "Supervisor state"), this.since, el("span", { class: "h-age h-end" }, icon("schedule", "s"), this.age), icon("chevron_right", "s")), this.path);
    }
    paint() {
      const { supervisor } = HL.port.robot(HL.view.robot);
      if (!supervisor) {
        text(this.since, "");
        text(this.age, "never");
        this.draw(["Waiting for first state"], "");
        return;
      }
      const ageMs = HL.port.age(supervisor.t);
      const isOld = ageMs > HL.STALE_MS;
      const mode = HL.modeOf(HL.view.robot);
      toggle(this, "stale", isOld);
      toggle(this, "late", !isOld && ageMs > 1000);
      attr(this, "data-value", supervisor.path.join(" > "));
      attr(this, "data-age-ms", Math.round(ageMs));
      text(this.age, words.age(ageMs));
      text(this.since, isOld ? `${words.since(ageMs)} ago` : `for ${words.clock(HL.port.age(supervisor.since) / 1000)}`);
      this.draw(mode === "not-confirmed" && isOld ? [...supervisor.path.slice(-1), "Unknown"] : supervisor.path, LOOKS[mode] || "");
    }
    draw(path, look) {
      const key = `${path.join("|")}|${look}`;
      if (key === this.drawn) return;
      this.drawn = key;
      const leaf = el("span", { class: "leaf h-ell", "data-look": look || null, title: path.at(-1) }, path.at(-1));
      // outer states that have no room become one sign: what is cut in half tells nothing
      for (let from = 0; from < path.length; from += 1) {
        const outer = path.slice(from, -1).flatMap((name) => [el("span", {}, name), icon("chevron_right", "m")]);
        const hidden = from ? [el("span", { title: path.slice(0, from).join(", ") }, "…"), icon("chevron_right", "m")] : [];
        this.path.replaceChildren(...hidden, ...outer, leaf);
        if (leaf.scrollWidth <= leaf.clientWidth) return;
      }
    }
  }

  define("hl-state-path", StatePath);
})();
