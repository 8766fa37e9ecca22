// Demo only: a sheet that lets something happen to a simulated robot or field sensor, and ends it.
(() => {
  "use strict";
  const { el, icon, text, LiveElement, define } = HL;
  const ASK_MS = 2000;
  const LIMIT_MS = 8000;

  const may = () => HL.config.rights.includes("pause");
  const robots = () =>
    Object.entries(HL.port.fleet())
      .filter(([, robot]) => robot.is_registered !== false)
      .sort((a, b) => a[1].name.localeCompare(b[1].name, undefined, { numeric: true }));

  class Panel extends LiveElement {
    build() {
      this.known = null; // situations, null while loading
      this.stations = []; // field sensors; they begin some seconds after the robots
      this.on = {};
      this.pick = el("select", { "data-testid": "demo-robot", "aria-label": "Robot or sensor", onchange: () => this.draw() });
      this.note = el("p", { class: "h-2 h-t14", role: "status", "data-testid": "demo-note" });
      this.list = el("div", { class: "demo-list" });
      this.append(
        el("p", { class: "h-2 h-t14" }, "These robots and sensors are simulated. What you start here happens to them, as on a real farm, until you end it."),
        el("label", { class: "demo-pick" }, el("span", { class: "h-t14 h-2" }, "Robot or sensor"), this.pick),
        this.note,
        this.list,
      );
    }
    enter() {
      this.isBusy = false;
      this.draw();
      this.ask();
      this.timer = setInterval(() => this.ask(), ASK_MS);
    }
    leave() {
      clearInterval(this.timer);
    }
    async ask() {
      if (this.isAsking) return; // a busy machine answers late; asking again would not make it faster
      this.isAsking = true;
      const answer = await HL.port.api("GET", "/demo/situations", undefined, LIMIT_MS);
      this.isAsking = false;
      if (!this.isConnected) return;
      if (answer.ok && Array.isArray(answer.situations) && answer.now) {
        this.known = answer.situations;
        this.on = answer.now;
        this.stations = Array.isArray(answer.stations) ? answer.stations : [];
        this.problem = "";
      } else {
        this.problem = answer.text || "The server did not answer in time."; // what is shown stays; half an answer is none
      }
      this.draw();
    }
    async play(situation) {
      const id = this.pick.value;
      this.isBusy = true;
      this.draw();
      const kind = this.station(id) ? "stations" : "robots";
      const answer = await HL.port.api("POST", `/demo/${kind}/${encodeURIComponent(id)}/situation`, { situation }, LIMIT_MS);
      this.isBusy = false;
      if (!answer.ok) HL.toast(`Not done: ${answer.text || "the simulator did not answer."}`, "error");
      await this.ask();
    }
    station(id) {
      return this.stations.find((one) => one.id === id);
    }
    fillPick() {
      const all = robots().map(([id, robot]) => [id, robot.name]);
      const sensors = this.stations.map((one) => [one.id, one.name]);
      const key = JSON.stringify([all, sensors]);
      if (key === this.picked) return;
      this.picked = key;
      const chosen = this.pick.value || this.dataset.robot;
      const option = ([id, name]) => el("option", { value: id, selected: id === chosen }, name);
      const group = sensors.length ? [el("optgroup", { label: "Field sensors" }, ...sensors.map(option))] : [];
      this.pick.replaceChildren(...all.map(option), ...group);
    }
    draw() {
      this.fillPick();
      const id = this.pick.value;
      const family = this.station(id)?.kind || HL.port.fleet()[id]?.family;
      const here = (this.known || []).filter((one) => one.families.includes(family));
      text(this.note, this.say(id, here));
      const key = `${id}/${family}/${this.on[id] || ""}/${this.isBusy}/${may()}/${here.length}`;
      if (key === this.drawn) return;
      this.drawn = key;
      const focused = this.list.contains(document.activeElement) ? document.activeElement.dataset.testid : null;
      this.list.replaceChildren(...here.map((one) => this.row(one, this.on[id] === one.id)));
      if (focused) this.list.querySelector(`[data-testid="${focused}"]`)?.focus({ preventScroll: true });
    }
    say(id, here) {
      if (this.problem) return this.problem;
      if (this.known === null) return "Loading …";
      if (!id) return "No robot is heard yet.";
      if (!may()) return "You may look. Starting something needs the operator role.";
      const on = here.find((one) => one.id === this.on[id]);
      return on ? `Now: ${on.title}.` : "Now: nothing special.";
    }
    row(one, isOn) {
      const button = el("button", { type: "button", class: isOn ? "h-btn pri" : "h-btn", "data-testid": `demo-play-${one.id}`, disabled: this.isBusy || !may(), onclick: () => this.play(isOn ? null : one.id) }, isOn ? "End" : "Start");
      return el("div", { class: "demo-row", "data-state": isOn ? "on" : "off", "data-testid": `demo-situation-${one.id}` }, el("span", {}, el("b", {}, one.title), el("small", {}, one.text)), button);
    }
    paint() {
      this.fillPick();
    }
  }

  function dress(href) {
    if (!href || document.querySelector(`link[href="${href}"]`)) return;
    document.head.append(el("link", { rel: "stylesheet", href }));
  }

  class DemoButton extends LiveElement {
    build() {
      dress(this.dataset.style);
      this.append(el("button", { type: "button", class: "h-btn", "data-testid": "demo-open", "aria-haspopup": "dialog", onclick: () => HL.demoPanel(this.dataset.robot) }, icon("smart_toy"), "Demo"));
    }
  }

  function demoPanel(robotId) {
    const panel = document.createElement("hl-demo-panel");
    panel.dataset.robot = robotId || HL.view.robot || "";
    HL.sheet({ title: "Demo: let something happen", body: [panel], buttons: [["Close", (done) => done(), true]], hook: "demo-panel" });
  }

  define("hl-demo-panel", Panel);
  define("hl-demo-button", DemoButton);
  HL.demoPanel = demoPanel;
})();
