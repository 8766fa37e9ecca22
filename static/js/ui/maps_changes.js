// What was done in this draft, newest first; what is not saved yet stands on top.
(() => {
  "use strict";
  const { el } = HL;
  const SHOWN = 50;

  class Changes {
    constructor() {
      this.list = el("ol", { class: "m-log", "data-testid": "editor-changes" });
      this.node = el("section", { class: "m-changes", "aria-label": "Changes in this draft" }, el("h3", { class: "h-t16 h-b" }, "Changes in this draft"), this.list);
    }
    paint(log, queued) {
      const key = JSON.stringify([log, queued.map((one) => one.id)]);
      if (key === this.key) return;
      this.key = key;
      const me = HL.config.user?.name;
      const row = (label, state, time) => el("li", { "data-state": state }, el("span", { class: "h-ell" }, label), el("span", { class: "h-2 h-t13 h-nw" }, time));
      const saved = (log ?? []).slice(0, SHOWN).map((one) => row(one.is_undone ? `${one.label}, undone` : one.label, one.is_undone ? "undone" : "saved", [one.by && one.by !== me ? one.by : "", HL.words.wall(new Date(one.utc))].filter(Boolean).join(", ")));
      const waiting = queued.toReversed().map((one) => row(one.label, "waiting", "not saved yet"));
      this.list.replaceChildren(...waiting, ...saved);
      if (!saved.length && !waiting.length) this.list.append(el("li", { class: "h-2" }, "None yet"));
    }
  }

  HL.maps.Changes = Changes;
})();
