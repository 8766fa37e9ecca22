// Arming by a slide that names robots and expiry; disarming by one press; releasing a frozen queue.
(() => {
  "use strict";
  const { el, icon } = HL;
  const HOURS = [1, 2, 4, 8, 12];
  const REASONS = ["Area is clear", "Checked on site", "Test"];

  const armable = (queue) => queue.robots.filter((robot) => robot.is_unattended_allowed && queue.entries.some((one) => one.robot_id === robot.robot_id && one.is_unattended));

  // why nothing can be armed at all; empty when something can
  function refusal(queue) {
    if (!HL.config.rights.includes("start")) return "Arming needs the operator role.";
    if (queue.frozen) return "The queue is frozen. Release it first.";
    if (!queue.robots.some((one) => one.is_unattended_allowed)) return "No robot may run without a person. An admin can allow it with headland robot unattended.";
    return armable(queue).length ? "" : "Nothing in the queue starts by itself. Open a mission and mark it.";
  }

  function sheet(queue, changed) {
    const robots = armable(queue);
    const boxes = robots.map((robot) => {
      const input = el("input", { type: "checkbox", "data-testid": `queue-arm-${robot.robot_id}` });
      input.checked = robots.length === 1 || !robot.arming;
      const first = queue.entries.filter((one) => one.robot_id === robot.robot_id && one.is_unattended).map((one) => one.name);
      return { robot, input, label: el("label", { class: "h-check q-armrow" }, input, el("span", { class: "h-col" }, el("span", { class: "h-b h-t16" }, robot.name), el("span", { class: "h-t13 h-2" }, first.slice(0, 3).join(", ") + (first.length > 3 ? ` and ${first.length - 3} more` : "")))) };
    });
    let hours = 4;
    const times = el("div", { class: "h-seg q-hours", role: "group", "aria-label": "How long" }, ...HOURS.map((one) => el("button", { type: "button", "data-testid": `queue-hours-${one}`, "aria-pressed": String(one === hours), onclick: (event) => choose(one, event.currentTarget) }, `${one} h`)));
    const until = () => HL.queue.when(Date.now() + hours * 3600e3, queue.zone);
    const chosen = () => boxes.filter((one) => one.input.checked).map((one) => one.robot);
    const slide = new HL.Slide({ hook: "queue-arm", label: "Slide to arm", line: "", goal: "flag", waits: "Waiting for the server", act: () => arm() });
    const words = () => {
      const names = chosen().map((one) => one.name).join(", ");
      const drives = chosen().length === 1 ? "drives off by itself" : "drive off by themselves";
      slide.options.label = names ? `Slide to arm until ${until()}` : "Choose a robot";
      slide.allow(names ? "" : "Choose at least one robot", `${names} ${drives}`);
    };
    const choose = (one, button) => {
      hours = one;
      for (const other of times.children) other.setAttribute("aria-pressed", String(other === button));
      words();
    };
    for (const one of boxes) one.input.addEventListener("change", words);
    async function arm() {
      const wanted = chosen().map((one) => ({ robot_id: one.robot_id, revision: one.revision }));
      const answer = await HL.queue.order("arm", { robots: wanted, duration_s: hours * 3600 });
      if (answer.outcome === "accepted") setTimeout(() => (close(), changed()), 900);
      return answer;
    }
    words();
    const close = HL.sheet({ title: "Let the queue start by itself", hook: "queue-arm-sheet", body: [el("p", { class: "h-t14 h-2" }, "Arms exactly the queue you see. A STOP, a change of the queue, somebody who takes control, or a restart disarms it."), ...boxes.map((one) => one.label), el("div", { class: "h-col" }, el("span", { class: "h-t13 h-b h-2" }, "For how long"), times), slide.node], buttons: [["Leave it", (done) => done()]] });
  }

  async function disarm(robots, changed) {
    const answer = await HL.port.api("POST", "/queue/disarm", { robots });
    HL.toast(answer.ok ? "Disarmed" : `Not disarmed: ${HL.queue.failed(answer)}`, answer.ok ? "check" : "block");
    changed();
  }

  // the banner over a frozen queue, with the slide that releases it; null when it is not frozen
  function frozen(queue, changed) {
    if (!queue.frozen) return null;
    const mayRelease = HL.config.rights.includes("reset");
    let why = "";
    const said = el("div", { class: "h-seg", role: "group", "aria-label": "Reason" }, ...REASONS.map((one) => el("button", { type: "button", "aria-pressed": "false", onclick: (event) => choose(one, event.currentTarget) }, one)));
    const slide = new HL.Slide({ hook: "queue-release", icon: "lock_open", label: "Slide to release the queue", line: "Nothing moves and nothing is armed by it", goal: "lock_open", waits: "Waiting for the server", act: () => release() });
    const choose = (one, button) => {
      why = one;
      for (const other of said.children) other.setAttribute("aria-pressed", String(other === button));
      slide.allow(mayRelease ? "" : "Releasing needs the operator role.");
    };
    async function release() {
      const answer = await HL.queue.order("release", { reason: why });
      if (answer.outcome === "accepted") setTimeout(changed, 900);
      return answer;
    }
    slide.allow(mayRelease ? "Tap a reason first." : "Releasing needs the operator role.");
    const by = queue.frozen.by ? ` by ${queue.frozen.by}` : "";
    return el("section", { class: "h-card q-frozen", role: "alert", "data-testid": "queue-frozen" }, el("div", { class: "h-row" }, icon("lock", "l"), el("div", { class: "h-col" }, el("b", { class: "h-t18" }, "The whole queue is frozen"), el("span", { class: "h-t14" }, `STOP ALL${by} at ${HL.queue.when(Date.parse(queue.frozen.utc), queue.zone)}. Nothing is sent and nothing starts until a person releases it.`))), mayRelease ? said : "", slide.node);
  }

  Object.assign(HL.queue, { arm: { refusal, sheet, disarm, frozen } });
})();
