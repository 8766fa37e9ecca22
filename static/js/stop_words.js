// What the slab, the stop-all segment and the banner say, from the state alone.
(() => {
  "use strict";
  const parts = (window.headlandStopParts = window.headlandStopParts || {});
  const NOT_ENROLLED = ["This tablet is not enrolled.", "STOP does not work here."];

  const clock = (ms) => {
    const s = Math.max(0, Math.floor(ms / 1000));
    const mm = String(Math.floor((s % 3600) / 60));
    const ss = String(s % 60).padStart(2, "0");
    return s < 3600 ? `${mm}:${ss}` : `${Math.floor(s / 3600)} h ${mm.padStart(2, "0")}`;
  };
  const age = (ms) => (ms < 10000 ? `${(ms / 1000).toFixed(1)} s` : ms < 60000 ? `${Math.floor(ms / 1000)} s` : clock(ms));
  const seconds = (ms) => age(Math.floor(ms / 1000) * 1000).replace(".0", "");
  const robots = (n) => (n === 1 ? "1 robot" : `All ${n} robots`);
  const speed = (step) => (Number.isFinite(step?.speed_mps) ? `braking, ${step.speed_mps.toFixed(2)} m/s` : "braking");
  const list = (names) => (names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);
  const counts = (all) => `${all.standing} of ${all.total} standing`;

  // -> [word, line 2, line 3, has dot]
  function one(view, now) {
    const { state, name, step, robot } = view;
    switch (state) {
      case "ready":
        return ["STOP", name, `READY · ${robot?.hardware_stop ? "machine button is pressed" : view.note || view.link}`, true];
      case "no-link":
        return ["STOP", name, view.heardMs === null ? "NO LINK · sends anyway" : `NO LINK ${seconds(view.heardMs)} · sends anyway`, true];
      case "no-path":
        return view.isEnrolled ? ["STOP", "NO PATH", "use the machine button", false] : ["STOP", ...NOT_ENROLLED, false];
      case "sent":
        return ["STOP", "SENT", `waiting for robot, ${age(now - step.at)}`, true];
      case "acknowledged":
        return ["STOP", "ACKNOWLEDGED BY ROBOT", speed(step || robot), true];
      case "standstill":
        if (view.isOld && view.isLinked) return ["STOPPED", `Standstill ${seconds(view.standstillMs)} ago`, "safety controller silent", true];
        return ["STOPPED", view.isOld ? `Standstill ${seconds(view.standstillMs)} ago` : "Standstill confirmed", `latched ${clock(view.latchedMs)}${view.isLinked ? "" : `, no link ${age(view.heardMs ?? 0)}`}`, true];
      default:
        return ["STOP", "NOT CONFIRMED", "press again, or use machine", false];
    }
  }

  function all(view, now) {
    const { state, total, standing, linked, failing } = view;
    switch (state) {
      case "ready":
        return ["STOP ALL", robots(total), `READY · ${standing ? `${standing} of ${total} stopped` : view.note || (linked < total ? `${linked} of ${total} linked` : view.link)}`, true];
      case "no-link":
        return ["STOP ALL", total ? robots(total) : "No robots", total ? "NO LINK · sends anyway" : "none heard", true];
      case "no-path":
        return view.isEnrolled ? ["STOP ALL", "NO PATH", "use the machine buttons", false] : ["STOP ALL", ...NOT_ENROLLED, false];
      case "sent":
        return ["STOP ALL", "SENT", `${counts(view)}, ${age(now - view.at)}`, true];
      case "acknowledged":
        return ["STOP ALL", "ACKNOWLEDGED", `${counts(view)}, braking`, true];
      case "standstill":
        return ["STOPPED", "Standstill confirmed", `${counts(view)}`, true];
      default:
        return ["STOP ALL", `${counts(view)},`, `${failing.length} NOT CONFIRMED`, false];
    }
  }

  // -> two short lines of the segment
  function segment(view) {
    const { state, total, failing } = view;
    if (state === "not-confirmed") return [`All ${total}`, `${failing.length} not conf.`];
    if (state === "sent" || state === "acknowledged") return ["SENT", `${view.standing} of ${total}`];
    if (state === "standstill") return [`${view.standing} of ${total}`, "standing"];
    return total === 1 ? ["1", "robot"] : [`All ${total || ""}`.trim(), "robots"];
  }

  // Data of the banner over the screens, `null` if STOP has nothing to say there.
  function banner(summary, now) {
    const failing = summary.robots.filter((r) => r.state === "not-confirmed");
    if (failing.length) {
      const names = list(failing.map((r) => r.name));
      const keepOut = Math.max(...failing.map((r) => r.keep_out_m));
      const since = Math.min(...failing.map((r) => r.step?.at ?? now));
      return {
        level: "p1", height: 112, icon: "pan_tool", state: "not-confirmed", robots: failing.map((r) => r.id),
        title: "Use the red button on the machine",
        text: `Stop not confirmed. ${names} may still be moving. Keep everyone ${Math.round(keepOut)} m away.`,
        duration: clock(now - since), duration_label: "since STOP",
        contact: failing[0].contact_name ? { name: failing[0].contact_name, phone: failing[0].contact_phone || "" } : null,
      };
    }
    const isOne = summary.scope.kind === "robot";
    const stopped = summary.robots.filter((r) => r.state === "standstill" && (!isOne || r.id === summary.scope.id));
    if (!stopped.length || (!isOne && stopped.length < summary.total)) return null;
    const old = stopped.filter((r) => r.isOld);
    const they = stopped.length === 1 ? "it" : "them";
    const { step } = stopped[0];
    const confirmed = step ? new Date(Date.parse(step.pressed_utc) + (step.standstill_ms || 0)) : null;
    const who = step ? `Pressed by ${step.by || "somebody"}${step.device && step.device !== step.by ? ` on ${step.device}` : ""}. ` : "";
    return {
      level: "p3", height: 64, icon: "front_hand", state: "standstill", robots: stopped.map((r) => r.id),
      title: old.length ? `Stopped. Standstill told ${seconds(Math.max(...old.map((r) => r.standstillMs)))} ago` : `Stopped. Standstill confirmed${confirmed ? ` ${confirmed.toLocaleTimeString("en-GB")}` : ""}`,
      text: old.length ? `${who}Nothing newer was heard. Look before you walk up to ${they}.` : `${who}${stopped.length === 1 ? "The robot stays" : "They stay"} stopped until someone resets ${they}.`,
      duration: clock(Math.min(...stopped.map((r) => r.latchedMs))), duration_label: "", contact: null,
    };
  }

  parts.words = { one, all, segment, banner, clock, age, list };
})();
