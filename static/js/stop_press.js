// What may be claimed about each STOP press, decided in this browser. Pure: no DOM, no socket; the caller gives the time.
// A press is never better than the newest evidence and never waits for a server to be called "not confirmed".
(() => {
  "use strict";
  const parts = (window.headlandStopParts = window.headlandStopParts || {});
  const ACK_LIMIT_MS = 1000; // safety rules; a robot's own limit may only be shorter
  const STANDSTILL_LIMIT_MS = 3000;
  const SAME_PRESS_MS = 2000; // nobody can have reset a press this young, so a second tap may share its id
  const SILENT_MS = 2000; // a gateway that answers by HTTP every second is not silent, whatever its websocket is
  const EVIDENCE_MS = 5000; // a confirmation by HTTP alone counts this long, then it is asked for again
  const ANY = "*"; // "all", before this browser knows which robots there are
  const WORST = ["not-confirmed", "sent", "acknowledged", "standstill"];

  const CLAIMED = ["state", "sent_ms", "ack_ms", "standstill_ms", "by", "stopping_distance_m"]; // what people are told of a press

  const makeId = () =>
    Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  const within = (limit, most) => (Number.isFinite(limit) && limit > 0 ? Math.min(limit, most) : most);

  class Presses {
    constructor() {
      this.entries = new Map(); // "stop id/robot" -> entry
      this.own = new Map(); // stop id -> press made here
      this.gatewayAt = -Infinity; // when the gateway told its newest step
      this.revision = 0; // another one when anything that may be claimed changed
    }

    // Note a press made here and now. `robots` is a list of ids or "all", `known` the robots this browser knows.
    // `isHopeless`: no way out is known, so it says at once what a person has to do.
    press(robots, known, now, { by = "", device = "", isHopeless = false, cards = {}, id = "", agoMs = 0 } = {}) {
      const ids = robots === "all" ? (known.length ? known : [ANY]) : robots;
      const scope = robots === "all" ? "all" : [...robots].sort().join();
      const last = [...this.own.values()].find((p) => p.scope === scope && now - p.at < SAME_PRESS_MS && !p.isCovered);
      if (last && !id) return last;
      for (const older of this.own.values()) {
        if (robots === "all" || (older.robots !== "all" && older.robots.every((r) => ids.includes(r)))) older.isCovered = true;
      }
      const failed = this.takeOver(ids, robots === "all");
      const press = { id: id || makeId(), robots, scope, at: now - agoMs, tried: 0, isCovered: false };
      this.own.set(press.id, press);
      const pressed_utc = new Date(Date.now() - agoMs).toISOString();
      for (const robot of ids) {
        const step = { stop_id: press.id, robot, name: cards[robot]?.name || robot, state: "sent", by, device, pressed_utc, count: 0, paths: {} };
        this.entries.set(`${press.id}/${robot}`, { step, by: {}, at: press.at, heardAt: now, isMine: true, isFailed: isHopeless || failed.has(robot) || failed.has(ANY), contradictedBy: "" });
      }
      this.revision += 1;
      return press;
    }

    // A covered press that nobody has answered is sent no more: it would stay not confirmed for good, whatever the newer
    // one leads to. That one stands for it, and is not confirmed from the start if it was not. Return at which robots.
    takeOver(ids, isAll) {
      const failed = new Set();
      for (const [key, { step, by, isFailed }] of this.entries) {
        if (!this.own.get(step.stop_id)?.isCovered || by.gateway || by.console) continue;
        if (!ids.includes(step.robot) && !(isAll && step.robot === ANY)) continue;
        if (isFailed) failed.add(step.robot);
        this.drop(key);
        if (![...this.entries.values()].some((e) => e.step.stop_id === step.stop_id)) this.own.delete(step.stop_id);
      }
      return failed;
    }

    // Take a step that came from `source` ("gateway" or "console").
    take(step, source, now, isGatewayFresh = true) {
      if (!step || typeof step.stop_id !== "string" || typeof step.robot !== "string") return;
      const key = `${step.stop_id}/${step.robot}`;
      const own = this.own.get(step.stop_id);
      this.drop(`${step.stop_id}/${ANY}`);
      if (step.state === "reset" || step.state === "withdrawn") {
        this.drop(key);
        if (own && ![...this.entries.values()].some((e) => e.step.stop_id === own.id)) this.own.delete(own.id);
        return;
      }
      const entry = this.entries.get(key) || { by: {}, at: own ? own.at : now - (step.age_ms || 0), isMine: Boolean(own), isFailed: false, contradictedBy: "" };
      const before = entry.by[source]?.boot === step.boot ? entry.by[source] : null; // a restarted console counts ages anew
      if (before && before.age_ms > step.age_ms) return; // overtaken on another connection
      if (source === "gateway") this.gatewayAt = now;
      const isGatewaySilent = !isGatewayFresh && now - this.gatewayAt > SILENT_MS;
      this.weigh(entry, step, source, before, source === "gateway" || isGatewaySilent);
      entry.by[source] = step;
      entry.heardAt = now;
      if (step.state === "standstill" && Number.isFinite(step.safety_ms)) entry.provenAt = now - step.safety_ms;
      entry.step = this.best(entry);
      this.entries.set(key, entry);
    }

    // Standstill that was claimed is taken back by whoever said it, and by the console alone when the gateway is silent;
    // only who counts most now, or who took it back, can say it again.
    weigh(entry, step, source, before, isWeighty) {
      if (step.state === "standstill") {
        if (isWeighty || entry.contradictedBy === source) entry.contradictedBy = "";
        return;
      }
      const isDenied = source === "console" && isWeighty && step.state === "not-confirmed" && entry.step && this.claim(entry) === "standstill";
      if (before?.state === "standstill" || isDenied) entry.contradictedBy = source;
    }

    // A restarted gateway counts ages anew: its first steps are not older than those of the one before.
    forgetAges(source) {
      for (const entry of this.entries.values()) delete entry.by[source];
    }

    // The gateway told all presses it holds: others are over, except what was pressed here and is not confirmed.
    reconcile(since) {
      for (const [key, entry] of this.entries) {
        if (entry.heardAt >= since || (entry.isMine && this.claim(entry) !== "standstill")) continue;
        this.drop(key);
        if (entry.isMine) this.own.delete(entry.step.stop_id);
      }
    }

    drop(key) {
      if (this.entries.delete(key)) this.revision += 1;
    }

    best({ by, contradictedBy }) {
      const { gateway, console: second } = by;
      if (!gateway || !second) return gateway || second;
      if (contradictedBy) return by[contradictedBy];
      if (gateway.state === "standstill") return gateway;
      if (second.state === "standstill") return second;
      return gateway.ack_ms === null && second.ack_ms !== null ? second : gateway;
    }

    claim(entry) {
      return entry.contradictedBy ? "not-confirmed" : entry.step.state;
    }

    // Return what may be claimed about one press at one robot now.
    stateOf(entry, now, card = {}) {
      const claim = this.claim(entry);
      if (claim === "standstill") {
        entry.isFailed = false; // a late confirmation still counts
        return claim;
      }
      const age = now - entry.at;
      const isLate =
        claim === "not-confirmed" ||
        (claim === "sent" && age >= within(card.ack_limit_ms, ACK_LIMIT_MS)) ||
        age >= within(card.standstill_limit_ms, STANDSTILL_LIMIT_MS);
      if (isLate) entry.isFailed = true; // stays so until standstill is confirmed
      return entry.isFailed ? "not-confirmed" : claim;
    }

    // Return the presses of each robot, each with its state, worst first, newest first among equals: Map robot -> steps.
    // Looked at ten times a second with a thousand robots stopped: a step is made anew only when it differs.
    byRobot(now, cards) {
      const found = new Map();
      for (const entry of this.entries.values()) {
        const { robot } = entry.step;
        const held = found.get(robot);
        const step = this.stepOf(entry, now, cards[robot]);
        if (held) held.push(step);
        else found.set(robot, [step]);
      }
      for (const steps of found.values()) if (steps.length > 1) steps.sort((a, b) => WORST.indexOf(a.state) - WORST.indexOf(b.state) || b.at - a.at);
      return found;
    }

    stepOf(entry, now, card) {
      const state = this.stateOf(entry, now, card);
      const { told } = entry;
      if (told?.state === state && told.heard_at === entry.heardAt && entry.toldOf === entry.step) return told;
      entry.toldOf = entry.step;
      entry.told = { ...entry.step, state, at: entry.at, heard_at: entry.heardAt, proven_at: entry.provenAt, is_mine: entry.isMine };
      if (!told || CLAIMED.some((key) => told[key] !== entry.told[key])) this.revision += 1;
      return entry.told;
    }

    // Whether a confirmation can still be stood for although the gateway's heartbeat is gone.
    hasEvidence(steps, now) {
      return steps.some((step) => now - step.heard_at < EVIDENCE_MS);
    }

    // Return the presses made here that somebody has still to be told about, or asked about.
    open(now, isGatewayFresh) {
      return [...this.own.values()].filter((press) => {
        if (press.isCovered) return false;
        const mine = [...this.entries.values()].filter((e) => e.step.stop_id === press.id);
        return mine.some((e) => this.claim(e) !== "standstill") || (mine.length && !isGatewayFresh);
      });
    }
  }

  Object.assign(parts, { Presses, WORST, ANY });
})();
