// What a person can do about an alarm. Sent at once or refused, never kept for later; the list changes when the server says so.
(() => {
  "use strict";
  const LIMIT_MS = 6000;
  const SAID_MS = 20000;
  const MOST = 500; // ids the server takes at once
  const WORDS = { acknowledge: "Acknowledging", clear: "Clearing", shelve: "Shelving", unshelve: "Bringing it back", "out-of-service": "Taking it out of service", "in-service": "Putting it back into service", diagnose: "Checking" };
  const pending = new Map(); // id -> verb
  const said = new Map(); // id -> {isOk, text, at}

  const of = (id) => `/alarms/${encodeURIComponent(id)}`;
  const isOffline = () => window.headland.link() === "server-lost";

  async function call(method, path, body, limitMs = LIMIT_MS) {
    if (isOffline()) return { ok: false, status: 0, text: "Not sent: the link to the server is lost. Do it again when it is back." };
    const answer = await HL.port.api(method, path, body, limitMs);
    if (answer.code === "no_answer") answer.text = "No answer. It may have been taken; look at the list.";
    return answer;
  }

  function note(id, isOk, words) {
    said.set(id, { isOk, text: words, at: performance.now() });
    HL.repaint();
  }

  async function send(id, verb, body = {}, limitMs) {
    if (pending.has(id)) return { ok: false, text: "One moment: the last is not answered yet." };
    pending.set(id, verb);
    said.delete(id);
    HL.repaint();
    const answer = await call("POST", `${of(id)}/${verb}`, body, limitMs);
    pending.delete(id);
    note(id, answer.ok, answer.ok ? "" : answer.text || "The server refused it.");
    return answer;
  }

  function tell(results, refused) {
    const failed = results.filter((one) => one.code !== "ok");
    for (const one of failed) note(one.id, false, one.text || "Refused.");
    const taken = results.length - failed.length;
    const words = [taken ? `${taken} acknowledged` : "", failed.length ? `${failed.length} not: ${failed[0].text || "refused"}` : "", refused].filter(Boolean).join(", ");
    HL.toast(words || "Nothing acknowledged.", failed.length || refused ? "block" : "done_all");
  }

  // several at once: each has its own answer
  async function acknowledge(ids) {
    const wanted = ids.filter((id) => !pending.has(id));
    if (!wanted.length) return;
    for (const id of wanted) pending.set(id, "acknowledge");
    HL.repaint();
    const results = [];
    let refused = "";
    for (let at = 0; at < wanted.length && !refused; at += MOST) {
      const some = wanted.slice(at, at + MOST);
      const answer = await call("POST", "/alarms/acknowledge", { ids: some });
      results.push(...(answer.results ?? []));
      if (!answer.ok) refused = answer.text || "The server refused it.";
    }
    for (const id of wanted) pending.delete(id);
    tell(results, refused);
    HL.repaint();
  }

  // what the last act came to, while it is worth reading
  function outcome(id) {
    const last = said.get(id);
    return last && performance.now() - last.at < SAID_MS ? last : null;
  }

  HL.alarmActs = { send, acknowledge, call, of, outcome, isOffline, pending: (id) => (pending.has(id) ? `${WORDS[pending.get(id)]} …` : "") };
})();
