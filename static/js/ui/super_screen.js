// The Supervisor screen: chart and durations left, shares, nodes and functions right.
(() => {
  "use strict";
  const { el, LiveElement } = HL;

  class SuperScreen extends LiveElement {
    build() {
      const card = (name, label, ...inside) => el("section", { class: `h-card s-${name}`, "aria-label": label }, ...inside);
      this.append(
        el("div", { class: "s-grid" },
          card("chart", "State", el("hl-super-chart", { "data-testid": "chart-states" })),
          card("gantt", "State durations", el("hl-super-gantt", { "data-testid": "chart-gantt" })),
          card("share", "Time per subsystem", el("hl-super-share", { "data-testid": "chart-time-share" })),
          card("nodes", "Nodes", el("hl-super-nodes", {})),
          card("functions", "What it can do now", el("hl-super-functions", {})),
          el("hl-super-logs", { class: "s-logs" }),
        ),
      );
    }
  }

  HL.superDefine("hl-super", SuperScreen);
})();
