// Top bar: what this is about, and how well it is heard.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define, words } = HL;

  const MODES = {
    auto: ["dark", "autoplay", "AUTO"],
    manual: ["manual", "sports_esports", "MANUAL"],
    paused: ["line", "pause", "PAUSED"],
    stopped: ["p3", "lock", "STOPPED"],
    idle: ["line", "hourglass_top", "IDLE"],
    fault: ["p2", "warning", "FAULT"],
    "not-confirmed": ["p1", "error", "NOT CONFIRMED"],
    unknown: ["dash", "help", "UNKNOWN"],
  };

  // what the chip claims: a stop that is not confirmed outranks what the robot said last
  function modeOf(robotId) {
    const stop = HL.stops.worst(robotId);
    if (stop?.state === "not-confirmed") return "not-confirmed";
    return HL.port.robot(robotId).mode?.mode ?? "unknown";
  }

  class ModeChip extends LiveElement {
    build() {
      this.sign = icon("help", "m f");
      this.word = el("span");
      this.chip = el("span", { class: "h-chip" }, this.sign, this.word);
      this.state = el("span", { class: "h-t16 h-b h-nw word" });
      this.append(this.chip, this.state);
    }
    paint() {
      attr(this, "hidden", !HL.view.robot);
      if (!HL.view.robot) return;
      const mode = modeOf(HL.view.robot);
      const said = HL.port.robot(HL.view.robot).mode;
      const ageMs = said ? HL.port.age(said.t) : Infinity;
      const isOld = mode !== "not-confirmed" && (ageMs > HL.STALE_MS || HL.linkState() !== "ok");
      const [look, sign, word] = MODES[mode] || MODES.unknown;
      attr(this, "data-state", mode);
      attr(this, "data-age-ms", Number.isFinite(ageMs) ? Math.round(ageMs) : null);
      attr(this.chip, "class", `h-chip ${isOld ? "dash" : look}`);
      text(this.sign, sign);
      text(this.word, word);
      text(this.state, mode === "not-confirmed" ? "" : isOld && said ? `${words.since(ageMs)} ago` : (HL.drive?.isMine() && mode === "manual" ? "You have control" : said?.text ?? ""));
    }
  }

  class MissionName extends LiveElement {
    paint() {
      const mission = HL.view.robot ? HL.port.robot(HL.view.robot).mission : null;
      text(this, mission ? [mission.name, mission.field].filter((part, i, all) => part && all.indexOf(part) === i).join(" · ") : "");
    }
  }

  class Title extends LiveElement {
    build() {
      this.main = el("div");
      this.line = el("div", { class: "h-t13 h-2 h-plain" });
      this.append(this.main, this.line);
    }
    paint() {
      attr(this, "hidden", Boolean(HL.view.robot));
      const title = this.dataset.fixed || (HL.view.screen === "operate" ? this.dataset.farm : HL.view.title || this.dataset.farm);
      text(this.main, title);
      const isList = ["fleet", "alarms", "cameras"].includes(HL.view.screen);
      const count = HL.port.ids.size;
      text(this.line, isList ? `${this.dataset.farm}, ${count === 1 ? "1 robot" : `${count} robots`}` : "");
    }
  }

  // the sum an operator waits for: browser to console, and console to robot
  class LinkDelay extends LiveElement {
    build() {
      this.sign = icon("network_cell", "m");
      this.word = el("span");
      this.append(this.sign, this.word);
    }
    paint() {
      const server = HL.port.server();
      const link = HL.view.robot ? HL.port.robot(HL.view.robot).link : null;
      const silentMs = Math.max(server.silentMs, link ? HL.port.age(link.t) : 0);
      const isLost = silentMs > HL.LOST_MS;
      const delayMs = HL.port.delayMs(HL.view.robot);
      text(this.sign, isLost ? "signal_disconnected" : "network_cell");
      text(this.word, isLost ? `no link${silentMs < Infinity ? ` ${words.since(silentMs)}` : ""}` : delayMs === null ? "–" : `${Math.round(delayMs)} ms`);
      this.style.color = isLost ? "var(--hl-p2-text)" : "";
      attr(this, "title", server.silentMs > HL.LOST_MS ? "Server lost" : HL.view.robot ? "Delay to the robot" : "Delay to the server");
    }
  }

  class Clock extends LiveElement {
    build() {
      this.main = el("span");
      this.seconds = el("span", { class: "h-2 sec" });
      this.append(this.main, this.seconds);
    }
    paint() {
      const now = new Date();
      text(this.main, words.wall(now));
      text(this.seconds, `:${words.wallSeconds(now).slice(-2)}`);
    }
  }

  define("hl-mode", ModeChip);
  define("hl-mission-name", MissionName);
  define("hl-title", Title);
  define("hl-link", LinkDelay);
  define("hl-clock", Clock);
  Object.assign(HL, { modeOf, MODES });
})();
