// The card with the steps of the press that matters most at one robot: who, where, when, and how far it went.
(() => {
  "use strict";
  const parts = (window.headlandStopParts = window.headlandStopParts || {});
  const { element, attribute, text, words } = parts;
  const SVG = "http://www.w3.org/2000/svg";
  const DISC = "M11 0a11 11 0 1 0 0 22 11 11 0 0 0 0-22z";
  const SIGNS = {
    done: `${DISC}M9.400 15.800 5 11.400l1.500-1.500 2.900 2.900 6.100-6.100L17 8.200z`,
    wait: `${DISC}M11 2.200a8.800 8.800 0 1 1 0 17.600 8.800 8.800 0 0 1 0-17.600z`,
    failed: `${DISC}M7.200 5.700 11 9.500l3.800-3.800 1.500 1.500L12.500 11l3.800 3.800-1.500 1.500L11 12.500l-3.800 3.800-1.500-1.500L9.500 11 5.700 7.200z`,
    unknown: `${DISC}M10 15.500h2v2h-2zM11 4.500a4 4 0 0 0-4 4h2a2 2 0 1 1 3.200 1.600C10.900 11 10 11.900 10 13.800h2c0-1.200.6-1.700 1.500-2.400A4 4 0 0 0 11 4.500z`,
  };
  const plus = (ms) => `+${(ms / 1000).toFixed(2)} s`;
  const isSet = (value) => typeof value === "number";

  function pressedAt(step) {
    const at = new Date(step.pressed_utc);
    return Number.isNaN(at.getTime()) ? "" : `${at.toLocaleTimeString("en-GB")}.${Math.floor(at.getMilliseconds() / 100)}`;
  }

  function paths(step) {
    const names = [step.paths?.mqtt && "by radio network", step.paths?.http && "directly"].filter(Boolean);
    const times = step.count > 1 ? `${step.count} times` : "";
    return [times, names.join(" and ")].filter(Boolean).join(", ") || "on every path";
  }

  // under a title that says what is missing only the time is told; what a robot answered stands as it is
  const due = (text) => text?.replace(/^No (acknowledgement|standstill) (within .*)\.$/, "expected $2");

  // -> [sign, title, line, time]
  function rows(step, name, now) {
    const isFailed = step.state === "not-confirmed";
    const waited = `${((now - step.at) / 1000).toFixed(1)} s`;
    const who = [step.by, step.device !== step.by && step.device].filter(Boolean).join(", ") || "this tablet";
    const list = [["done", "Pressed", who, pressedAt(step)]];
    list.push(isSet(step.sent_ms) ? ["done", "SENT", paths(step), plus(step.sent_ms)] : [isFailed ? "failed" : "wait", isFailed ? "Not sent" : "SENT", isFailed ? "no path to the robot" : "on its way", waited]);
    if (isSet(step.ack_ms)) list.push(["done", "ACKNOWLEDGED BY ROBOT", `${name} safety controller`, plus(step.ack_ms)]);
    else list.push(isFailed ? ["failed", "No acknowledgement", due(step.text) || "expected within 1.0 s", waited] : ["wait", "ACKNOWLEDGED BY ROBOT", "waiting for robot", waited]);
    if (step.state === "standstill" && isSet(step.standstill_ms)) list.push(["done", "STANDSTILL CONFIRMED", `${(step.speed_mps || 0).toFixed(2)} m/s, tool off`, plus(step.standstill_ms)]);
    else list.push(isFailed ? ["unknown", "Standstill unknown", (isSet(step.ack_ms) && due(step.text)) || "expected within 3.0 s", waited] : ["wait", "STANDSTILL", isSet(step.speed_mps) && isSet(step.ack_ms) ? `braking, ${step.speed_mps.toFixed(2)} m/s` : "waiting", waited]);
    return list;
  }

  function sign(name) {
    const svg = document.createElementNS(SVG, "svg");
    const path = document.createElementNS(SVG, "path");
    svg.setAttribute("viewBox", "0 0 22 22");
    svg.setAttribute("aria-hidden", "true");
    path.setAttribute("d", SIGNS[name]);
    path.setAttribute("fill", "currentColor");
    path.setAttribute("fill-rule", "evenodd");
    svg.append(path);
    return svg;
  }

  function build(mount) {
    const list = element("div", { role: "list" });
    const rate = element("span");
    const card = element("section", { class: "hl-steps", "data-testid": "stop-steps", "aria-label": "Software stop" }, element("div", { class: "head" }, "Software stop", rate), list, element("div", { class: "note" }));
    mount.replaceChildren(card);
    return (mount.headlandCard = { card, list, rate, note: card.lastChild });
  }

  function draw(list, wanted) {
    while (list.children.length > wanted.length) list.lastChild.remove();
    wanted.forEach(([name, title, line, time], i) => {
      let row = list.children[i];
      if (!row) {
        row = element("div", { class: "step", role: "listitem" }, sign(name), element("div", {}, element("b"), element("small")), element("time"));
        list.append(row);
      }
      if (row.dataset.sign !== name) {
        row.firstChild.replaceWith(sign(name));
        row.dataset.sign = name;
      }
      row.classList.toggle("bad", name === "failed" || name === "unknown");
      text(row.children[1].firstChild, title);
      text(row.children[1].lastChild, line);
      text(row.lastChild, time);
    });
  }

  function note(step) {
    if (step.state === "not-confirmed") return "Headland cannot see whether it stands. Look before you walk up to it.";
    return isSet(step.stopping_distance_m) ? `Stopping distance ${step.stopping_distance_m.toFixed(2)} m.` : "It stays stopped until someone resets it.";
  }

  // Draw into `mount`; hides the card where the robot has no press.
  parts.card = (mount, summary, options, now) => {
    const id = options.robot || summary.scope.id;
    const view = summary.robots.find((robot) => robot.id === id) || (summary.isAll && summary.robots.find((robot) => robot.step));
    const { card, list, rate, note: foot } = mount.headlandCard?.card.isConnected ? mount.headlandCard : build(mount);
    const step = view?.step;
    card.hidden = !step;
    if (!step) return;
    attribute(card, "data-state", step.state);
    for (const key of ["sent_ms", "ack_ms", "standstill_ms"]) attribute(card, `data-${key.replace("_", "-")}`, step[key]);
    text(rate, step.state === "standstill" ? words.age(now - step.heard_at) : now - step.at < 10000 ? "sending 5 per second" : "sending 1 per second");
    draw(list, rows(step, view.name, now));
    text(foot, note(step));
  };
})();
