// Missions: the list, one in detail, sending it to its robot. Everything comes from REST and goes back there.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define } = HL;
  const { list, when, empty } = HL.records;
  const LATE_MS = 5000; // a list that is not there by then is an error
  const WORKED = ["running", "paused", "resuming", "done", "aborted", "failed"];
  const TABS = [["list", "List"], ["plan", "Plan"], ["queue", "Queue"]];
  const RELOAD_MS = 1200; // moves of a mission come close together, and are stored a moment after the robot tells

  const of = (id) => `/missions/${encodeURIComponent(id)}`;
  const robotName = (id) => HL.port.fleet()[id]?.name ?? id ?? "no robot";

  // one look of a state in the list and above its mission
  const look = (status) => `h-chip ${["running", "resuming"].includes(status) ? "dark" : status === "done" ? "" : "line"}`.trim();
  const isUnderWay = (mission) => HL.isInterrupted(mission) || ["running", "resuming", "paused"].includes(mission.status);

  class Row {
    constructor(mission, open, pick) {
      this.box = el("input", { type: "checkbox", "aria-label": `Choose ${mission.name}`, "data-testid": `mission-pick-${mission.id}`, onchange: () => pick(mission.id, this.box.checked) });
      this.pick = el("label", { class: "h-mpick", hidden: true }, this.box);
      this.name = el("span", { class: "h-t16 h-b" });
      this.line = el("span", { class: "h-t13 h-2" });
      this.chip = el("span");
      this.row = el("button", { type: "button", class: "h-mrow", "data-testid": `mission-row-${mission.id}`, onclick: () => open(mission.id) }, el("span", { class: "h-col" }, this.name, this.line), this.chip);
      this.node = el("div", { class: "h-mline", role: "listitem" }, this.pick, this.row);
    }
    paint(mission, isChosen, isPicked) {
      attr(this.row, "data-state", mission.status);
      attr(this.row, "aria-current", isChosen ? "true" : null);
      attr(this.pick, "hidden", isPicked === null);
      this.box.checked = Boolean(isPicked);
      text(this.name, mission.name);
      const others = [mission.field_name, robotName(mission.robot_id)].filter((one) => one && !mission.name.includes(one)); // not said twice
      text(this.line, `${others.map((one) => `${one} · `).join("")}changed ${HL.queue.when(Date.parse(mission.updated_utc), undefined)}`);
      attr(this.chip, "class", look(mission.status));
      text(this.chip, HL.plan.status(mission.status));
    }
  }

  class Missions extends LiveElement {
    build() {
      this.rows = new Map();
      this.missions = [];
      this.chosen = "";
      this.planButton = el("button", { type: "button", class: "h-btn pri", "data-testid": "mission-plan", onclick: () => this.leaving(() => this.plan()) }, icon("add", "m"), "Plan a mission");
      this.search = el("input", { class: "h-input", type: "search", placeholder: "Search", "aria-label": "Search missions", oninput: () => this.draw() });
      this.said = el("div");
      this.list = el("div", { class: "h-mlist", role: "list" });
      this.detail = el("section", { class: "h-mdetail h-scroll", "aria-label": "Mission" });
      this.group = "all";
      this.picked = null;
      this.filters = el("div", { class: "q-filters", role: "group", "aria-label": "Which missions" });
      this.bulk = el("div");
      this.selectButton = el("button", { type: "button", class: "h-btn ico", "data-testid": "mission-select", title: "Choose several", "aria-label": "Choose several missions", "aria-pressed": "false", onclick: () => this.select(this.picked === null) }, icon("lists", "m"));
      this.tabs = el("nav", { class: "h-seg h-mtabs", "aria-label": "Missions" }, ...TABS.map(([key, name]) => el("button", { type: "button", "data-tab": key, "data-testid": `missions-tab-${key}`, onclick: () => this.tab(key) }, name)));
      this.append(el("div", { class: "h-mtop" }, this.tabs), el("aside", { class: "h-mside" }, el("div", { class: "h-row" }, this.search, this.selectButton, this.planButton), this.filters, el("p", { class: "h-t13 h-2", "data-testid": "mission-rights" }), this.said, this.list, this.bulk), this.detail);
      styled(this);
      this.may = { edit: this.dataset.mayEdit === "yes", send: this.dataset.maySend === "yes" };
      text(this.querySelector("[data-testid=mission-rights]"), !this.may.send && !this.may.edit ? this.dataset.noSend : this.may.edit ? "" : this.dataset.noEdit);
      if (!this.may.edit) attr(this.planButton, "disabled", true);
      const isAbout = (event) => ["mission", "mission-status"].includes(event.kind) || (event.kind === "robot" && event.what === "mission");
      this.onEvent = (event) => event && isAbout(event) && this.soon();
    }

    enter() {
      this.unsubscribe = window.headland?.on("event", this.onEvent);
      this.load(true);
      this.showTab(HL.keep.read("headland.missions.tab", "list") === "queue" ? "queue" : "list");
    }

    leave() {
      this.queueView?.leave();
      this.unsubscribe?.();
      clearTimeout(this.timer);
    }

    tab(key) {
      if (key === "plan") {
        if (!this.may.edit) return HL.toast(this.dataset.noEdit, "lock");
        return this.leaving(() => this.plan());
      }
      if (key === "list" && this.form) return this.leaving(() => (this.close(), this.showTab(key)));
      return this.showTab(key);
    }

    // what was changed in a draft and not saved is asked about first, wherever the form is left to
    leaving(leave) {
      const { form } = this;
      return form?.keeper ? form.keeper.leave(() => (form.end(), leave())) : leave();
    }

    showTab(key) {
      attr(this, "data-tab", key);
      for (const one of this.tabs.children) attr(one, "aria-pressed", String(one.dataset.tab === key));
      if (key !== "plan") HL.keep.write("headland.missions.tab", key);
      if (key !== "queue") return this.queueView?.leave();
      if (!this.queueView) {
        this.queueView = new HL.QueueView();
        this.append(this.queueView.node);
      }
      return this.queueView.enter();
    }

    // choosing several: null means that nothing is being chosen
    select(isOn) {
      this.picked = isOn ? new Set() : null;
      attr(this.selectButton, "aria-pressed", String(isOn));
      this.draw();
    }

    pick(id, isOn) {
      if (isOn) this.picked?.add(id);
      else this.picked?.delete(id);
      this.draw();
    }

    soon() {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.load(false), RELOAD_MS);
    }

    async load(isFirst) {
      if (isFirst && !this.missions.length) this.said.replaceChildren(el("div", { class: "h-card h-skeleton", "aria-label": "Loading missions" }, el("span", { class: "h-t14 h-2" }, "Loading missions"), el("i"), el("i"), el("i")));
      const answer = await HL.port.api("GET", "/missions", null, LATE_MS);
      if (!this.isConnected) return;
      if (!answer.ok) {
        this.said.replaceChildren(el("div", { class: "h-card h-notice", role: "alert", "data-testid": "missions-error" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "Missions did not load"), el("span", { class: "h-2" }, answer.text || "Server did not answer in 5 s. STOP still works."), el("button", { type: "button", class: "h-btn", onclick: () => this.load(true) }, icon("refresh", "m"), "Try again")));
        return;
      }
      this.missions = list(answer, "missions");
      this.draw();
      const opened = this.missions.find((one) => one.id === this.chosen);
      if (opened && !this.form && opened.updated_utc !== this.shown) this.open(opened.id);
      if (!this.chosen && !this.form && this.missions.length && innerWidth >= 900) this.open(this.missions[0].id);
    }

    draw() {
      const words = this.search.value.trim().toLowerCase();
      this.filters.replaceChildren(...HL.missionsBulk.chips(this.group, this.missions, (group) => ((this.group = group), this.draw())));
      const found = this.missions.filter((one) => HL.missionsBulk.isIn(this.group, one) && (!words || `${one.name} ${one.field_name} ${robotName(one.robot_id)} ${one.status}`.toLowerCase().includes(words)));
      const picked = this.picked === null ? [] : this.missions.filter((one) => this.picked.has(one.id));
      this.bulk.replaceChildren(...(this.picked === null ? [] : [HL.missionsBulk.bar(picked, this.may, () => (this.select(false), this.load(false)))]));
      this.said.replaceChildren(...(this.missions.length ? (found.length ? [] : [empty("Nothing found", words ? "No mission has these words." : "No mission is there now.")]) : [el("div", { "data-testid": "missions-empty" }, empty("No missions yet", this.may.edit ? "Plan a mission" : this.dataset.noEdit))]));
      for (const one of found) {
        if (!this.rows.has(one.id)) this.rows.set(one.id, new Row(one, (id) => this.leaving(() => this.open(id)), (id, isOn) => this.pick(id, isOn)));
        this.rows.get(one.id).paint(one, one.id === this.chosen, this.picked === null ? null : this.picked.has(one.id));
      }
      this.list.replaceChildren(...found.map((one) => this.rows.get(one.id).node));
    }

    close() {
      this.form = null;
      this.chosen = "";
      this.shown = "";
      if (this.dataset.tab === "plan") this.showTab("list");
      attr(this, "data-open", null);
      this.detail.replaceChildren();
      this.draw();
    }

    async open(id) {
      const isSame = id === this.chosen;
      if (this.dataset.tab === "plan") this.showTab("list");
      this.chosen = id;
      this.form = null;
      attr(this, "data-open", "yes");
      this.draw();
      if (!isSame) this.detail.replaceChildren(el("div", { class: "h-card h-skeleton", "aria-label": "Loading" }, el("i"), el("i"), el("i")));
      const isDraft = this.missions.find((one) => one.id === id)?.status === "draft";
      const [answer, shape] = await Promise.all([HL.port.api("GET", of(id)), isDraft ? { ok: false } : HL.port.api("GET", `${of(id)}/map.geojson`)]);
      if (!this.isConnected || this.chosen !== id || this.form) return;
      if (!answer.ok) return this.detail.replaceChildren(el("div", { class: "h-card h-notice", role: "alert" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "Mission did not load"), el("span", { class: "h-2" }, answer.text), el("button", { type: "button", class: "h-btn", onclick: () => this.open(id) }, icon("refresh", "m"), "Try again")));
      this.shown = answer.data.updated_utc;
      this.detail.replaceChildren(...this.parts(answer.data, shape.ok ? shape.data : null));
    }

    parts(mission, shape) {
      const result = el("div", { class: "h-t14 h-b", role: "status", "data-testid": "mission-result" });
      const back = el("button", { type: "button", class: "h-btn q ico h-mback", "aria-label": "All missions", onclick: () => this.close() }, icon("arrow_back"));
      const head = el("div", { class: "h-row" }, back, el("div", { class: "h-sp" }, el("h2", { "data-testid": "mission-name" }, mission.name), el("div", { class: "h-t14 h-2" }, [mission.field_name, robotName(mission.robot_id)].filter(Boolean).join(" · "))), el("span", { class: look(mission.status), "data-testid": "mission-status", "data-state": mission.status }, HL.plan.status(mission.status)), ...this.edits(mission));
      const happened = HL.records.table(["Time", "State", "By", "Why"], (mission.log ?? []).toReversed().map((one) => ({ cells: [when(one.utc), HL.plan.status(one.status), one.by, outcome(one)] })));
      if (mission.wish) return [head, ...HL.planner.draftDetail(mission, this.may.edit, () => this.plan(mission)), el("h3", { class: "h-t16 h-b" }, "What happened"), happened];
      return [
        head,
        el("div", { class: "h-row h-wrap" }, ...this.buttons(mission, result), el("span", { class: "h-t13 h-2" }, !this.may.send ? this.dataset.noSend : isUnderWay(mission) ? "" : "Sending does not move the robot.")),
        result,
        ...HL.missionWays(mission, this.may.send, () => this.load(false)),
        el("div", { class: "h-mpicture" }, shape ? HL.fieldPicture(shape, `${mission.name}, ${mission.field_name}`) : el("div", { class: "h-notice" }, "The picture did not load.")),
        Object.keys(mission.statistics ?? {}).length ? HL.plan.cards(mission.statistics) : "",
        ...HL.planner.place(mission.statistics ?? {}),
        ...(mission.statistics?.notes ?? []).map((note) => el("div", { class: "h-row h-t14 h-b" }, icon("warning", "m"), note)),
        el("div", { class: "h-row" }, el("h3", { class: "h-t16 h-b h-sp" }, "What happened"), WORKED.includes(mission.status) && mission.robot_id ? el("a", { class: "h-btn", href: `/supervisor/${mission.robot_id}?mission=${encodeURIComponent(mission.id)}`, "data-testid": "mission-state-times" }, icon("account_tree", "m"), "State times") : ""),
        happened,
      ];
    }

    buttons(mission, result) {
      const robots = Object.entries(HL.port.fleet()).filter(([, robot]) => robot.is_registered !== false);
      const target = el("select", { class: "h-select", "aria-label": "Robot", "data-testid": "mission-robot" }, ...robots.map(([id, robot]) => el("option", { value: id }, robot.name)));
      if (robots.some(([id]) => id === mission.robot_id)) target.value = mission.robot_id;
      const label = () => [icon("route", "m"), `Send to ${robotName(target.value || mission.robot_id)}`];
      const isOnRobot = ["sent", "accepted", "running", "paused", "resuming"].includes(mission.status);
      const send = el("button", { type: "button", class: isOnRobot ? "h-btn" : "h-btn pri", "data-testid": "plan-send", disabled: !this.may.send, onclick: () => this.send(mission, target.value || mission.robot_id, send, result) }, ...label());
      const byCloud = el("button", { type: "button", class: "h-btn", "data-testid": "plan-send-cloud", disabled: !this.may.send, onclick: () => this.send(mission, target.value || mission.robot_id, byCloud, result, "cloud") }, icon("cloud", "m"), "Send through the cloud");
      const battery = el("span", { class: "h-t14", role: "status", "data-testid": "mission-battery" });
      target.addEventListener("change", () => (send.replaceChildren(...label()), this.battery(mission, target.value, battery)));
      this.battery(mission, target.value || mission.robot_id, battery);
      const operate = el("a", { class: "h-btn pri", href: `/operate/${mission.robot_id}`, "data-testid": "mission-operate" }, icon("gamepad", "m"), "Operate");
      if (isUnderWay(mission)) return [operate];
      const isQueued = ["queued", "waiting"].includes(mission.status);
      const queue = isQueued
        ? el("button", { type: "button", class: "h-btn", "data-testid": "mission-show-queue", onclick: () => this.tab("queue") }, icon("schedule", "m"), "Show in queue")
        : el("button", { type: "button", class: "h-btn", "data-testid": "mission-add-to-queue", disabled: !this.may.send || isOnRobot, onclick: () => HL.queue.add(mission).then((entry) => entry && this.load(false)) }, icon("add", "m"), "Add to queue");
      return [isOnRobot ? operate : "", robots.length > 1 ? target : "", send, this.dataset.hasCloud ? byCloud : "", queue, battery];
    }

    // of the robot that is chosen, not of the one it was planned for
    async battery(mission, robot, node) {
      node.robot = robot;
      if (!robot || !mission.statistics?.battery_share) return text(node, "");
      const answer = await HL.port.api("GET", `${of(mission.id)}/battery?robot=${encodeURIComponent(robot)}`);
      if (node.robot !== robot) return null; // another one was chosen meanwhile
      if (node.isConnected || answer.ok) attr(node, "data-state", answer.data?.is_enough === false ? "short" : null);
      return text(node, answer.ok ? answer.data.text : "");
    }

    // signs only, beside the name: what is done with a mission every day stands in words below
    edits(mission) {
      const edit = (name, run, sign) => el("button", { type: "button", class: "h-btn ico", "data-testid": `mission-${name.toLowerCase()}`, disabled: !this.may.edit, title: name, "aria-label": `${name} ${mission.name}`, onclick: run }, icon(sign, "m"));
      return [
        edit("Copy", () => this.change(HL.port.api("POST", `${of(mission.id)}/copy`, {}), "Copied"), "content_copy"),
        edit("Rename", () => this.rename(mission), "edit"),
        edit("Delete", () => this.remove(mission), "delete"),
      ];
    }

    async send(mission, robot, button, result, way = "direct") {
      button.disabled = true;
      text(result, `Sending to ${robotName(robot)}${way === "cloud" ? " through the cloud. Its robot asks once a second" : ""}`);
      const answer = await HL.port.sendMission(robot, mission.id, way);
      button.disabled = false;
      const isTaken = answer.outcome === "accepted";
      attr(result, "data-state", answer.outcome ?? "unknown");
      const isKnown = answer.outcome === "rejected" || (!answer.outcome && answer.status >= 400 && answer.status < 500);
      const failed = `${isKnown ? "Not sent" : "Not known whether it arrived"}: ${answer.text || "no answer. Look at the robot before you send again."}`;
      text(result, isTaken ? answer.text : failed);
      const how = answer.way === "cloud" ? ` It went through the cloud in ${answer.took_s.toFixed(1)} s.` : "";
      HL.toast(isTaken ? `${robotName(robot)} has ${mission.name}. It does not move yet.${how}` : failed, isTaken ? "check" : "block");
      this.load(false);
    }

    async change(asked, done) {
      const answer = await asked;
      if (!answer.ok) return HL.toast(`Not saved: ${answer.text || "no answer"}`, "block");
      HL.toast(done, "check");
      if (answer.data?.id) this.chosen = answer.data.id;
      await this.load(false);
      if (answer.data?.id) this.open(answer.data.id);
      return answer;
    }

    rename(mission) {
      const input = el("input", { class: "h-input", maxlength: "80", autofocus: true, "data-testid": "mission-newname" });
      input.value = mission.name;
      HL.sheet({ title: `Rename ${mission.name}`, body: [el("label", { class: "h-field" }, "Name", input)], buttons: [["Keep it", (close) => close()], ["Rename", (close) => input.value.trim() && (close(), this.change(HL.port.api("PATCH", of(mission.id), { name: input.value.trim() }), "Renamed")), true]] });
    }

    remove(mission) {
      const really = async (close) => {
        close();
        const answer = await HL.port.api("DELETE", of(mission.id));
        if (!answer.ok) return HL.toast(`Not deleted: ${answer.text || "no answer"}`, "block");
        HL.toast("Deleted", "check");
        this.close();
        this.load(false);
      };
      HL.sheet({ title: `Delete ${mission.name}?`, body: [el("p", { class: "h-2 h-t16" }, "It is not on a robot. It cannot be brought back.")], buttons: [["Keep it", (close) => close()], ["Delete", really, true]] });
    }

    // draft: to go on with, else a new mission
    async plan(draft = null) {
      this.showTab("plan");
      this.chosen = "";
      this.form = {};
      attr(this, "data-open", "yes");
      this.draw();
      this.detail.replaceChildren(el("div", { class: "h-card h-row" }, icon("hourglass_top"), "Loading fields"));
      const [places, robots] = await Promise.all([HL.port.api("GET", "/fields"), HL.port.api("GET", "/robots")]);
      if (!this.isConnected || !this.form) return;
      if (!places.ok || !robots.ok) return this.detail.replaceChildren(el("div", { class: "h-card h-notice", role: "alert" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "Fields did not load"), el("button", { type: "button", class: "h-btn", onclick: () => this.plan(draft) }, icon("refresh", "m"), "Try again")));
      if (!places.fields.length) HL.toast("No fields yet. Draw or import one; until then a mission can be kept as a draft.", "info");
      this.form = new HL.MissionForm({ fields: places.fields, homes: places.homes, areas: places.areas, robots: list(robots, "robots").filter((one) => one.is_registered !== false) }, { close: () => this.close(), queue: () => this.tab("queue"), stored: (mission, isSending) => this.stored(mission, isSending), kept: (mission) => this.kept(mission) }, this.may.send, draft);
      this.detail.replaceChildren(this.form.node);
    }

    async kept(draft) {
      this.form = null;
      await this.load(false);
      this.open(draft.id);
    }

    async stored(mission, isSending) {
      this.form = null;
      this.chosen = mission.id;
      HL.toast(`${mission.name} is stored`, "check");
      if (isSending) await this.send(mission, mission.robot_id, el("button"), el("div"));
      await this.load(false);
      this.open(mission.id);
    }
  }

  function outcome(entry) {
    const { row, rows, area_done_m2: area } = entry.data ?? {};
    if (rows === undefined) return entry.why;
    const done = HL.units.area(area ?? 0);
    return `${entry.why} Row ${row} of ${rows}, ${done.text} ${done.unit}.`;
  }

  // its style sheet comes with the screen; drawn before it is there, everything would jump
  function styled(node) {
    const href = node?.dataset.style;
    if (!href || document.querySelector(`link[href="${href}"]`)) return Promise.resolve();
    const link = el("link", { rel: "stylesheet", href });
    document.head.append(link);
    return new Promise((resolve) => (link.onload = link.onerror = resolve));
  }

  styled(document.querySelector("hl-missions")).then(() => define("hl-missions", Missions));
})();
