// What became of an order to several robots, robot by robot; those that failed can be tried again.
(() => {
  "use strict";
  const { el, icon } = HL;
  const SIGNS = { accepted: "check", rejected: "block", refused: "block", timed_out: "timer_off", unknown: "help" };

  // {title, done: "took it", results: [{robot, outcome, text}], again: async (robots) => opens anew}
  function show({ title, results, again }) {
    const failed = results.filter((one) => one.outcome !== "accepted");
    const taken = results.length - failed.length;
    const order = [...failed, ...results.filter((one) => one.outcome === "accepted")];
    const head = el("p", { class: "h-t18 h-b", role: "status", "data-testid": "fleet-results-sum", "data-value": `${taken}/${results.length}` }, failed.length ? `${taken} of ${results.length} took it. ${failed.length === 1 ? "One did not" : `${failed.length} did not`}.` : results.length === 1 ? "It took it." : `All ${results.length} took it.`);
    const list = el("ul", { class: "f-results", "data-testid": "fleet-results" }, ...order.map((one) => line(one)));
    const buttons = [["Close", (close) => close(), !failed.length]];
    if (failed.length && again) buttons.push([`Try again with ${failed.length}`, (close) => (close(), again(failed.map((one) => one.robot))), true]);
    HL.sheet({ title, hook: "fleet-results-sheet", body: [head, list], buttons });
  }

  function line(one) {
    const words = one.outcome === "accepted" ? "Accepted" : [HL.outcomeWords(one.outcome), one.text].filter(Boolean).join(": ");
    return el("li", { class: "h-row", "data-state": one.outcome, "data-testid": `fleet-result-${one.robot}` }, icon(SIGNS[one.outcome] ?? "help", "m"), el("span", { class: "h-col" }, el("b", { class: "h-t16" }, HL.fleet.name(one.robot)), el("span", { class: "h-t14" }, words)));
  }

  // one REST call for all; what no answer came for is unknown, never done
  async function order(path, body, robots, limitMs = 8000) {
    const answer = await HL.port.api("POST", path, body, limitMs);
    if (answer.ok) {
      for (const one of answer.results) if (one.owner) HL.port.noteLease(one.robot, one.owner); // kept alive from now on, whatever the lane tells
      return answer.results;
    }
    const isRefused = answer.status >= 400 && answer.status < 500;
    const words = isRefused ? answer.text : "No answer. It may have taken effect; look at the robot.";
    return robots.map((robot) => ({ robot, outcome: isRefused ? "rejected" : "unknown", text: words }));
  }

  // an order that needs the newest tick; without a fresh one nothing is sent
  function act(action, robots) {
    const tick = window.headland.tick();
    if (tick === null) return Promise.resolve(robots.map((robot) => ({ robot, outcome: "refused", text: "Not sent: the link to the server is lost." })));
    return order("/fleet/actions", { action, robots, tick, action_id: window.headland.uuid() }, robots);
  }

  HL.fleetOrders = { show, act, order };
})();
