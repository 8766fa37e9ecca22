// What can be asked of the robots that are chosen: pause at once, return home by one slide, missions, a group, a hand-over.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement } = HL;
  const READY = ["validated"];
  const VIEWER = { pause: "Pausing needs the operator role.", return_home: "Return home needs the operator role.", send_mission: "Sending needs the operator role." };

  const ids = () => HL.fleet.picked().map((one) => one.id);
  const several = (n) => (n === 1 ? "1 robot" : `${n} robots`);

  async function pause(robots = ids()) {
    if (!robots.length) return;
    HL.fleetOrders.show({ title: `Pause ${several(robots.length)}`, results: await HL.fleetOrders.act("pause", robots), again: pause });
  }

  // one slide that names them all, with what stands against it known before
  function home(robots = ids()) {
    if (!robots.length) return;
    const rows = robots.map((id) => new HomeRow(id));
    const slide = new HL.Slide({
      hook: "fleet-home", icon: "home", label: robots.length === 1 ? "Slide to send it home" : `Slide to send ${robots.length} home`, line: "They drive by themselves. Check their ways",
      seen: () => presses(robots),
      act: async () => {
        const results = await HL.fleetOrders.act("return_home", robots);
        const taken = results.filter((one) => one.outcome === "accepted").length;
        HL.fleetOrders.show({ title: `Return home: ${several(robots.length)}`, results, again: home });
        return { outcome: taken === results.length ? "accepted" : "rejected", text: `${taken} of ${results.length}` };
      },
    });
    const list = el("ul", { class: "f-results", "data-testid": "fleet-home-names" }, ...rows.map((row) => row.node));
    const follow = () => {
      if (!slide.node.isConnected) return HL.fleet.listeners.delete(follow) && window.removeEventListener("headland:stop", follow);
      rows.forEach((row) => row.paint());
      return slide.allow(""); // lets go if anybody stopped one of them meanwhile
    };
    HL.fleet.listeners.add(follow);
    window.addEventListener("headland:stop", follow);
    HL.sheet({ title: `Return home: ${several(robots.length)}`, hook: "fleet-home-sheet", body: [list, slide.node], buttons: [["Cancel", (close) => (slide.drop(), close())]] });
  }

  // which presses of STOP hold one of these robots
  const presses = (robots) => (HL.fleet.stop?.steps ?? []).filter((step) => robots.includes(step.robot)).map((step) => `${step.robot} ${step.stop_id}`).sort().join();

  class HomeRow {
    constructor(id) {
      this.id = id;
      this.sign = icon("home", "m");
      this.why = el("span", { class: "h-t14" });
      this.node = el("li", { class: "h-row" }, this.sign, el("span", { class: "h-col" }, el("b", { class: "h-t16" }, HL.fleet.name(id)), this.why));
      this.paint();
    }
    paint() {
      const why = obstacle(this.id);
      attr(this.node, "data-state", why ? "refused" : null);
      text(this.sign, why ? "warning" : "home");
      text(this.why, why);
      attr(this.why, "hidden", !why);
    }
  }

  // what is known now; the robot and the console judge again in the moment of the order
  function obstacle(id) {
    const { robot, verdict } = HL.fleet.item(id) ?? {};
    if (!robot) return "It is not there any more";
    if (robot.is_registered === false) return "New. An admin must accept it first";
    if (verdict.isLost) return "No link. It will not hear this";
    if (robot.mode === "stopped" || presses([id])) return "Reset the stop first";
    return robot.mode === "manual" ? "Driven by hand" : "";
  }

  async function send(robots = ids()) {
    const answer = await HL.port.api("GET", "/missions");
    if (!answer.ok) return HL.toast(`Missions did not load: ${answer.text}`, "cloud_off");
    const missions = HL.records.list(answer, "missions").filter((one) => READY.includes(one.status));
    const rows = robots.map((id) => {
      const fitting = missions.filter((one) => !one.robot_id || one.robot_id === id);
      const select = el("select", { class: "h-select", "data-testid": `fleet-mission-${id}`, "aria-label": `Mission for ${HL.fleet.name(id)}` }, el("option", { value: "" }, fitting.length ? "No mission" : "No mission is ready for it"), ...fitting.map((one) => el("option", { value: one.id }, `${one.name}, ${one.field_name}`)));
      const own = fitting.find((one) => one.robot_id === id);
      if (own) select.value = own.id;
      return { id, select };
    });
    const go = async (close) => {
      const pairs = rows.filter((row) => row.select.value).map((row) => ({ robot: row.id, mission_id: row.select.value }));
      if (!pairs.length) return HL.toast("Choose a mission first.", "info");
      close();
      HL.toast(`Sending to ${several(pairs.length)}`, "hourglass_top");
      const results = await HL.fleetOrders.order("/fleet/mission", { pairs }, pairs.map((one) => one.robot), 15000 * pairs.length);
      return HL.fleetOrders.show({ title: `Send mission: ${several(pairs.length)}`, results, again: send });
    };
    return HL.sheet({
      title: `Send mission: ${several(robots.length)}`, hook: "fleet-mission-sheet",
      body: [el("p", { class: "h-2 h-t16" }, "Sending does not move the robot. One mission goes to one robot."), el("div", { class: "f-pairs" }, ...rows.map((row) => el("label", { class: "h-field" }, HL.fleet.name(row.id), row.select)))],
      buttons: [["Cancel", (close) => close()], ["Send", go, true]],
    });
  }

  function group(robots = ids()) {
    const name = el("input", { class: "h-input", maxlength: "80", "aria-label": "Name of the group", "data-testid": "fleet-group-name", autofocus: true });
    const said = el("span", { class: "h-error", role: "alert" });
    const go = async (close) => {
      if (!name.value.trim()) return text(said, "Give the group a name.");
      const same = HL.fleet.groups.find((one) => one.name === name.value.trim());
      const answer = await HL.port.api(same ? "PUT" : "POST", `/fleet/groups${same ? `/${same.id}` : ""}`, { name: name.value.trim(), robots });
      if (!answer.ok) return text(said, answer.text);
      await HL.fleet.loadGroups();
      HL.toast(`Group ${answer.name}: ${several(robots.length)}`, "group");
      return close();
    };
    HL.sheet({ title: `Save ${several(robots.length)} as a group`, hook: "fleet-group-sheet", body: [el("p", { class: "h-2 h-t16" }, robots.map(HL.fleet.name).join(", ")), el("label", { class: "h-field" }, "Name. An existing group of this name is replaced.", name), said], buttons: [["Cancel", (close) => close()], ["Save", go, true]] });
  }

  const ACTS = [
    ["pause", "pause", "Pause", pause, "pause", "pri"],
    ["home", "home", "Return home", home, "return_home", ""],
    ["mission", "route", "Send mission", send, "send_mission", ""],
    ["duty", "badge", "Hand over", (robots) => HL.fleetDuty.handOver(robots ?? ids()), "pause", ""],
    ["group", "group", "Save as group", group, "pause", ""],
  ];

  class FleetDock extends LiveElement {
    build() {
      this.count = el("span", { class: "h-t16 h-b h-nw", role: "status", "data-testid": "fleet-chosen" });
      this.buttons = ACTS.map(([key, sign, label, act, right, look]) => {
        const word = el("span", {}, label);
        const node = el("button", { type: "button", class: `h-btn op ${look}`.trim(), "data-testid": `fleet-do-${key}` }, icon(sign, look ? "f" : ""), word);
        node.addEventListener("click", () => (node.getAttribute("aria-disabled") === "true" ? HL.toast(node.dataset.reason, "lock") : act()));
        return { node, word, key, label, right };
      });
      this.clear = el("button", { type: "button", class: "h-btn op q", "data-testid": "fleet-clear", onclick: () => HL.fleet.chooseAll([]) }, "Clear");
      this.acts = el("div", { class: "acts" }, this.count, ...this.buttons.map((one) => one.node), this.clear);
      this.hint = el("span", { class: "h-hint" });
      this.append(this.acts, this.hint);
    }
    paint() {
      const n = HL.fleet.picked().length;
      const total = HL.fleet.items.length;
      attr(this.acts, "hidden", !n);
      attr(this, "data-chosen", n);
      text(this.count, `${n} chosen`);
      const isLost = HL.port.server().silentMs > HL.LOST_MS;
      for (const { node, word, key, label, right } of this.buttons) {
        const why = !HL.fleet.can(right) ? (VIEWER[right] ?? "Needs the operator role.") : isLost && key !== "group" ? "Commands are off until the link is back." : "";
        attr(node, "aria-disabled", why ? "true" : null);
        attr(node, "data-reason", why || null);
        attr(node, "title", why || null);
        text(word, key === "pause" ? `Pause ${n}` : label);
      }
      text(this.hint, `${n ? "" : "Choose robots to act on several. "}Stop one robot from its row menu or Operate. This button stops all ${total || ""}.`.replace(" .", "."));
    }
  }

  HL.fleetActs = { pause, home, send, group };
  HL.FleetDock = FleetDock;
})();
