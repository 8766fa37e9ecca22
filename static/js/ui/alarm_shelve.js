// Shelving and taking out of service: for how long, and why. What the server says stays on the sheet until it is done.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const TIMES = [["15 min", { minutes: 15 }], ["1 h", { minutes: 60 }], ["4 h", { minutes: 240 }], ["End of shift", { until_shift_end: true }]];
  const WHY_SHELF = ["Known, being mended", "Weather", "Cleaning or service", "False alarm"];
  const WHY_OUT = ["Sensor is being repaired", "Part is taken off", "Waits for a spare part"];
  const SHORTEST = 3;
  const LONGEST = 200;

  // one of several buttons
  function choice(label, options, onpick, hook) {
    const buttons = options.map((name) => el("button", { type: "button", role: "radio", "aria-checked": "false", onclick: () => pick(name) }, name));
    const node = el("div", { class: "h-seg al-choice", role: "radiogroup", "aria-label": label, "data-testid": hook }, ...buttons);
    function pick(name) {
      buttons.forEach((button, i) => attr(button, "aria-checked", String(options[i] === name)));
      onpick(name);
    }
    return { node, pick };
  }

  function reasonField(reasons) {
    const input = el("input", { class: "h-input", maxlength: String(LONGEST), "data-testid": "alarm-reason", "aria-label": "Reason", placeholder: "Why? It is kept with your name." });
    const quick = el("div", { class: "h-row h-wrap" }, ...reasons.map((words) => el("button", { type: "button", class: "h-btn", onclick: () => ((input.value = words), input.focus()) }, words)));
    return { input, node: el("div", { class: "h-col" }, el("label", { class: "h-field" }, "Reason", input), quick) };
  }

  function ask({ title, line, extra, reasons, go, verb, id, body, hook }) {
    const why = reasonField(reasons);
    const problem = el("div", { class: "h-error", role: "alert", "data-testid": "alarm-problem" });
    const done = async (close) => {
      const reason = why.input.value.trim();
      if (reason.length < SHORTEST) return text(problem, "Say why, in 3 characters or more."), why.input.focus();
      text(problem, "");
      attr(button, "disabled", true);
      text(button, `${go} …`);
      const answer = await HL.alarmActs.send(id, verb, { ...body(), reason });
      attr(button, "disabled", null);
      text(button, go);
      if (answer.ok) return close();
      text(problem, answer.text || "The server refused it.");
      return undefined;
    };
    HL.sheet({ title, hook, body: [el("p", { class: "h-t16 h-2" }, line), ...extra, why.node, problem], buttons: [["Leave it", (close) => close()], [go, done, true]] });
    const button = document.querySelector(`[data-testid="${hook}"] .foot .pri`);
  }

  function shelve(id, one) {
    let time = TIMES[1];
    const times = choice("For how long", TIMES.map(([name]) => name), (name) => (time = TIMES.find(([word]) => word === name)), "alarm-shelve-time");
    times.pick("1 h");
    ask({ title: `Shelve ${one.title}, ${one.name}`, line: "It makes no sound and leaves the list. It comes back by itself.", extra: [times.node], reasons: WHY_SHELF, go: "Shelve", verb: "shelve", id, body: () => time[1], hook: "alarm-shelve-sheet" });
  }

  function toggle(id, one) {
    if (one.state === "shelved") HL.alarmActs.send(id, "unshelve");
    else shelve(id, one);
  }

  function takeOut(id, one) {
    ask({ title: `Take ${one.title}, ${one.name}, out of service`, line: "It is not shown at all until somebody puts it back. For what takes longer than a shift.", extra: [], reasons: WHY_OUT, go: "Take out of service", verb: "out-of-service", id, body: () => ({}), hook: "alarm-out-sheet" });
  }

  HL.alarmShelving = { toggle, takeOut };
})();
