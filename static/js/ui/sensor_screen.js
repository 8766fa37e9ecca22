// The whole screen: begins and ends the asking, and says what there is to say while there are no stations. Last file.
(() => {
  "use strict";
  const { el, icon, text, attr, define, LiveElement } = HL;
  const LATE_MS = 5000;

  class Blank extends LiveElement {
    build() {
      this.sign = icon("hourglass_top", "l");
      this.head = el("b", { class: "h-t22 h-b" });
      this.line = el("span", { class: "h-t16 h-2" });
      this.how = el("ol", { class: "h-t16 sn-how", hidden: true }, el("li", {}, "Let the station speak to the same MQTT broker as the robots, as docs/protocols/field_sensors.md says. For a trial: headland simulate sensors --broker URL."), el("li", {}, "It appears here by itself as new."), el("li", {}, "A planner accepts it and says which field it stands for. From then on its values count."));
      this.act = el("button", { type: "button", class: "h-btn", onclick: () => HL.sensors.load() }, icon("refresh", "m"), "Try again");
      this.bars = el("div", { class: "h-skeleton sn-skeleton", "aria-hidden": "true" }, ...["100%", "82%", "92%"].map((width) => { const bar = el("i"); bar.style.width = width; return bar; }));
      this.card = el("div", { class: "h-notice h-card", "data-testid": "sensors-notice", role: "status" }, this.sign, this.head, this.line, this.bars, this.how, this.act);
      this.append(this.card);
    }
    enter() {
      HL.sensors.begin();
      HL.sensorMap.begin();
    }
    leave() {
      HL.sensorMap.end();
      HL.sensors.end();
    }

    paint() {
      const said = this.said();
      attr(this, "hidden", !said);
      attr(this.closest(".sn-screen"), "data-look", said ? said.look : "stations");
      if (!said) return;
      text(this.sign, said.sign);
      text(this.head, said.head);
      text(this.line, said.line ?? "");
      attr(this.line, "hidden", !said.line);
      attr(this.how, "hidden", said.look !== "empty");
      attr(this.bars, "hidden", said.look !== "loading");
      attr(this.act, "hidden", said.look !== "failed");
    }

    said() {
      const { found, problem, begun } = HL.sensors;
      if (problem?.status === 403) return { look: "forbidden", sign: "lock", head: "Sensors of this site are not shared with you.", line: problem.text };
      if (found) return found.stations?.length ? null : { look: "empty", sign: "info", head: "No stations. Add one" };
      if (problem) return { look: "failed", sign: "cloud_off", head: "Stations did not load", line: `${problem.text || "The server does not answer."} They are asked for again by themselves. STOP still works.` };
      if (performance.now() - begun > LATE_MS) return { look: "failed", sign: "cloud_off", head: "Stations did not load", line: "The server does not answer yet. STOP still works." };
      const count = HL.sensors.count();
      return { look: "loading", sign: "hourglass_top", head: count ? `Loading ${count} ${count === 1 ? "station" : "stations"}` : "Loading stations" };
    }
  }

  // drawn before its style is there, everything would jump
  const sheet = el("link", { rel: "stylesheet", href: document.querySelector(".sn-screen")?.dataset.screenStyle });
  sheet.onload = () => {
    define("hl-sensors", Blank);
    define("hl-sensor-gate", HL.SensorGate);
    define("hl-sensor-list", HL.SensorList);
    define("hl-sensor-values", HL.SensorValues);
    define("hl-sensor-dock", HL.SensorDock);
  };
  sheet.onerror = () => HL.toast("This screen did not load. Open it again.", "cloud_off");
  document.head.append(sheet);
})();
