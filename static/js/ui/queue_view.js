// The Queue tab: frozen banner, what can be armed, and the queues as timeline or list. REST is asked again on events.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const RELOAD_MS = 400; // moves come close together
  const LOOK_MS = 10000; // sentences with a number in them (wind, battery) grow old without an event
  const LEAST_FOLDED = 4; // fewer empty rows than that are no trouble
  const ABOUT = ["queue", "mission-status", "lease"];

  const LOOKS = { timeline: "Timeline", calendar: "Calendar", list: "List" };

  class QueueView {
    constructor() {
      this.look = HL.keep.read("headland.queue.look", innerWidth < 900 ? "list" : "timeline");
      this.mayEdit = HL.config.rights.includes("send_mission");
      this.body = el("div", { class: "q-body" });
      this.said = el("div");
      this.frozen = el("div");
      this.armButton = el("button", { type: "button", class: "h-btn pri", "data-testid": "queue-arm-open", onclick: () => this.arm() }, icon("autoplay", "m"), "Let it start by itself");
      this.armWhy = el("span", { class: "h-t13 h-2" });
      const windows = el("button", { type: "button", class: "h-btn", "data-testid": "queue-blackouts-open", onclick: () => this.queue && HL.queue.blackouts.list(this.queue, this.mayEdit, () => this.load()) }, icon("timer_off", "m"), "Blackout windows");
      const seg = el("div", { class: "h-seg", role: "group", "aria-label": "Look" }, ...Object.entries(LOOKS).map(([one, word]) => el("button", { type: "button", "data-look": one, "aria-pressed": String(one === this.look), "data-testid": `queue-look-${one}`, onclick: () => this.show(one) }, word)));
      this.seg = seg;
      this.hint = el("p", { class: "h-t13 h-2 q-hint" }, "Drag to reorder, or use ", el("kbd", { class: "h-key" }, "Alt"), " ", el("kbd", { class: "h-key" }, "↑"), ". Tap a mission to change it.");
      this.weather = el("span", { class: "h-t13 h-2", "data-testid": "queue-weather" });
      this.node = el("section", { class: "q-view", "aria-label": "Queue" }, el("div", { class: "q-head" }, el("h2", { class: "h-t22 h-b" }, "Queue"), seg, el("span", { class: "h-sp" }), windows, this.armButton), el("div", { class: "q-sub" }, this.hint, el("span", { class: "h-sp" }), this.weather), this.armWhy, this.said, this.frozen, this.body);
      this.onEvent = (event) => event && ABOUT.includes(event.kind) && this.soon();
    }

    enter() {
      if (this.isOpen) return;
      this.isOpen = true;
      this.unsubscribe = window.headland?.on("event", this.onEvent);
      this.again = setInterval(() => this.load(), LOOK_MS);
      this.load();
    }

    leave() {
      this.isOpen = false;
      this.unsubscribe?.();
      clearInterval(this.again);
      clearTimeout(this.timer);
    }

    soon() {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.load(), RELOAD_MS);
    }

    show(look) {
      this.look = look;
      HL.keep.write("headland.queue.look", look);
      this.drawn = "";
      this.draw();
    }

    async load() {
      if (!this.queue) this.body.replaceChildren(el("div", { class: "h-card h-skeleton", "aria-label": "Loading the queue" }, el("span", { class: "h-t14 h-2" }, "Loading the queue"), el("i"), el("i"), el("i")));
      const answer = await HL.queue.load();
      if (!this.isOpen) return;
      if (!answer.ok) {
        const since = this.loadedAt ? ` What you see is from ${HL.queue.clock(this.loadedAt, this.queue.zone)}.` : "";
        this.said.replaceChildren(el("div", { class: "h-card h-notice", role: "alert", "data-testid": "queue-error" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "The queue did not load"), el("span", { class: "h-2" }, `${answer.text || "Server did not answer in 5 s. STOP still works."}${since}`), el("button", { type: "button", class: "h-btn", onclick: () => this.load() }, icon("refresh", "m"), "Try again")));
        if (!this.queue) this.bare();
        return;
      }
      this.said.replaceChildren();
      this.loadedAt = Date.now();
      this.queue = answer;
      this.draw();
    }

    // nothing is known: nothing to order, and nothing to arm
    bare() {
      this.body.replaceChildren();
      attr(this.armButton, "disabled", true);
      attr(this.hint, "hidden", true);
    }

    // a drag or an armed slide is not torn out of a hand by news
    isBusy() {
      return Boolean(this.node.querySelector(".moving, .h-slide[data-state=armed]"));
    }

    draw() {
      const { queue } = this;
      if (!queue || this.isBusy()) return;
      for (const one of this.seg.children) attr(one, "aria-pressed", String(one.dataset.look === this.look));
      const refusal = HL.queue.arm.refusal(queue);
      attr(this.armButton, "disabled", Boolean(refusal));
      text(this.armWhy, queue.frozen ? "" : refusal);
      attr(this.hint, "hidden", !this.mayEdit || !queue.entries.length || this.look === "calendar");
      text(this.weather, `${zoneWords(queue.zone)}${weatherWords(queue)}`);
      // the banner keeps its slide and the reason that was tapped
      const frozen = queue.frozen ? `${queue.frozen.by}${queue.frozen.utc}` : "";
      if (frozen !== this.frozenKey) {
        this.frozenKey = frozen;
        this.frozen.replaceChildren(...[HL.queue.arm.frozen(queue, () => this.load())].filter(Boolean));
      }
      const focus = document.activeElement?.closest?.("[data-testid^=queue-]")?.dataset.testid;
      if (!queue.robots.length) this.body.replaceChildren(HL.records.empty("No robots yet", "Accept a robot under Admin, Robots."));
      else if (!queue.entries.length && !queue.ended.some((one) => one.started_utc) && this.look === "list") this.body.replaceChildren(this.nothing());
      else this.body.replaceChildren(...this.parts(queue), queue.entries.length ? "" : this.nothing());
      if (focus) this.body.querySelector(`[data-testid="${focus}"]`)?.focus({ preventScroll: true });
    }

    // robots that have something to show, and the others behind one line, so that nobody scrolls past empty rows
    parts(queue) {
      const draw = (robots) => HL.queue[this.look]({ ...queue, robots }, this.actions());
      const [busy, idle] = HL.queue.split(queue);
      if (this.look === "calendar") return [draw([...busy, ...idle])];
      if (!busy.length || idle.length < LEAST_FOLDED) return [draw([...busy, ...idle])];
      const fold = el("details", { class: "q-idle", "data-testid": "queue-idle", open: Boolean(this.isIdleOpen), ontoggle: () => (this.isIdleOpen = fold.open) }, el("summary", { class: "h-btn" }, `${idle.length} robots with nothing in the queue`), draw(idle));
      return [draw(busy), fold];
    }

    nothing() {
      return el("div", { class: "h-card h-notice", "data-testid": "queue-empty" }, el("b", { class: "h-t18 h-b" }, "Nothing in the queue"), el("span", { class: "h-2" }, this.mayEdit ? "Open a mission in the list and add it to the queue." : "You can watch the queue. Changing it needs the operator or planner role."));
    }

    actions() {
      return {
        mayEdit: this.mayEdit,
        open: (entry) => HL.queue.open(entry, this.queue, this.mayEdit, { move: (one, by) => (HL.closeSheet(), this.shift(one, by)), changed: () => this.load() }),
        move: (entry, index) => this.move(entry, index),
        shift: (entry, by) => this.shift(entry, by),
        changed: () => this.load(),
        redraw: () => this.draw(),
        disarm: (robot) => HL.queue.arm.disarm([robot.robot_id], () => this.load()),
      };
    }

    arm() {
      if (this.queue) HL.queue.arm.sheet(this.queue, () => this.load());
    }

    fellows(entry) {
      return this.queue.entries.filter((one) => one.robot_id === entry.robot_id && !HL.queue.isFixed(one));
    }

    shift(entry, by) {
      const at = this.fellows(entry).findIndex((one) => one.id === entry.id);
      if (at >= 0) this.move(entry, at + by);
    }

    // to this place among those that can be moved
    async move(entry, index) {
      const fellows = this.fellows(entry);
      const others = fellows.filter((one) => one.id !== entry.id);
      if (index < 0 || index > others.length || fellows[index]?.id === entry.id) return this.draw();
      const answer = await HL.port.api("POST", `/queue/entries/${entry.id}/move`, { before: others[index]?.id ?? null });
      if (!answer.ok) HL.toast(`Not moved: ${HL.queue.failed(answer)}`, "block");
      return this.load();
    }
  }

  // whose clock, where this tablet's is another one
  function zoneWords(zone) {
    const now = Date.now();
    const mine = Intl.DateTimeFormat().resolvedOptions().timeZone;
    return HL.queue.clock(now, zone) === HL.queue.clock(now, mine) ? "" : `Times of ${HL.queue.zoneName(zone)}. `;
  }

  function weatherWords({ weather, zone }) {
    if (!weather) return "No weather data. Rain and wind rules wait.";
    const parts = [weather.rain_mm_h === null ? "" : `rain ${weather.rain_mm_h.toFixed(1)} mm/h`, weather.wind_mps === null ? "" : `wind ${weather.wind_mps.toFixed(1)} m/s`].filter(Boolean).join(", ");
    const isOld = Date.now() - Date.parse(weather.utc) > 900e3;
    return `${weather.station} ${HL.queue.when(Date.parse(weather.utc), zone)}: ${parts}${isOld ? ". Too old: rain and wind rules wait." : ""}`;
  }

  HL.QueueView = QueueView;
})();
