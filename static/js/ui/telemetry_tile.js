// One number, its normal band, its age and one line of meaning.
(() => {
  "use strict";
  const { el, icon, alarm, text, attr, style, toggle, LiveElement, define, words } = HL;
  const LATE_MS = 1000;

  // fresh | late | stale | missing; streams slower than 2 Hz declare their period
  function freshness(entry, ageMs) {
    if (!entry || entry.missing || entry.t === null || entry.t === undefined) return "missing";
    const p = entry.period_ms || 0;
    if (ageMs > (p > 500 ? 3 * p : HL.STALE_MS)) return "stale";
    return ageMs > (p > 500 ? 1.5 * p : LATE_MS) ? "late" : "fresh";
  }

  class Tile extends LiveElement {
    build() {
      this.glyph = el("span", { hidden: true });
      this.name = el("span", { class: "h-ell" });
      this.age = el("span");
      this.figure = el("span");
      this.unit = el("small");
      this.band = el("span", { class: "ok" });
      this.pointer = el("span", { class: "ptr" });
      this.bar = el("div", { class: "h-bar", "aria-hidden": "true" }, this.band, this.pointer);
      this.line = el("div", { class: "sub" });
      this.append(
        el("div", { class: "lab" }, el("span", { class: "name" }, this.glyph, this.name), el("span", { class: "h-age" }, icon("schedule", "s"), this.age)),
        el("div", { class: "val" }, this.figure, this.unit),
        this.bar,
        this.line,
      );
    }
    paint() {
      const entry = (HL.port.robot(HL.view.robot).tiles || []).find((one) => one.key === this.dataset.key);
      const ageMs = entry ? HL.port.age(entry.t) : Infinity;
      const state = freshness(entry, ageMs);
      const isGone = state === "missing";
      attr(this, "data-state", state);
      attr(this, "data-value", isGone || entry.value === null ? "" : entry.value);
      attr(this, "data-age-ms", Number.isFinite(ageMs) ? Math.round(ageMs) : null);
      toggle(this, "stale", isGone || state === "stale");
      toggle(this, "late", state === "late");
      text(this.name, entry?.label ?? this.dataset.label);
      text(this.age, isGone && !Number.isFinite(ageMs) ? "never" : words.age(ageMs));
      const shown = isGone ? { text: "––", unit: "" } : HL.units.tile(entry);
      text(this.figure, shown.text);
      text(this.unit, shown.unit);
      text(this.line, isGone ? entry?.missing || "not received yet" : HL.units.sentence(entry.sub));
      this.paintLevel(state === "fresh" || state === "late" ? entry.level : null);
      this.paintBar(isGone ? null : entry.bar);
    }
    paintLevel(level) {
      const known = level >= 1 && level <= 3 ? level : null;
      if (known === this.level) return;
      this.level = known;
      attr(this, "data-level", known);
      this.glyph.hidden = !known;
      this.glyph.replaceChildren(known ? alarm(known, 20) : "");
    }
    paintBar(bar) {
      attr(this.bar, "hidden", !bar);
      if (!bar) return;
      style(this.band, "left", `${bar.ok[0]}%`);
      style(this.band, "right", `${100 - bar.ok[1]}%`);
      style(this.pointer, "left", `${Math.min(100, Math.max(0, bar.ptr))}%`);
      const key = (bar.limits || []).join();
      if (key === this.limits) return;
      this.limits = key;
      this.bar.querySelectorAll(".lim").forEach((mark) => mark.remove());
      for (const at of bar.limits || []) {
        const mark = el("span", { class: "lim" });
        mark.style.left = `${at}%`;
        this.bar.append(mark);
      }
    }
  }

  define("hl-tile", Tile);
  Object.assign(HL, { freshness });
})();
