// A mission that a person sent and nobody started keeps a queue waiting: it can be taken off the robot. Nothing moves.
(() => {
  "use strict";
  const { el, icon } = HL;
  const RELOAD_MS = 400;

  async function takeOff(robot, mission) {
    const answer = await HL.port.api("POST", `/queue/robots/${encodeURIComponent(robot)}/take-off`, { mission_id: mission });
    HL.toast(answer.ok ? answer.text : `Not taken off: ${answer.text || "no answer"}`, answer.ok ? "check" : "block");
    return answer;
  }

  // robot: {robot_id, name, holds: {mission_id, name}}; done() when it gives way
  function button(robot, done) {
    if (!robot?.holds || !HL.config.rights.includes("send_mission")) return "";
    const node = el("button", { type: "button", class: "h-btn", "data-testid": `queue-take-off-${robot.robot_id}`, title: `${robot.holds.name} stays stored. Nothing moves.`, onclick: async () => {
      node.disabled = true;
      const answer = await takeOff(robot.robot_id, robot.holds.mission_id);
      node.disabled = false;
      if (answer.ok) done();
    } }, icon("backspace", "m"), `Take ${robot.holds.name} off the robot`);
    return node;
  }

  // on the mission card: asks for the queue once a mission lies on the robot unstarted, and again when queues change
  class CardHold {
    constructor() {
      this.node = el("div", { class: "h-col", hidden: true, "data-testid": "mission-hold" });
      window.headland?.on("event", (event) => event?.kind === "queue" && event.robot === this.robot && this.soon());
    }
    follow(robot, mission) {
      const key = mission?.status === "loaded" ? `${robot} ${mission.id} ${mission.sha256}` : "";
      if (key === this.key) return;
      this.key = key;
      this.robot = robot;
      this.node.hidden = true;
      if (key) this.look();
    }
    soon() {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.look(), RELOAD_MS);
    }
    async look() {
      const { key } = this;
      if (!key) return;
      const queue = await HL.port.api("GET", "/queue");
      if (!queue.ok || key !== this.key) return;
      const waiting = queue.entries.find((one) => one.robot_id === this.robot && one.waiting?.code === "holds_other");
      this.node.hidden = !waiting;
      if (waiting) this.node.replaceChildren(el("span", { class: "h-t14" }, `${waiting.name} waits in the queue for this robot.`), button(queue.robots.find((one) => one.robot_id === this.robot), () => (this.node.hidden = true)));
    }
  }

  HL.queueHold = { button, CardHold };
})();
