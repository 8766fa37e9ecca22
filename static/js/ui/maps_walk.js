// Walking an edge: a robot is led around the field, its positions become the outline of a parcel.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const STEP_M = 0.5; // closer positions tell nothing new at walking speed
  const STRAY_M = 0.1; // corners nearer than this to a straight edge are left out
  const LEAST_M2 = 1;
  const STALE_MS = 2000;
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
    // act: {finished(ring, accuracyM, robotName)}
    constructor(act) {
      this.act = act;
      this.points = [];
      this.isOn = false;
      this.robot = el("select", { class: "h-select", "aria-label": "Robot", "data-testid": "walk-robot" });
      this.facts = el("div", { class: "h-t16 h-b", role: "status", "data-testid": "walk-facts" });
      this.note = el("div", { class: "h-t13 h-2" });
      this.track = document.createElementNS(NS, "polyline");
      this.picture = document.createElementNS(NS, "svg");
      this.picture.setAttribute("class", "m-track");
      this.picture.append(this.track);
      const button = (hook, word, run, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick: run }, word);
      this.start = button("walk-start", "Start", () => this.begin(), "pri");
      this.finish = button("walk-finish", "Finish", () => this.end(), "pri");
      this.cancel = button("walk-cancel", "Cancel", () => this.close());
      this.node = el("section", { class: "h-card m-walk", hidden: true, "data-testid": "walk", "aria-label": "Walk the edge" }, el("h3", { class: "h-t16 h-b h-row" }, icon("my_location", "m"), "Walk the edge"), this.robot, this.facts, this.picture, this.note, el("div", { class: "h-row" }, this.start, this.finish, el("span", { class: "h-sp" }), this.cancel));
    }

    open() {
      const robots = Object.entries(HL.port.fleet()).filter(([, one]) => one.is_online && one.lat !== null);
      if (!robots.length) return HL.toast("No robot with a position is heard.", "signal_disconnected");
      this.robot.replaceChildren(...robots.map(([id, one]) => el("option", { value: id }, one.name)));
      this.points = [];
      this.isOn = false;
      attr(this.node, "hidden", null);
      this.robot.onchange = () => this.follow();
      this.follow();
      return this.paint();
    }

    follow() {
      HL.port.follow(this.robot.value);
      this.paint();
    }

    begin() {
      this.isOn = true;
      this.points = [];
      this.worst = 0;
      this.paint();
    }

    // called with each repaint: takes the newest position when it is fresh and far enough from the last
    look() {
      if (this.node.hidden) return;
      const pose = HL.port.robot(this.robot.value).pose;
      const isFresh = pose && HL.port.age(pose.t) < STALE_MS && HL.linkState() !== "server-lost";
      if (this.isOn && isFresh) this.add([pose.lon, pose.lat], pose.accuracy_m);
      this.paint(pose, isFresh);
    }

    add(point, accuracyM) {
      const last = this.points.at(-1);
      if (last) {
        const [x, y] = M.plane(last).flat(point);
        if (Math.hypot(x, y) < STEP_M) return;
      }
      this.points.push(point);
      this.worst = Math.max(this.worst, accuracyM ?? Infinity);
    }

    paint(pose = null, isFresh = false) {
      const name = HL.port.fleet()[this.robot.value]?.name ?? "The robot";
      attr(this.robot, "disabled", this.isOn);
      attr(this.start, "hidden", this.isOn);
      attr(this.start, "disabled", !isFresh);
      attr(this.finish, "hidden", !this.isOn);
      attr(this.finish, "disabled", this.points.length < 3);
      attr(this.node, "data-value", this.points.length);
      text(this.facts, !isFresh ? `${name} gives no position now` : `${this.isOn ? `${M.count(this.points.length, "point")}, ` : ""}${cm(pose.accuracy_m)}`);
      text(this.note, this.isOn ? (this.worst > STRAY_M ? `Worst so far ${Number.isFinite(this.worst) ? cm(this.worst) : "not known"}. Wait for RTK where it matters.` : "Lead it once around. The last point joins the first.") : "The middle of the robot is recorded. Somebody drives it around the edge.");
      this.draw();
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

    end() {
      const { flat } = M.plane(this.points[0]);
      const isBack = (point) => Math.hypot(...flat(point)) < STEP_M;
      while (this.points.length > 1 && isBack(this.points.at(-1))) this.points.pop(); // who comes back to the start stands on its first corner
      const kept = corners(this.points.map(flat), STRAY_M).map((i) => this.points[i]);
      const ring = [...kept, kept[0]];
      const area = M.areaM2({ geometry: { type: "Polygon", coordinates: [ring] } });
      if (kept.length < 3 || area < LEAST_M2) return HL.toast("These points enclose no field yet.", "block");
      const accuracy = Number.isFinite(this.worst) ? this.worst : null;
      this.act.finished(ring, accuracy, HL.port.fleet()[this.robot.value]?.name ?? this.robot.value);
      return this.close();
    }

    close() {
      this.isOn = false;
      attr(this.node, "hidden", true);
      HL.port.follow(null);
    }
  }

  HL.maps.Walk = Walk;
})();
