// The one place where screens meet the live lane, REST and STOP. Everything else asks here.
(() => {
  "use strict";
  const lane = window.headland;
  const { config } = HL;
  const CONNECTING_MS = 5000; // a page that has never heard the server says "connecting" this long, then "lost"
  const HERE_MS = 1000;
  const MANY = 100; // robots beyond which a change of one waits for the next round of the ages
  const MOST_TOPICS = 40; // control of more robots than this is followed by lease events alone
  const bornAt = performance.now();
  const INSIDE = ["supervisor", "twin"]; // screens that look into the machine
  const EMPTY = Object.freeze({});
  let topics = "";

  const ms = (seconds) => (seconds === null || seconds === undefined ? Infinity : seconds * 1000);
  const robot = (id) => (id && lane.state(`robot/${id}`)) || EMPTY;
  const inside = (id) => (id && lane.state(`inside/${id}`)) || EMPTY;
  const fleet = () => lane.state("fleet")?.robots || EMPTY;
  const ids = new Set(); // of the fleet: asking an object of a thousand entries for its keys is dear
  const age = (t) => ms(lane.age(t));

  // how long the console has been silent; without a person there is no lane and nothing to miss
  function server() {
    if (!config.user) return { silentMs: 0, isKnown: false };
    const isKnown = lane.hello() !== null;
    if (!isKnown) {
      const waited = performance.now() - bornAt;
      return { silentMs: waited < CONNECTING_MS ? 0 : waited, isKnown };
    }
    const silent = Number.isFinite(lane.tickAge()) ? lane.tickAge() : lane.linkFor();
    return { silentMs: (lane.link() === "ok" ? silent : Math.max(silent, lane.linkFor())) * 1000, isKnown };
  }

  // browser to console to robot and back, as a person who steers feels it; null while unknown
  function delayMs(id) {
    const mine = lane.rtt();
    if (mine === null) return null;
    if (!id) return mine;
    const theirs = robot(id).link?.rtt_ms;
    return theirs === null || theirs === undefined ? null : mine + theirs;
  }

  // control that this browser holds is kept alive by every page it has open, whatever screen is shown
  const held = new Set(HL.keep?.read(`headland.held.${config.session}`, []));

  function noteLease(id, owner) {
    const isMine = Boolean(config.session) && owner?.session === config.session;
    if (held.has(id) === isMine) return;
    if (isMine) held.add(id);
    else held.delete(id);
    HL.keep.write(`headland.held.${config.session}`, [...held]);
    watch();
    // of more the next round tells: the console takes so many frames at once and no more
    if (isMine && held.size < MOST_TOPICS) here();
  }

  function here() {
    const tick = lane.tick();
    const ids = [...held];
    if (tick !== null) for (let i = 0; i < ids.length; i += 100) lane.send({ k: "here", robots: ids.slice(i, i + 100), tick });
  }

  function watch() {
    if (!config.user) return;
    const looked = INSIDE.includes(HL.view?.screen) || HL.looksInside === true ? HL.view.robot : HL.looksInside;
    const wanted = ["fleet", "alarms", ...(looked ? [`inside/${looked}`] : []), ...new Set([HL.view?.robot, ...Object.values(followed), ...held].filter(Boolean).map((id) => `robot/${id}`))].slice(0, MOST_TOPICS);
    if (wanted.join() === topics) return;
    topics = wanted.join();
    lane.sub(wanted);
    for (const topic of wanted) listenTo(topic);
  }

  // robots that are watched without being the one on the screen, by who watches; null ends it
  const followed = {};
  function follow(id, who) {
    followed[who] = id;
    watch();
  }

  function note(robots, changed) {
    if (!changed) ids.clear();
    for (const id of changed ?? Object.keys(robots)) {
      if (robots[id]) ids.add(id);
      else ids.delete(id);
    }
  }

  const heard = new Set();
  function listenTo(topic) {
    if (heard.has(topic)) return;
    heard.add(topic);
    lane.on(topic, (state, _topic, changed) => {
      if (topic.startsWith("robot/") && "lease" in state) noteLease(topic.slice(6), state.lease?.owner);
      if (topic === "fleet" && changed?.length === 0) return; // beats alone only make the list younger
      if (topic === "fleet") note(state.robots ?? EMPTY, changed);
      if (topic === "fleet" && changed && ids.size > MANY) return;
      HL.repaint();
    });
  }

  // REST orders with the newest tick: without a fresh one nothing is sent, and nothing waits
  async function order(path, body) {
    const tick = lane.tick();
    if (tick === null) return { outcome: "rejected", ok: false, text: "Not sent: the link to the server is lost." };
    const answer = await lane.api("POST", path, { ...body, tick }, 3000);
    answer.outcome ??= answer.status >= 400 && answer.status < 500 ? "rejected" : "unknown";
    answer.text ||= answer.outcome === "unknown" ? "No answer. It may have taken effect; look at the robot." : "";
    return answer;
  }

  const of = (id) => `/robots/${encodeURIComponent(id)}`;

  async function command(id, action, extra) {
    const answer = await lane.command(id, action, extra);
    answer.text ||= answer.outcome === "unknown" ? "No answer. It may have taken effect; look at the robot." : "";
    return answer;
  }

  async function lease(id, op, extra) {
    const answer = await order(`${of(id)}/lease`, { op, ...extra });
    if (answer.ok && "owner" in answer) noteLease(id, answer.owner);
    return answer;
  }

  const reset = (id, stopIds, reason) => order(`${of(id)}/stop-reset`, { reset_id: lane.uuid(), stop_ids: stopIds, reason });
  const seen = (id, stopId) => lane.api("POST", `${of(id)}/seen`, { stop_id: stopId });
  const sendMission = (id, missionId, way = "direct") => lane.api("POST", `${of(id)}/mission`, { mission_id: missionId, way }, way === "cloud" ? 60000 : 15000);
  const api = (method, path, body, limitMs) => lane.api(method, path, body, limitMs);

  // picture: age in ms of the camera picture the person steers by, null without one
  function drive(id, v, w, picture = null) {
    const tick = lane.tick();
    return tick !== null && lane.send({ k: "drive", robot: id, v, w, tick, ...(picture === null ? {} : { picture: Math.round(picture) }) });
  }

  const EVENTS = {
    lease(event) {
      noteLease(event.robot, event.owner);
      if (event.robot === HL.view.robot && event.by !== config.user?.name && event.text) HL.toast(event.text, "key");
    },
    drive(event) {
      if (event.op !== "ended") HL.drive.refused(event);
      else if (HL.drive.robot === event.robot) HL.drive.ended(event.text);
    },
    command(event) {
      if (event.is_late && event.session === config.session) HL.toast(`Late answer: ${HL.outcomeWords(event.outcome)}. ${event.text}`, "schedule");
    },
  };
  lane.on("event", (event) => {
    if (event) EVENTS[event.kind]?.(event);
    HL.repaint();
  });
  lane.on("link", HL.repaint);
  window.addEventListener("headland:bye", () => config.user && location.reload());
  window.addEventListener("headland:dropped", () => HL.toast("Not sent: no connection. Try again when it is back.", "cloud_off"));
  setInterval(here, HERE_MS);

  // What the first picture does not need comes after it, so that no byte of it delays STOP or a robot's values: when STOP
  // is ready and the values have had two frames to be drawn. At the latest so long after the page began, because a
  // gateway or a server may not answer at all.
  async function firstPicture(limitMs = 6000) {
    await window.headlandStop?.whenReady(limitMs);
    while (!hasValues() && performance.now() < limitMs) await pause(50);
    await pause(100);
  }
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const hasValues = () => !config.user || (server().isKnown && (!HL.view?.robot || robot(HL.view.robot) !== EMPTY));

  HL.port = { firstPicture, robot, inside, fleet, ids, age, server, delayMs, watch, follow, command, lease, noteLease, reset, seen, sendMission, drive, api, tickInfo: () => lane.state("tick") };
})();
