// The plan on its field: path, turns, ground worked once, twice or not at all, and time; the robot travels along it.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const NS = "http://www.w3.org/2000/svg";
  const FREE = { left: 20, right: 76, top: 70, bottom: 100 }; // pixels that views, zoom and scrubber stand on
  const NAME_PX = 8; // a letter
  const TIMES = 8; // shades of the time view: more cannot be told apart
  const VIEWS = [["path", "Path"], ["turns", "Turns"], ["overlap", "Overlap"], ["time", "Time"]];

  function svg(tag, props, ...children) {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(props)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }

  const line = (points) => `M${points.map(([x, y]) => `${x.toFixed(2)} ${(-y).toFixed(2)}`).join("L")}`;
  const area = (polygons) => polygons.flatMap((rings) => rings.map((ring) => `${line(ring)}Z`)).join("");

  function bounds(drawing) {
    const points = [...(drawing.places.parcel[0] ?? []), ...drawing.legs.flatMap((leg) => leg.points ?? []), ...(drawing.places.home ? [drawing.places.home] : [])];
    let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
    for (const [x, y] of points) {
      x0 = Math.min(x0, x); x1 = Math.max(x1, x);
      y0 = Math.min(y0, -y); y1 = Math.max(y1, -y);
    }
    return Number.isFinite(x0) ? [x0, y0, x1, y1] : [-50, -50, 50, 50];
  }

  class Picture {
    constructor() {
      this.view = "path";
      this.root = svg("svg", { class: "p-svg", role: "img", "aria-label": "Plan", "data-testid": "plan-picture" });
      this.buttons = VIEWS.map(([key, word]) => el("button", { type: "button", "data-testid": `plan-view-${key}`, "aria-pressed": key === "path" ? "true" : "false", onclick: () => this.show(key) }, word));
      this.sight = new HL.SvgView(this.root, { free: FREE, changed: (px) => this.scaled(px) });
      this.legend = el("div", { class: "p-legend h-t13", hidden: true });
      this.views = el("div", { class: "h-seg p-views", role: "group", "aria-label": "What the picture shows" }, ...this.buttons);
      this.node = el("div", { class: "p-picture" }, this.root, this.views, this.sight.buttons(), this.legend);
    }

    // ground somebody draws: done(outline in degrees); ended() when the pen is put down
    drawArea(done, ended) {
      this.pen ??= this.makePen();
      this.pen.done = (ring) => done(ring.map((point) => this.unflat(point)));
      this.pen.ended = ended;
      this.node.scrollIntoView({ block: "nearest" });
      this.pen.start();
    }

    makePen() {
      const pen = new HL.AreaPen(this.sight, () => {});
      this.node.append(pen.bar);
      return pen;
    }

    // areas: [{outline in degrees, dose, name}], drawn for this plan
    showAreas(areas) {
      this.areas = areas;
      this.overlay?.remove();
      this.overlay = svg("g", {});
      this.names = [];
      if (!this.frame) return;
      for (const { outline, dose, name } of areas) {
        const points = outline.map((place) => this.flat(place));
        const mean = (k) => points.reduce((sum, point) => sum + point[k], 0) / points.length;
        const word = svg("g", { class: "sign" }, svg("text", { "text-anchor": "middle", y: 5 }, name));
        const xs = points.map((point) => point[0]);
        this.names.push({ node: word, x: mean(0), y: mean(1), wide: Math.max(...xs) - Math.min(...xs), least: NAME_PX * name.length });
        this.overlay.append(svg("path", { class: dose === 0 ? "a-area drawn off" : "a-area drawn", d: `${line(points)}Z` }), word);
      }
      this.root.append(this.overlay);
      if (this.sight.px) this.scaled(this.sight.px);
    }

    // the drawing knows one place on earth and the degrees per metre there
    unflat([x, south]) {
      const { xy_m: [x0, y0], lon_lat: [lon, lat], degrees_per_m: [[a, b], [c, d]] } = this.frame;
      const [dx, dy] = [x - x0, -south - y0];
      return [lon + a * dx + b * dy, lat + c * dx + d * dy];
    }

    // metres, y to the north
    flat([lon, lat]) {
      const { xy_m: [x0, y0], lon_lat: [lon0, lat0], degrees_per_m: [[a, b], [c, d]] } = this.frame;
      const [u, v, size] = [lon - lon0, lat - lat0, a * d - b * c];
      return [x0 + (d * u - b * v) / size, y0 + (a * v - c * u) / size];
    }

    // drawing: what the server answers, or only {frame, legs: [], places: {parcel, home}}; path: null without a plan
    draw(drawing, path, statistics) {
      this.pen?.isOn && this.pen.stop();
      this.drawing = drawing;
      this.frame = drawing.frame;
      this.path = path;
      this.statistics = statistics;
      const legs = path ? path.legs : [];
      this.root.replaceChildren(...this.ground(drawing), ...(path ? this.lines(legs) : []), ...this.marks(drawing, legs));
      this.views.hidden = !path;
      this.showAreas(this.areas ?? []);
      this.sight.fit(bounds({ ...drawing, legs }));
      this.show(path ? this.view : "path");
    }

    ground({ places, ground }) {
      const hatch = svg("pattern", { id: "p-hatch", width: 6, height: 6, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" }, svg("rect", { class: "hatch", width: 2, height: 6 }));
      this.hatch = hatch;
      const shown = [
        svg("defs", {}, hatch),
        svg("path", { class: "road", d: area(places.roads ?? []) }),
        svg("path", { class: "parcel", d: area([places.parcel]), "fill-rule": "evenodd" }),
        ...(places.doses ?? []).map((one) => svg("path", { class: one.dose > 0 ? "dose" : "dose off", d: area(one.rings), "fill-rule": "evenodd" })),
        svg("path", { class: "guide", "data-testid": "plan-lines", d: (places.lines ?? []).map(line).join("") }),
        svg("path", { class: "obstacle", d: area(places.obstacles ?? []), "fill-rule": "evenodd" }),
      ];
      const worked = ["worked", "twice", "missed"].map((name) => svg("path", { class: `only overlap ${name}`, "data-testid": `plan-ground-${name}`, d: area(ground?.[name] ?? []), "fill-rule": "evenodd" }));
      return [...shown, svg("g", {}, ...worked)];
    }

    lines(legs) {
      const of = (test) => legs.filter(test).map((leg) => line(leg.points)).join("");
      const isWork = (leg) => leg.kind === "row" || leg.kind === "headland";
      const pivots = legs.filter((leg) => leg.pivot).map((leg) => `${line(leg.points.slice(0, 1))}h0`).join("");
      this.driven = svg("path", { class: "driven", d: legs.map((leg) => line(leg.points)).join("").replaceAll("M", "L").replace("L", "M") });
      const shades = Array.from({ length: TIMES }, (_, k) => svg("path", { class: `only time t${k}`, d: of((leg) => this.shade(leg) === k) }));
      return [
        svg("path", { class: "way", d: of((leg) => leg.kind === "approach" || leg.kind === "exit") }),
        svg("path", { class: "turn", d: of((leg) => leg.kind === "turn") }),
        svg("path", { class: "headland", d: of((leg) => leg.kind === "headland" && leg.on) }),
        svg("path", { class: "row", "data-testid": "plan-rows", d: of((leg) => leg.kind === "row" && leg.on) }),
        svg("path", { class: "idle", d: of((leg) => isWork(leg) && !leg.on) }),
        ...shades,
        svg("path", { class: "only turns", d: of((leg) => leg.kind === "turn") }),
        svg("path", { class: "only turns back", "data-testid": "plan-back", d: of((leg) => leg.back) }),
        svg("path", { class: "only turns pivot", d: pivots }),
        this.driven,
      ];
    }

    shade(leg) {
      return Math.min(TIMES - 1, Math.floor((TIMES * (leg.t[0] + leg.t[1])) / 2 / Math.max(1, this.path.duration)));
    }

    // signs keep their size on the screen whatever the zoom
    marks({ places, machine }, legs) {
      const word = (content) => {
        const node = svg("text", { x: 16, y: 20 });
        node.textContent = content;
        return node;
      };
      this.signs = [];
      const sign = ([x, y], ...shapes) => {
        const node = svg("g", { class: "sign" }, ...shapes);
        this.signs.push({ node, x, y });
        return node;
      };
      const home = places.home ? [sign(places.home, svg("path", { class: "home", d: "M-11 0L0-12L11 0V11H-11Z" }))] : [];
      if (!legs.length) return home;
      const work = legs.filter((leg) => leg.kind === "row" || leg.kind === "headland");
      const start = sign(work[0].points[0], svg("circle", { class: "start", r: 9 }), word("start"));
      const end = sign(work.at(-1).points.at(-1), svg("rect", { class: "end", x: -8, y: -8, width: 16, height: 16 }), word("end"));
      const [front, rear, half] = [machine.base_to_front_m, machine.base_to_front_m - machine.length_m, machine.width_m / 2];
      this.arrow = svg("g", { class: "arrow" }, svg("circle", { r: 15 }), svg("path", { d: "M9 0L-7-7L-3 0L-7 7Z" }));
      this.robot = svg("g", { class: "robot", "data-testid": "plan-robot-outline" }, svg("path", { class: "outline", d: `${line([[rear, -half], [front, -half], [front, half], [rear, half]])}Z` }), this.arrow);
      return [...home, start, end, this.robot];
    }

    show(view) {
      this.view = view;
      this.buttons.forEach((button, k) => attr(button, "aria-pressed", VIEWS[k][0] === view ? "true" : "false"));
      attr(this.root, "data-view", view);
      this.tell();
    }

    // what the colours of a view mean
    tell() {
      const s = this.statistics;
      this.legend.hidden = !s || this.view === "path";
      if (this.legend.hidden) return;
      const percent = (m2) => `${((100 * m2) / Math.max(1, s.area_m2)).toFixed(1)} %`;
      const key = (look, words) => el("span", { class: "h-row" }, el("i", { class: `p-key ${look}` }), words);
      const parts = {
        turns: () => [key("turns", `${s.turns} turns`), ...(s.reversals && !s.pivots ? [] : [key("pivot", s.pivots ? `${s.pivots} on the spot` : "none on the spot")]), ...(s.reversals ? [key("back", "backing up")] : [])],
        overlap: () => [key("worked", `Worked ${percent(s.covered_m2)}`), key("twice", `Twice ${percent(s.overlap_m2)}`), key("missed", `Missed ${percent(s.missed_m2 ?? 0)}`)],
        time: () => ["0:00", el("span", { class: "p-ramp" }, ...Array.from({ length: TIMES }, (_, k) => el("i", { class: `t${k}` }))), HL.words.left(s.duration_s)],
      };
      this.legend.replaceChildren(...parts[this.view]());
    }

    // the robot after t seconds; returns the pose
    place(t) {
      if (!this.path?.legs.length) return null;
      const pose = this.path.at(t);
      this.pose = pose;
      attr(this.robot, "transform", `translate(${pose.x.toFixed(2)} ${(-pose.y).toFixed(2)}) rotate(${((-pose.heading * 180) / Math.PI).toFixed(1)})`);
      attr(this.robot, "data-heading-deg", ((pose.heading * 180) / Math.PI).toFixed(1));
      attr(this.robot, "data-state", pose.isOn ? "on" : "off");
      attr(this.driven, "stroke-dasharray", `${pose.driven.toFixed(1)} ${(this.path.length + 1).toFixed(1)}`);
      this.sight.keep([pose.x, -pose.y]);
      return pose;
    }

    // what keeps its size on the screen whatever the zoom
    scaled(px) {
      this.root.style.setProperty("--px", `${px}px`);
      // rows closer than the screen can show become a tint, not a black field
      this.root.style.setProperty("--row", Math.min(1.3, Math.max(0.15, (0.35 * (this.drawing?.machine?.tool_width_m ?? 3)) / px)).toFixed(2));
      const scale = px.toFixed(4);
      for (const { node, x, y } of [...(this.signs ?? []), ...(this.names ?? [])]) attr(node, "transform", `translate(${x} ${-y}) scale(${scale})`);
      for (const { node, wide, least } of this.names ?? []) node.style.display = wide / px < least ? "none" : ""; // a name wider than its area covers its neighbours
      if (this.arrow) attr(this.arrow, "transform", `scale(${scale})`);
      if (this.hatch) attr(this.hatch, "patternTransform", `rotate(45) scale(${scale})`);
    }

    say(words) {
      text(this.said ??= this.node.appendChild(el("div", { class: "p-said h-card h-row", role: "status" })), words);
      this.said.hidden = !words;
    }
  }

  HL.planner.Picture = Picture;
})();
