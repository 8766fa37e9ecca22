// The banner over every screen: STOP first, then the server, then the robot's link.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define, words } = HL;
  const STALE_MS = 2000;
  const LOST_MS = 3500;

  // ok | stale | robot-lost | server-lost, as test-hooks name them
  function linkState() {
    const server = HL.port.server();
    if (server.silentMs > LOST_MS) return "server-lost";
    const link = HL.view.robot ? HL.port.robot(HL.view.robot).link : null;
    const silentMs = link ? HL.port.age(link.t) : 0;
    if (link && silentMs > LOST_MS) return "robot-lost";
    return Math.max(server.silentMs, silentMs) > STALE_MS ? "stale" : "ok";
  }

  // why no order would be taken now: the console refuses one without a fresh tick, or to a robot not heard for 2 s
  const offline = (robot) => (linkState() === "ok" && window.headland.tick() !== null && HL.port.robot(robot).mode ? "" : "Commands are off until the link is back.");

  const MESSAGES = {
    "server-lost": () => ({
      look: "p2",
      sign: "cloud_off",
      head: `This tablet lost the server for ${words.since(HL.port.server().silentMs)}`,
      line: "Supervised missions pause by themselves; unattended ones go on. STOP has its own path.",
      note: "Reconnecting",
    }),
    "robot-lost": () => ({
      look: "p2",
      sign: "signal_disconnected",
      head: `No link to ${HL.view.name()} ${lostFor(HL.port.age(HL.port.robot(HL.view.robot).link.t))}`,
      line: `All values are old. ${selfPause()} Look before you walk up to it.`,
      note: HL.port.robot(HL.view.robot).link.broker === "down" ? "Broker is down" : "Listening",
    }),
  };

  const lostFor = (ms) => (ms < Infinity ? `for ${words.since(ms)}` : "since the console started");

  function selfPause() {
    const { body, mission } = HL.port.robot(HL.view.robot);
    const figure = mission?.is_supervised === false ? body?.link_lost_s : body?.operator_lost_s;
    return figure ? `It pauses by itself after ${figure} s (figure from its factsheet); not verified.` : "What it does by itself is not known.";
  }

  // what STOP says; where only the robot knows of a latch, what the robot says
  function stopMessage() {
    const said = window.headlandStop?.banner();
    if (said) return { look: said.height > 64 ? `${said.level} big` : said.level, state: said.state, sign: said.icon, head: said.title, line: said.text, time: said.duration, under: said.duration_label };
    const stop = HL.view.robot ? HL.stops.worst(HL.view.robot) : null;
    if (stop?.state !== "standstill") return null;
    const who = stop.by ? `Pressed by ${[stop.by, stop.device].filter(Boolean).join(" on ")}. ` : "";
    return { look: "p3", state: "standstill", sign: "front_hand", head: "Stopped. Standstill confirmed", line: `${who}The robot stays stopped until someone resets it.`, time: words.clock(HL.stops.ageMs(stop) / 1000) };
  }

  // a part of the server that is down, or was a moment ago: the keeper restarts it and everybody is told
  const PARTS = { stop: "STOP process", broker: "message broker", simulator: "simulator", console: "console", media: "process of the 3D twin", cameras: "camera process" };
  const TOLD_MS = 60000;
  const told = new Map(); // part and time of its return -> when this page heard of it; wall clocks are not compared
  let isFirstLook = true;
  function firstTold(part) {
    const key = `${part.name} ${part.last_down.until_utc}`;
    if (!told.has(key)) told.set(key, isFirstLook ? -Infinity : performance.now());
    return told.get(key);
  }
  function partMessage() {
    const info = HL.port.tickInfo();
    if (!info) return null;
    const parts = info.keeper ?? [];
    parts.filter((part) => part.last_down).forEach(firstTold);
    isFirstLook = false;
    const down = parts.find((part) => part.state !== "ok");
    if (down) return { look: "p2", sign: "sync_problem", head: `The ${PARTS[down.name] ?? down.name} is down`, line: down.name === "stop" ? "It is being restarted. Until it is back, STOP goes through the console; know where the machine's button is." : "It is being restarted." };
    const back = parts.find((part) => part.last_down && performance.now() - firstTold(part) < TOLD_MS);
    if (!back) return null;
    const seconds = (Date.parse(back.last_down.until_utc) - Date.parse(back.last_down.from_utc)) / 1000;
    return { look: "quiet", sign: "sync_problem", head: `The ${PARTS[back.name] ?? back.name} was down for ${words.since(seconds * 1000)}`, line: "It runs again." };
  }

  class Bar {
    constructor() {
      this.sign = icon("info", "f l");
      this.head = el("div", { class: "head" });
      this.line = el("div", { class: "text" });
      this.note = el("span", { class: "h-t14 h-b h-nw wide" });
      this.time = el("div", { class: "time" });
      this.under = el("small");
      this.figure = el("span");
      this.time.append(this.figure, this.under);
      this.node = el("div", { class: "h-banner", hidden: true }, this.sign, el("div", {}, this.head, this.line), el("span", { class: "h-sp" }), this.note, this.time);
    }
    paint(message) {
      attr(this.node, "hidden", !message);
      if (!message) return;
      attr(this.node, "class", `h-banner ${message.look}`);
      text(this.sign, message.sign);
      text(this.head, message.head);
      text(this.line, message.line);
      text(this.note, message.note || "");
      text(this.figure, message.time || "");
      text(this.under, message.under || "");
      attr(this.time, "hidden", !message.time);
    }
  }

  class LinkBanner extends LiveElement {
    build() {
      this.stop = new Bar();
      this.link = new Bar();
      attr(this.stop.node, "data-testid", "stop-banner");
      this.process = new Bar();
      attr(this.process.node, "data-testid", "part-banner");
      this.append(this.stop.node, this.link.node, this.process.node);
    }
    paint() {
      const state = linkState();
      const stop = stopMessage();
      attr(this, "data-state", state);
      attr(this.stop.node, "data-state", stop?.state ?? "none");
      this.stop.paint(stop);
      // a stop that is not confirmed already says the worse; a lost server is news beside it
      const isSaid = state === "robot-lost" && stop?.state === "not-confirmed";
      this.link.paint(isSaid ? null : MESSAGES[state]?.() ?? null);
      this.process.paint(state === "server-lost" ? null : partMessage());
    }
  }

  define("hl-link-banner", LinkBanner);
  Object.assign(HL, { linkState, offline, LOST_MS, STALE_MS });
})();
