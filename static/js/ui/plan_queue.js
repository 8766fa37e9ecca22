// Under the picture of a plan, where the screen is high enough: the queue of this robot today, and where the plan would go.
(() => {
  "use strict";
  const { el, icon } = HL;
  const ROOM = "(min-height: 900px) and (min-width: 1200px)";
  const RELOAD_MS = 400;
  const LOOK_MS = 30000;
  const PLAN = "this-plan";

  class QueueStrip {
    // open(): shows the Queue tab
    constructor(open) {
      this.title = el("b", { class: "h-t16 h-ell" });
      this.body = el("div", { class: "q-body" });
      this.node = el("section", { class: "p-queue", "aria-label": "Queue of this robot", "data-testid": "plan-queue-strip" }, el("div", { class: "h-row" }, this.title, el("span", { class: "h-sp" }), el("button", { type: "button", class: "h-btn", "data-testid": "plan-queue-open", onclick: open }, icon("schedule", "m"), "Queue")), this.body);
      this.room = matchMedia(ROOM);
      this.onRoom = () => this.load();
      this.onEvent = (event) => event && ["queue", "mission-status"].includes(event.kind) && this.soon();
    }

    enter() {
      if (this.isOpen) return;
      this.isOpen = true;
      this.room.addEventListener("change", this.onRoom);
      this.unsubscribe = window.headland?.on("event", this.onEvent);
      this.again = setInterval(() => this.load(), LOOK_MS);
    }

    leave() {
      this.isOpen = false;
      this.room.removeEventListener("change", this.onRoom);
      this.unsubscribe?.();
      clearInterval(this.again);
      clearTimeout(this.timer);
    }

    soon() {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.load(), RELOAD_MS);
    }

    // statistics: of the plan that is shown, or null
    follow(robot, statistics) {
      const isOther = robot?.id !== this.robot?.id;
      if (!isOther && statistics === this.statistics) return;
      Object.assign(this, { robot, statistics });
      if (isOther || !this.queue) this.load();
      else this.draw();
    }

    async load() {
      if (!this.isOpen || !this.room.matches || !this.robot) return;
      const answer = await HL.queue.load();
      if (!this.isOpen) return;
      this.problem = answer.ok ? "" : "The queue did not load.";
      if (answer.ok) this.queue = answer;
      this.draw();
    }

    draw() {
      const robot = this.queue?.robots.find((one) => one.robot_id === this.robot?.id);
      this.title.textContent = `Queue of ${this.robot?.name ?? "the robot"}`;
      if (this.problem) return this.body.replaceChildren(el("p", { class: "h-t14 h-2", role: "alert" }, this.problem));
      if (!robot) return this.body.replaceChildren(el("p", { class: "h-t14 h-2" }, this.queue ? "This robot has no queue." : "Loading the queue"));
      const own = (one) => one.robot_id === robot.robot_id;
      const plan = this.statistics ? [{ id: PLAN, robot_id: robot.robot_id, mission_id: PLAN, name: "This plan", status: "draft", state: "open", duration_s: this.statistics.duration_s }] : [];
      const shown = { ...this.queue, robots: [robot], entries: [...this.queue.entries.filter(own), ...plan], ended: this.queue.ended.filter(own) };
      const actions = { mayEdit: false, open: () => {}, disarm: () => {}, changed: () => this.load() };
      return this.body.replaceChildren(HL.queue.timeline(shown, actions));
    }
  }

  HL.planner.QueueStrip = QueueStrip;
})();
