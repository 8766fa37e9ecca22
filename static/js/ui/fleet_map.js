// The map beside the list: it takes marks and words from the list, so that both say the same, and brings its layers.
(() => {
  "use strict";
  const { el, attr, LiveElement } = HL;
  const KEY = "headland.fleet.layers";
  const LAYERS = [["names", "Labels"], ["paths", "Paths"], ["coverage", "Coverage"]];
  let shown = { names: false, paths: false, coverage: false, ...HL.keep.read(KEY, {}) };

  let told = {};
  const map = () => document.querySelector(".f-map .hl-map")?.hlMap ?? null;

  // tell a map that came later what is chosen; cheap when nothing changed
  function tell() {
    const now = map();
    if (!now) return;
    const { items, filter, chosen, current, order, marks } = HL.fleet;
    const isNarrowed = HL.view.screen !== "wall" && HL.fleet.isNarrowed(filter); // a wall hides nobody
    const key = [order, marks, items.length, now.intake.robots.size, current, [...chosen], JSON.stringify(shown), isNarrowed && HL.fleet.looks].join("|");
    if (now.fleet.said && key === told.key && now === told.map) return; // most looks change nothing that the map shows
    told = { key, map: now };
    const verdicts = new Map(items.map((one) => [one.id, one.verdict]));
    const isSeen = isNarrowed ? new Set(HL.fleet.visible().map((one) => one.id)) : null;
    now.setFleet({ verdicts, chosen, current, isSeen: (id) => !isSeen || isSeen.has(id), layers: shown });
  }

  function show(id, isNear = false) {
    map()?.fleet.show?.(id, isNear); // the map may still be loading
  }

  class FleetLayers extends LiveElement {
    build() {
      this.buttons = LAYERS.map(([key, label]) => el("button", { type: "button", "data-testid": `fleet-layer-${key}`, onclick: () => this.turn(key) }, label));
      this.append(el("div", { class: "h-seg", role: "group", "aria-label": "On the map" }, ...this.buttons));
    }
    enter() {
      this.onTap = ({ detail }) => (HL.fleet.setCurrent(detail), HL.fleetMenu(detail));
      window.addEventListener("headland:map-robot", this.onTap);
      HL.fleet.listeners.add(tell);
      this.wait = setInterval(() => map()?.fleet.said || tell(), 500); // a map that came later than the list
    }
    leave() {
      window.removeEventListener("headland:map-robot", this.onTap);
      HL.fleet.listeners.delete(tell);
      clearInterval(this.wait);
    }
    turn(key) {
      shown = { ...shown, [key]: !shown[key] };
      HL.keep.write(KEY, shown);
      tell();
      HL.repaint();
    }
    paint() {
      this.buttons.forEach((button, i) => attr(button, "aria-pressed", String(shown[LAYERS[i][0]])));
    }
  }

  HL.fleetMap = { show };
  HL.FleetLayers = FleetLayers;
})();
