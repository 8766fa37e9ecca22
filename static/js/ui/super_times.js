// The times in states that the screen shows: asked for a span, kept fresh while somebody looks.
(() => {
  "use strict";
  const SPANS = { 10: { minutes: 10, word: "last 10 min", everyMs: 8000 }, 60: { minutes: 60, word: "last hour", everyMs: 20000 }, mission: { word: "this mission", everyMs: 20000 } };

  const UNDER_WAY = new Set(["running", "paused"]);
  const ENDING_MS = 30000; // after a mission ended it is asked for once more

  const times = {
    span: "10", mission: null, data: null, problem: "", isLoading: false, loadedAt: -Infinity, liveAt: -Infinity, key: "", robot: null,

    // another robot, or the same with another mission in its address
    begin(robot, wanted) {
      const mission = wanted || null;
      Object.assign(times, { robot, mission, data: null, problem: "", span: mission ? "mission" : times.span, loadedAt: -Infinity });
    },
    choose(span) {
      Object.assign(times, { span, data: null, problem: "", loadedAt: -Infinity });
      HL.repaint();
    },
    missionId: () => times.mission ?? HL.port.robot(times.robot).mission?.id ?? null,
    // a mission that only lies on the robot, before its start or after its end, does not go on
    isLive() {
      if (times.span !== "mission") return true;
      const now = HL.port.robot(times.robot).mission;
      return UNDER_WAY.has(now?.status) && (!times.mission || times.mission === now.id);
    },
    word: () => (times.span === "mission" && times.mission ? "chosen mission" : SPANS[times.span].word),
    query() {
      if (times.span !== "mission") return `minutes=${SPANS[times.span].minutes}`;
      return times.missionId() ? `mission=${encodeURIComponent(times.missionId())}` : "";
    },
    // called with each paint; asks when it is time to
    refresh() {
      if (!times.robot || document.hidden || times.isLoading) return;
      const now = performance.now();
      if (times.isLive()) times.liveAt = now;
      const isDue = !times.data || now - times.liveAt < ENDING_MS;
      if (now - times.loadedAt < (isDue ? SPANS[times.span].everyMs : Infinity)) return;
      const query = times.query();
      times.loadedAt = now;
      if (!query) return void (times.problem = "No mission is on this robot.");
      void times.load(query);
    },
    async load(query) {
      times.isLoading = true;
      const { robot, span } = times;
      const answer = await HL.port.api("GET", `/robots/${robot}/state-times?${query}`);
      times.isLoading = false;
      if (robot !== times.robot || span !== times.span) return void (times.loadedAt = -Infinity);
      if (answer.ok) Object.assign(times, { data: answer.data, problem: "" });
      else times.problem = answer.text;
      HL.repaint();
    },
    csvUrl: () => `${HL.config.apiPath}/robots/${times.robot}/state-times.csv?${times.query()}`,
  };

  HL.superTimes = times;
})();
