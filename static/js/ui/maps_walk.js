// Walking an edge or a line: a robot is led, or this tablet carried, along it; the positions become a feature of the map.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const STEP_M = 0.5; // closer positions tell nothing new at walking speed
  const STRAY_M = 0.1; // corners nearer than this to a straight edge are left out; never finer than the receiver is
  const LEAST_M2 = 1;
  const LEAST_M = 1;
  const UNKNOWN_M = 5; // a receiver that does not say how good it is, is not believed much
  const MOST_HEARD = 100000; // positions; the server takes no more
  const WEIGH_MS = 20000;
  // what can be walked: its word, whether the last point joins the first
  const WALKED = { parcel: ["Edge of a field", true], obstacle: ["Edge of an obstacle", true], "no-go": ["Edge of a keep-out zone", true], road: ["Road or track", false], rows: ["Guide line", false] };
  const NS = "http://www.w3.org/2000/svg";

  const cm = (m) => (m === null || m === undefined ? "accuracy not known" : m < 1 ? `±${Math.max(1, Math.round(m * 100))} cm` : `±${m.toFixed(1)} m`);

  // Douglas and Peucker on points in metres; gives back the numbers of those kept
  function corners(points, tolerance) {
    const kept = new Set([0, points.length - 1]);
    const stack = [[0, points.length - 1]];
    while (stack.length) {
      const [from, to] = stack.pop();
      const [x, y] = points[from];
      const [dx, dy] = [points[to][0] - x, points[to][1] - y];
      const size = Math.hypot(dx, dy);
      let [far, at] = [tolerance, -1];
      for (let i = from + 1; i < to; i += 1) {
        const [px, py] = [points[i][0] - x, points[i][1] - y];
        const off = size < 1e-9 ? Math.hypot(px, py) : Math.abs(px * dy - py * dx) / size;
        if (off > far) [far, at] = [off, i];
      }
      if (at >= 0) {
        kept.add(at);
        stack.push([from, at], [at, to]);
      }
    }
    return [...kept].sort((a, b) => a - b);
  }

  class Walk {
    // act: {finished(kind, places, accuracyM, name)}: places is a closed ring, or a line
    constructor(act) {
      this.act = act;
      this.points = []; // places apart from each other: the picture
      this.heard = []; // every position, for weighing
      this.isOn = false;
      this.source = null;
      this.robot = el("select", { class: "h-select", "aria-label": "Whose position", "data-testid": "walk-robot" });
      this.what = el("select", { class: "h-select", "aria-label": "What is walked", "data-testid": "walk-what", onchange: () => this.paint() }, ...Object.entries(WALKED).map(([kind, [word]]) => el("option", { value: kind }, word)));
      this.facts = el("div", { class: "h-t16 h-b", role: "status", "data-testid": "walk-facts" });
      this.note = el("div", { class: "h-t13 h-2", "data-testid": "walk-note" });
      this.track = document.createElementNS(NS, "polyline");
      this.picture = document.createElementNS(NS, "svg");
      this.picture.setAttribute("class", "m-track");
      this.picture.append(this.track);
      const button = (hook, word, run, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick: run }, word);
      this.start = button("walk-start", "Start", () => this.begin(), "pri");
      this.finish = button("walk-finish", "Finish", () => this.end(), "pri");
      this.cancel = button("walk-cancel", "Cancel", () => this.close());
      this.node = el("section", { class: "h-card m-walk", hidden: true, "data-testid": "walk", "aria-label": "Walk the edge" }, el("h3", { class: "h-t16 h-b h-row" }, icon("my_location", "m"), "Walk the edge"), this.what, this.robot, this.facts, this.picture, this.note, el("div", { class: "h-row" }, this.start, this.finish, el("span", { class: "h-sp" }), this.cancel));
    }

    open() {
      const robots = Object.entries(HL.port.fleet()).filter(([, one]) => one.is_online && one.has_place).sort(([, a], [, b]) => (a.family === "uav") - (b.family === "uav")); // an edge is walked, seldom flown
      this.names = new Map([...robots.map(([id, one]) => [id, one.name]), [M.TABLET, "This tablet"]]);
      this.robot.replaceChildren(...[...this.names].map(([id, name]) => el("option", { value: id }, name)));
      this.points = [];
      this.heard = [];
      this.isOn = false;
      attr(this.node, "hidden", null);
      this.robot.onchange = () => this.listen();
      this.listen();
    }

    get isClosed() {
      return WALKED[this.what.value][1];
    }

    get name() {
      return this.names?.get(this.robot.value) ?? "The robot";
    }

    listen() {
      this.source?.stop();
      this.source = this.robot.value === M.TABLET ? new M.TabletReceiver() : new M.RobotReceiver(this.robot.value);
      this.source.start();
      this.paint();
    }

    begin() {
      this.isOn = true;
      this.points = [];
      this.heard = [];
      this.worst = 0;
      this.look();
    }

    // called with each repaint: takes the newest position when it is fresh and new
    look() {
      if (this.node.hidden || !this.source) return;
      const { pose, isFresh } = this.source;
      if (this.isOn && isFresh && pose.at_s !== this.heard.at(-1)?.at_s) this.add(pose);
      this.paint();
    }

    add(pose) {
      if (this.heard.length < MOST_HEARD) this.heard.push({ lon: pose.lon, lat: pose.lat, accuracy_m: pose.accuracy_m ?? UNKNOWN_M, at_s: pose.at_s });
      this.worst = Math.max(this.worst, pose.accuracy_m ?? Infinity);
      const last = this.points.at(-1);
      const point = [pose.lon, pose.lat];
      if (!last || Math.hypot(...M.plane(last).flat(point)) >= STEP_M) this.points.push(point);
    }

    paint() {
      const { source } = this;
      const isFresh = Boolean(source?.isFresh);
      const problem = source?.problem ?? "";
      attr(this.robot, "disabled", this.isOn);
      attr(this.what, "disabled", this.isOn);
      attr(this.start, "hidden", this.isOn);
      attr(this.start, "disabled", !isFresh);
      attr(this.finish, "hidden", !this.isOn);
      attr(this.finish, "disabled", this.points.length < (this.isClosed ? 3 : 2) || this.isWeighing);
      attr(this.node, "data-value", this.points.length);
      text(this.facts, !isFresh ? `${this.name} gives no position now` : `${this.isOn ? `${M.count(this.points.length, "point")}, ` : ""}${cm(source.pose.accuracy_m)}`);
      text(this.note, problem || this.advice());
      this.draw();
    }

    advice() {
      if (this.isOn && this.worst > STRAY_M) return `Worst so far ${Number.isFinite(this.worst) ? cm(this.worst) : "not known"}. Good positions weigh more. Wait for RTK where it matters.`;
      if (this.isOn) return `${this.isClosed ? "Once around. The last point joins the first." : "From end to end."} What strays less than ${cm(Math.max(STRAY_M, this.worst)).slice(1)} from a straight line is left out.`;
      return this.robot.value === M.TABLET ? "Carry the tablet along it, under open sky. Without RTK it is metres off, not centimetres." : "The middle of the robot is recorded. Somebody drives it along.";
    }

    draw() {
      attr(this.picture, "hidden", this.points.length < 2);
      if (this.points.length < 2 || this.drawn === this.points.length) return;
      this.drawn = this.points.length;
      const { flat } = M.plane(this.points[0]);
      const flatted = this.points.map(flat);
      const [xs, ys] = [flatted.map((p) => p[0]), flatted.map((p) => -p[1])];
      const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
      const size = (values) => -least(values.map((v) => -v)) - least(values);
      this.picture.setAttribute("viewBox", `${least(xs) - 2} ${least(ys) - 2} ${size(xs) + 4} ${size(ys) + 4}`);
      this.track.setAttribute("points", flatted.map(([x, y]) => `${x.toFixed(2)},${(-y).toFixed(2)}`).join(" "));
    }

    async end() {
      this.isWeighing = true;
      this.paint();
      const answer = await HL.port.api("POST", "/map/walks", { points: this.heard, is_closed: this.isClosed, tolerance_m: STRAY_M }, WEIGH_MS);
      this.isWeighing = false;
      if (this.node.hidden) return undefined; // given up meanwhile
      this.paint();
      if (answer.ok) return this.done(answer.coordinates, answer.accuracy_m, answer);
      if (answer.status === 422) return HL.toast(answer.text, "block");
      return this.endHere();
    }

    // without the server: every point weighs the same
    endHere() {
      const { flat } = M.plane(this.points[0]);
      const points = [...this.points];
      while (this.isClosed && points.length > 1 && Math.hypot(...flat(points.at(-1))) < STEP_M) points.pop(); // who comes back to the start stands on its first corner
      const kept = corners(points.map(flat), STRAY_M).map((i) => points[i]);
      const accuracyM = Number.isFinite(this.worst) ? this.worst : null;
      if (!this.isClosed) return Math.hypot(...flat(points.at(-1))) < LEAST_M ? HL.toast("These points are no line yet.", "block") : this.done(kept, accuracyM);
      const ring = [...kept, kept[0]];
      const area = M.areaM2({ geometry: { type: "Polygon", coordinates: [ring] } });
      if (kept.length < 3 || area < LEAST_M2) return HL.toast("These points enclose no field yet.", "block");
      return this.done(ring, accuracyM);
    }

    done(places, accuracyM, { tolerance_m: toleranceM = Math.max(STRAY_M, accuracyM ?? 0), kept = this.heard.length, dropped = 0 } = {}) {
      this.act.finished(this.what.value, places, accuracyM, this.name === "This tablet" ? "this tablet" : this.name);
      const corners = M.count(places.length - (this.isClosed ? 1 : 0), this.isClosed ? "corner" : "point");
      HL.toast(`${corners} from ${M.count(kept, "position")}${dropped ? `, ${dropped} not used` : ""}, ${cm(accuracyM)}; strays below ${cm(toleranceM).slice(1)} are left out.`, "check");
      return this.close();
    }

    close() {
      this.isOn = false;
      attr(this.node, "hidden", true);
      this.source?.stop();
      this.source = null;
    }
  }

  HL.maps.Walk = Walk;
})();
