// Walking an edge or a line: a robot is led, or this tablet carried, along it; the positions become a feature of the map.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const M = HL.maps;
  const R = M.recording;
  const STEP_M = 0.5;
  const STRAY_M = 0.1; // corners nearer than this to a straight edge are left out; never finer than the receiver is
  const LEAST_M2 = 1;
  const LEAST_M = 1;
  const WEIGH_MS = 20000;
  const MOST_TOLD = 6; // gaps, the longest
  // what can be walked: its word, whether the last point joins the first
  const WALKED = { parcel: ["Edge of a field", true], obstacle: ["Edge of an obstacle", true], "no-go": ["Edge of a keep-out zone", true], road: ["Road or track", false], rows: ["Guide line", false] };
  const TABLET_NAME = "This tablet";
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

  // a gap as people say it: how long, how far, and where
  function gapWords({ start, end, seconds, metres }) {
    const time = seconds ? HL.words.since(seconds * 1000) : "";
    const way = end && M.words(M.length(metres));
    return `${[way, time].filter(Boolean).join(" in ")}, from ${M.place(start)}`;
  }

  const svg = (name) => document.createElementNS(NS, name);

  class Walk {
    // act: {finished(kind, places, accuracyM, name) -> was it taken}: places is a closed ring, or a line
    constructor(act, farm) {
      this.act = act;
      R.farm = farm;
      this.robot = el("select", { class: "h-select", "aria-label": "Whose position", "data-testid": "walk-robot" });
      this.what = el("select", { class: "h-select", "aria-label": "What is walked", "data-testid": "walk-what", onchange: () => this.paint() }, ...Object.entries(WALKED).map(([kind, [word]]) => el("option", { value: kind }, word)));
      this.facts = el("div", { class: "h-t16 h-b", role: "status", "data-testid": "walk-facts" });
      this.note = el("div", { class: "h-t13 h-2", "data-testid": "walk-note" });
      this.track = svg("path");
      this.bridges = svg("path");
      this.bridges.setAttribute("class", "bridge");
      this.picture = svg("svg");
      this.picture.setAttribute("class", "m-track");
      this.picture.append(this.track, this.bridges);
      const button = (hook, word, run, look = "") => el("button", { type: "button", class: `h-btn ${look}`.trim(), "data-testid": hook, onclick: run }, word);
      this.start = button("walk-start", "Start", () => this.begin(), "pri");
      this.finish = button("walk-finish", "Finish", () => this.end(), "pri");
      this.cancel = button("walk-cancel", "Cancel", () => this.close());
      this.node = el("section", { class: "h-card m-walk", hidden: true, "data-testid": "walk", "aria-label": "Walk the edge" }, el("h3", { class: "h-t16 h-b h-row" }, icon("my_location", "m"), "Walk the edge"), this.what, this.robot, this.facts, this.picture, this.note, el("div", { class: "h-row" }, this.start, this.finish, el("span", { class: "h-sp" }), this.cancel));
    }

    open() {
      const robots = Object.entries(HL.port.fleet()).filter(([, one]) => one.is_online && one.has_place).sort(([, a], [, b]) => (a.family === "uav") - (b.family === "uav") || M.byName(a.name, b.name)); // an edge is walked, seldom flown
      this.names = new Map([...robots.map(([id, one]) => [id, one.name]), [M.TABLET, TABLET_NAME]]);
      if (this.isGoing) this.names.set(R.robot, R.name);
      this.robot.replaceChildren(...[...this.names].map(([id, name]) => el("option", { value: id }, name)));
      if (this.isGoing) [this.robot.value, this.what.value] = [R.robot, R.kind];
      this.robot.onchange = () => this.listen();
      this.drawn = null;
      attr(this.node, "hidden", null);
      if (!R.isOn) this.listen();
      this.paint();
    }

    // a walk that goes on since this screen was left, or that an earlier page left behind
    comeBack() {
      if (this.node.hidden && (R.isOn || R.isPaused || R.recall())) this.open();
    }

    // of the screen, not of the walk: recording goes on
    leave() {
      if (R.isOn) HL.toast(`The walk with ${this.whose} goes on. Come back to Maps to finish it.`, "my_location");
      else R.listen(null);
      attr(this.node, "hidden", true);
    }

    get isGoing() {
      return R.isOn || R.isPaused;
    }

    get isClosed() {
      return WALKED[this.what.value][1];
    }

    get name() {
      return this.names?.get(this.robot.value) ?? "The robot";
    }

    get whose() {
      return this.name === TABLET_NAME ? "this tablet" : this.name;
    }

    listen() {
      R.listen(this.robot.value === M.TABLET ? new M.TabletReceiver() : new M.RobotReceiver(this.robot.value));
      this.paint();
    }

    begin() {
      if (R.isPaused) R.goOn();
      else R.begin({ kind: this.what.value, robot: this.robot.value, name: this.name });
      this.paint();
    }

    // called with each repaint
    look() {
      if (this.node.hidden) return;
      R.look();
      this.paint();
    }

    paint() {
      const { source, points } = R;
      const isFresh = Boolean(source?.isFresh);
      attr(this.robot, "disabled", this.isGoing);
      attr(this.what, "disabled", this.isGoing);
      attr(this.start, "hidden", R.isOn);
      attr(this.start, "disabled", !isFresh);
      text(this.start, R.isPaused ? "Go on" : "Start");
      text(this.cancel, R.isPaused ? "Discard" : "Cancel");
      attr(this.finish, "hidden", !this.isGoing);
      attr(this.finish, "disabled", points.length < (this.isClosed ? 3 : 2) || this.isWeighing);
      attr(this.node, "data-value", points.length);
      attr(this.node, "data-gaps", R.gaps.length);
      text(this.facts, R.isPaused ? `${M.count(points.length, "point")} kept from ${HL.words.day(new Date(R.heardMs))}` : !isFresh ? `${this.name} gives no position now` : `${R.isOn ? `${M.count(points.length, "point")}, ` : ""}${cm(source.pose.accuracy_m)}`);
      text(this.note, source?.problem || this.advice());
      this.draw();
    }

    advice() {
      if (R.isFull) return "This is as long as a walk can be. Finish it.";
      if (R.isPaused) return "Go on where it stopped, or finish with what there is.";
      if (R.isOn && R.gaps.length) return `Not recorded: ${M.count(R.gaps.length, "stretch", "stretches")}, ${M.words(M.length(R.gaps.reduce((sum, one) => sum + one.metres, 0)))}. The edge is straight there (dashed).`;
      if (R.isOn && R.worst > STRAY_M) return `Worst so far ${Number.isFinite(R.worst) ? cm(R.worst) : "not known"}. Good positions weigh more. Wait for RTK where it matters.`;
      if (R.isOn) return `${this.isClosed ? "Once around. The last point joins the first." : "From end to end."} What strays less than ${cm(Math.max(STRAY_M, R.worst)).slice(1)} from a straight line is left out.`;
      return this.robot.value === M.TABLET ? "Carry the tablet along it, under open sky. Without RTK it is metres off, not centimetres." : "The middle of the robot is recorded. Somebody drives it along, from this tablet or another.";
    }

    draw() {
      const { points, breaks } = R;
      attr(this.picture, "hidden", points.length < 2);
      if (points.length < 2 || this.drawn === points.length) return;
      this.drawn = points.length;
      const { flat } = M.plane(points[0]);
      const flatted = points.map(flat);
      const [xs, ys] = [flatted.map((p) => p[0]), flatted.map((p) => -p[1])];
      const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
      const size = (values) => -least(values.map((v) => -v)) - least(values);
      const words = ([x, y]) => `${x.toFixed(2)} ${(-y).toFixed(2)}`;
      this.picture.setAttribute("viewBox", `${least(xs) - 2} ${least(ys) - 2} ${size(xs) + 4} ${size(ys) + 4}`);
      this.track.setAttribute("d", flatted.map((p, i) => `${i && !breaks.has(i) ? "L" : "M"}${words(p)}`).join(""));
      this.bridges.setAttribute("d", [...breaks].filter(Boolean).map((i) => `M${words(flatted[i - 1])}L${words(flatted[i])}`).join(""));
    }

    async end() {
      this.isWeighing = true;
      this.paint();
      const answer = await HL.port.api("POST", "/map/walks", { points: R.heard, is_closed: this.isClosed, tolerance_m: STRAY_M }, WEIGH_MS);
      this.isWeighing = false;
      if (this.node.hidden) return undefined; // given up or left meanwhile
      this.paint();
      if (answer.ok) return this.settle(answer.coordinates, answer.accuracy_m, answer);
      if (answer.status === 422) return HL.toast(answer.text, "block");
      return this.endHere();
    }

    // without the server: every point weighs the same
    endHere() {
      const { flat } = M.plane(R.points[0]);
      const points = [...R.points];
      while (this.isClosed && points.length > 1 && Math.hypot(...flat(points.at(-1))) < STEP_M) points.pop(); // who comes back to the start stands on its first corner
      const kept = corners(points.map(flat), STRAY_M).map((i) => points[i]);
      const accuracyM = Number.isFinite(R.worst) ? R.worst : null;
      if (!this.isClosed) return Math.hypot(...flat(points.at(-1))) < LEAST_M ? HL.toast("These points are no line yet.", "block") : this.settle(kept, accuracyM);
      const ring = [...kept, kept[0]];
      const area = M.areaM2({ geometry: { type: "Polygon", coordinates: [ring] } });
      if (kept.length < 3 || area < LEAST_M2) return HL.toast("These points enclose no field yet.", "block");
      return this.settle(ring, accuracyM);
    }

    // a person says whether an edge is good of which a part was not seen
    settle(places, accuracyM, told = {}) {
      const gaps = [...(told.gaps ?? R.gaps), ...R.ending(this.isClosed)];
      if (!gaps.length) return this.done(places, accuracyM, told);
      const most = gaps.toSorted((a, b) => b.metres - a.metres).slice(0, MOST_TOLD);
      const list = el("ol", { class: "m-log" }, ...most.map((one) => el("li", {}, gapWords(one))), gaps.length > most.length ? el("li", {}, `and ${gaps.length - most.length} shorter`) : "");
      return HL.sheet({
        title: "A part was not recorded",
        hook: "walk-gaps",
        body: [el("p", { class: "h-t16" }, "No position came there. The edge is straight across it."), list],
        buttons: [["Not yet", (close) => close()], ["Take it so", (close) => (close(), this.done(places, accuracyM, told)), true]],
      });
    }

    async done(places, accuracyM, { tolerance_m: toleranceM = Math.max(STRAY_M, accuracyM ?? 0), kept = R.heard.length, dropped = 0 } = {}) {
      if (!(await this.act.finished(this.what.value, places, accuracyM, this.whose))) return; // nothing of it is lost
      const corners = M.count(places.length - (this.isClosed ? 1 : 0), this.isClosed ? "corner" : "point");
      HL.toast(`${corners} from ${M.count(kept, "position")}${dropped ? `, ${dropped} not used` : ""}, ${cm(accuracyM)}; strays below ${cm(toleranceM).slice(1)} are left out.`, "check");
      this.close();
    }

    close() {
      R.end();
      attr(this.node, "hidden", true);
    }
  }

  HL.maps.Walk = Walk;
})();
