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
      const last = path.length - 1;
      this.path.replaceChildren(
        ...path.flatMap((name, i) => (i === last ? [el("span", { class: "leaf h-ell", "data-look": look || null, title: name }, name)] : [el("span", { title: name }, name), icon("chevron_right", "m")])),
      );
    }
  }

  define("hl-state-path", StatePath);
})();
