// Before it starts: what the server checks by itself, live, and the list that a person ticks.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define } = HL;
  const SIGN = { yes: "check", no: "block", warn: "warning", unknown: "help" };
  const AGAIN_MS = 30000; // a list ticked on another tablet, or run out, is seen by then
  const lists = new Map();

  const of = (robot) => `/robots/${encodeURIComponent(robot)}/checklist`;

  async function load(robot) {
    const known = lists.get(robot);
    if (known && (known.isLoading || performance.now() - known.at < (known.list ? AGAIN_MS : 3000))) return;
    lists.set(robot, { ...known, isLoading: true, at: performance.now() });
    const answer = await HL.port.api("GET", of(robot));
    const kept = known?.list && { ...known.list, record: null }; // without an answer nobody knows whether it still counts
    lists.set(robot, { list: answer.ok ? answer.data : kept, at: performance.now() });
    HL.repaint();
  }

  const listOf = (robot) => (load(robot), lists.get(robot)?.list);
  const record = (robot) => listOf(robot)?.record ?? null; // the server tells one only while it counts, by its own clock
  const isAStart = (groups) => groups.mission?.status !== "paused" || groups.why?.code === "continued";

  // why the slide is locked; empty when nothing is in the way
  function reason(robot) {
    const groups = HL.port.robot(robot);
    const blocking = (groups.checks ?? []).find((one) => one.blocks);
    if (blocking) return [blocking.text, blocking.clears].filter(Boolean).join(" ");
    if (!isAStart(groups) || groups.mission?.is_supervised === false) return "";
    const list = listOf(robot);
    if (!list) return "The list before the start is loading";
    return list.is_required && !record(robot) ? "Tick the list first: Checks" : "";
  }

  function summary(robot) {
    const checks = HL.port.robot(robot).checks ?? [];
    if (!checks.length) return "";
    const good = checks.filter((one) => one.ok === true).length;
    const list = listOf(robot);
    const open = list?.is_required && !record(robot) ? ", list open" : "";
    return `${good} of ${checks.length}${list ? open : ", list is loading"}`;
  }

  class StartChecks extends LiveElement {
    build() {
      this.robot = this.dataset.robot;
      this.ticked = new Set();
      this.auto = el("div", { class: "h-runlist", "data-testid": "start-checks" });
      this.items = el("div", { class: "h-runlist" });
      this.state = el("p", { class: "h-t14 h-2", role: "status", "data-testid": "checklist-state" });
      this.append(el("h3", { class: "h-t16 h-b" }, "Checked by itself, now"), this.auto, el("h3", { class: "h-t16 h-b" }, "You look at this"), this.items, this.state);
    }
    paint() {
      this.paintAuto(HL.port.robot(this.robot).checks ?? []);
      this.paintList(listOf(this.robot));
    }
    paintAuto(checks) {
      const key = JSON.stringify(checks);
      if (key === this.drawn) return;
      this.drawn = key;
      this.auto.replaceChildren(...(checks.length ? checks.map(row) : [el("p", { class: "h-2" }, "No mission waits on this robot.")]));
    }
    paintList(list) {
      const done = record(this.robot);
      const key = `${JSON.stringify(list ?? null)}${done?.id}${[...this.ticked]}${this.isBusy}`;
      if (key === this.listed) return;
      this.listed = key;
      attr(this, "data-state", done ? "ticked" : "open");
      text(this.state, !list ? "Loading the list" : done ? `Ticked by ${done.by} at ${HL.words.wall(new Date(done.utc))}. Counts until ${HL.words.wall(new Date(done.valid_until_utc))}.` : this.said || `Tap each line that is true. It counts ${list.valid_hours} h, for you.`);
      this.items.replaceChildren(...(list?.items ?? []).map((one) => this.item(one, Boolean(done))));
    }
    item(one, isDone) {
      const isOn = isDone || this.ticked.has(one.id);
      return el("button", { type: "button", class: "h-btn h-tick", role: "checkbox", "aria-checked": String(isOn), "data-testid": `check-${one.id}`, disabled: isDone || !HL.config.rights.includes("start"), onclick: () => this.tap(one.id) }, el("span", { class: "h-box" }, isOn ? icon("check", "l") : ""), el("span", {}, one.text));
    }
    tap(id) {
      if (!this.ticked.delete(id)) this.ticked.add(id);
      const list = listOf(this.robot);
      if (list.items.every((one) => this.ticked.has(one.id))) this.keep(list);
      HL.repaint();
    }
    async keep(list) {
      this.isBusy = true;
      const answer = await HL.port.api("POST", of(this.robot), { ticked: list.items.map((one) => one.id) });
      this.isBusy = false;
      if (answer.ok) lists.set(this.robot, { list: { ...list, record: answer.data.record }, at: performance.now() });
      else this.ticked.clear();
      this.said = answer.ok ? "" : `Not noted: ${answer.text || "no answer. Tick again."}`;
      if (answer.ok) HL.toast("Noted with your name and the time", "check");
      this.listed = null;
      HL.repaint();
    }
  }

  function row(check) {
    const look = check.ok === true ? "yes" : check.ok === null ? "unknown" : check.blocks ? "no" : "warn";
    return el("div", { class: `h-runcheck ${look}`, "data-testid": `start-check-${check.key}`, "data-state": look }, icon(SIGN[look], "l f"), el("span", {}, el("b", {}, check.text), check.clears ? el("span", { class: "h-2" }, ` ${check.clears}`) : ""));
  }

  function open(robot) {
    HL.sheet({ title: "Before it starts", hook: "start-sheet", body: [el("hl-start-checks", { "data-robot": robot })], buttons: [["Close", (close) => close(), true]] });
  }

  HL.startChecks = { open, reason, summary, recordId: (robot) => record(robot)?.id ?? null, isAStart };
  define("hl-start-checks", StartChecks);
})();
