// What can be done with one robot, and one sentence about it; STOP of one robot is here, by the slab's own machinery.
(() => {
  "use strict";
  const { el, icon } = HL;

  const item = (hook, sign, label, act) => el("button", { type: "button", class: "h-btn f-item", "data-testid": hook, onclick: act }, icon(sign, "m"), label);

  function stopButton(id, name, close) {
    const press = (event) => {
      event.preventDefault();
      window.headlandStop?.press({ kind: "robot", id, name });
      close();
    };
    const node = el("button", { type: "button", class: "h-btn f-item f-stop", "data-testid": "fleet-stop-one" }, icon("front_hand", "m f"), `Stop ${name}`);
    node.addEventListener("pointerdown", press); // STOP acts on the way down
    node.addEventListener("click", (event) => event.detail === 0 && press(event)); // keyboard and switches have no pointer
    return node;
  }

  HL.fleetMenu = (id) => {
    const one = HL.fleet.item(id);
    if (!one) return;
    const { robot, verdict } = one;
    const close = HL.closeSheet;
    const isMine = one.duty?.user === HL.fleet.me();
    const isChosen = HL.fleet.chosen.has(id);
    const about = [verdict.head, verdict.line].filter(Boolean).map((part) => part.replace(/\.$/, "")).join(". ");
    HL.fleet.setCurrent(id);
    HL.sheet({
      title: robot.name, hook: "fleet-menu",
      body: [
        el("p", { class: "h-t16 h-b", "data-testid": "fleet-sentence" }, `${about}.`),
        el("p", { class: "h-2 h-t14" }, [robot.mission ? `${robot.mission.name}${robot.field && !robot.mission.name.includes(robot.field) ? `, ${robot.field}` : ""}` : "No mission", HL.fleetDuty.line(id)].join(". ").replace("..", ".")),
        el("div", { class: "f-items" },
          stopButton(id, robot.name, close),
          item("fleet-menu-open", "gamepad", "Operate", () => (close(), HL.go(`/operate/${id}`))),
          item("fleet-menu-show", "my_location", "Show on the map", () => (close(), HL.fleetMap.show(id, true))),
          item("fleet-menu-choose", "check", isChosen ? "Do not choose" : "Choose", () => (HL.fleet.choose(id), close())),
          HL.fleet.can("pause") ? item("fleet-menu-pause", "pause", "Pause", () => (close(), HL.fleetActs.pause([id]))) : "",
          HL.fleet.can("pause") && !isMine ? item("fleet-menu-take", "badge", "I am responsible", () => (close(), HL.fleetDuty.take([id]))) : "",
          HL.fleet.can("pause") ? item("fleet-menu-duty", "group", "Hand over", () => (close(), HL.fleetDuty.handOver([id]))) : "",
          HL.fleet.can("pause") && HL.fleetDuty.canWithdraw(id) ? item("fleet-menu-withdraw", "undo", "Withdraw the offer", () => (close(), HL.fleetDuty.withdraw([id]))) : "",
          isMine ? item("fleet-menu-release", "logout", "Not responsible any more", () => (close(), HL.fleetDuty.release([id]))) : ""),
      ],
      buttons: [["Close", (done) => done()]],
    });
  };
})();
