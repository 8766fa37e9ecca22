// Views and layers over the picture: each layer with its age or its figures, and a box to hide it.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle } = HL;
  const VIEWS = [["follow", "Follow"], ["top", "Top"], ["side", "Side"], ["head", "Head"], ["free", "Free"]];
  const LAYERS = [
    ["machine", "Machine"], ["planned", "Planned pose"], ["trees", "Trees"], ["scan", "Laser scan"], ["limits", "Joint limits"],
    ["keepout", "Keep-out zone"], ["reach", "Reach of the arm"], ["path", "Path and rows"], ["trail", "Trail"], ["obstacles", "Obstacles"], ["labels", "Labels"], ["parcel", "Parcels"], ["cameras", "Camera views"], ["terrain", "Ground grid"],
  ];
  const HIDDEN = ["terrain", "cameras"];
  const STALE_S = 2;
  const NOT_RECORDED = ["planned", "scan", "limits", "labels", "cameras", "trail"]; // hidden in a replay: known of now only
  const OF_NOW = ["obstacles", "path"];
  const SLOW = { scan: 3, cameras: 3 }; // once a second at most

  const meters = (value) => (value === null || value === undefined ? "" : `${value.toFixed(1)} m`);

  class TwinLayers {
    constructor(link) {
      this.link = link;
      this.view = HL.keep.read("headland.twin.view", "follow");
      this.hidden = new Set(HL.keep.read("headland.twin.hidden", HIDDEN));
      this.views = el("div", { class: "h-seg t-views", role: "group", "aria-label": "View" }, ...VIEWS.map(([key, word]) => el("button", { type: "button", "data-view": key, "data-testid": `twin-view-${key}`, onclick: () => this.choose(key) }, word)));
      this.rows = new Map(LAYERS.map(([key, word]) => [key, this.row(key, word)]));
      this.fold = el("button", { type: "button", class: "h-btn ico t-fold", "data-testid": "twin-layers", "aria-label": "Layers", "aria-expanded": "true", onclick: () => this.unfold(this.list.hidden) }, icon("layers"));
      this.list = el("div", { class: "h-card t-layers", role: "group", "aria-label": "Layers" }, ...[...this.rows.values()].map((row) => row.node));
      this.node = el("div", { class: "t-over" }, el("div", { class: "t-bar" }, this.views, this.fold), this.list);
      this.unfold(matchMedia("(min-width: 900px) and (min-height: 760px)").matches);
      this.choose(VIEWS.some(([key]) => key === this.view) ? this.view : "follow");
      for (const [key] of LAYERS) if (this.hidden.has(key) !== HIDDEN.includes(key)) this.tell(key);
    }

    row(key, word) {
      const box = el("input", { type: "checkbox", checked: !this.hidden.has(key), "data-testid": `twin-layer-${key}`, onchange: () => this.set(key, box.checked) });
      const value = el("span", { class: "t-age h-2 h-t12" });
      return { node: el("label", { class: "t-layer" }, box, el("span", { class: "h-t14" }, word), value), value, box };
    }

    unfold(isOpen) {
      attr(this.list, "hidden", !isOpen);
      attr(this.fold, "aria-expanded", isOpen ? "true" : "false");
      toggle(this.fold, "on", isOpen);
    }

    choose(view) {
      this.view = view;
      HL.keep.write("headland.twin.view", view);
      for (const button of this.views.children) attr(button, "aria-pressed", button.dataset.view === view ? "true" : "false");
      this.link.wish("view", { k: "view", view });
    }

    set(key, isOn) {
      if (isOn) this.hidden.delete(key);
      else this.hidden.add(key);
      HL.keep.write("headland.twin.hidden", [...this.hidden]);
      this.tell(key);
    }

    tell(key) {
      this.link.wish(`layer:${key}`, { k: "layer", name: key, on: !this.hidden.has(key) });
    }

    paint(isPast) {
      const { status } = this.link;
      const said = {
        trees: status?.trees ? `${status.trees.done} / ${status.trees.done + status.trees.failed + status.trees.here}` : "",
        keepout: meters(status?.keep_out_m),
        reach: meters(status?.reach_m),
        ...(status?.is_drawn && (status.ages_s.machine === null || status.unheard?.length) ? { machine: "joints not heard" } : {}),
        ...(status && !this.hidden.has("cameras") && status.ages_s.cameras === null ? { cameras: "no picture" } : {}),
      };
      if (isPast) Object.assign(said, { machine: status.past_unheard?.length ? "joints not recorded" : "recorded", trees: "as then" }, ...NOT_RECORDED.map((key) => ({ [key]: "not recorded" })), ...OF_NOW.map((key) => ({ [key]: "as now" })));
      for (const [key, row] of this.rows) {
        const age = !isPast && ["machine", "planned", "scan", "cameras"].includes(key) ? this.link.ageOf(key) : null;
        text(row.value, said[key] ?? (age === null ? "" : HL.words.age(age * 1000)));
        toggle(row.node, "stale", age !== null && age > (SLOW[key] ?? STALE_S));
        toggle(row.node, "past", isPast && NOT_RECORDED.includes(key));
        attr(row.node, "data-age-ms", age === null ? null : Math.round(age * 1000));
        attr(row.node, "hidden", !this.has(key, status));
      }
    }

    // a layer this robot cannot have takes no room
    has(key, status) {
      if (!status) return true;
      if (key === "planned" || key === "limits") return status.joints.length > 0;
      if (key === "trees" || key === "obstacles") return status.trees !== null && status.trees !== undefined;
      if (key === "cameras") return status.cameras > 0;
      if (key === "reach") return Boolean(status.reach_m);
      return key !== "scan" || status.has_scan;
    }
  }

  HL.TwinLayers = TwinLayers;
})();
