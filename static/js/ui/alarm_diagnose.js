// A guided check: each step, what it found, and what that means.
(() => {
  "use strict";
  const { el, icon } = HL;
  const LIMIT_MS = 15000;
  const SIGNS = { true: ["check", "In order"], false: ["error", "Not in order"], null: ["help", "Cannot be told from here"] };

  function step(one) {
    const [sign, word] = SIGNS[String(one.ok ?? null)];
    return el("li", { class: "al-check", "data-state": one.ok === null || one.ok === undefined ? "unknown" : one.ok ? "good" : "bad" }, icon(sign), el("span", {}, el("b", { class: "h-t16 h-b" }, one.text), el("span", { class: "h-t14 h-2" }, one.ok && one.found ? one.found : `${word}. ${one.found ?? ""}`)));
  }

  async function diagnose(id, one) {
    const body = el("div", { class: "h-col", "aria-live": "polite" }, el("div", { class: "h-skeleton" }, ...["100%", "80%", "92%"].map((width) => { const bar = el("i"); bar.style.width = width; return bar; })), el("p", { class: "h-2" }, `Checking ${one.name} …`));
    HL.sheet({ title: `Check: ${one.title}, ${one.name}`, hook: "alarm-diagnosis", body: [body], buttons: [["Close", (close) => close()], ["Check again", () => diagnose(id, one), true]] });
    const answer = await HL.alarmActs.call("POST", `${HL.alarmActs.of(id)}/diagnose`, {}, LIMIT_MS);
    if (!body.isConnected) return;
    if (!answer.ok) return void body.replaceChildren(el("p", { class: "h-error", role: "alert" }, answer.text || "The check did not run."));
    body.replaceChildren(el("ol", { class: "al-checks" }, ...(answer.steps ?? []).map(step)), el("div", { class: "h-card al-conclusion" }, icon("info"), el("b", { class: "h-t18 h-b", "data-testid": "alarm-conclusion" }, answer.conclusion || "No conclusion")), el("p", { class: "h-t14 h-2" }, "The check looks and asks. It moves and resets nothing."));
  }

  HL.alarmDiagnose = diagnose;
})();
