// Planning a mission: robot, field and treatment; row orders compared on the map; then stored, or stored and sent.
(() => {
  "use strict";
  const { el, icon, attr, text } = HL;
  const { Inputs, Treatment, Step, Picture, Path, Scrubber, Compare } = HL.planner;
  const PLAN_LIMIT_MS = 130000; // the planner here gives up after 60 s and says so; a planner service is asked before

  const sheets = new Map();
  function loadSheet(href) {
    if (!sheets.has(href)) {
      sheets.set(href, new Promise((resolve) => {
        const link = el("link", { rel: "stylesheet", href, onload: () => resolve(), onerror: () => (sheets.delete(href), link.remove(), resolve()) });
        document.head.append(link);
      }));
    }
    return sheets.get(href);
  }

  class MissionForm {
    // places: {fields, homes, robots, areas?}; actions: {stored(mission, isSent), kept(draft), close}; draft: to go on with
    constructor(places, actions, maySend, draft = null) {
      this.places = places;
      this.actions = actions;
      this.maySend = maySend;
      this.answers = new Map();
      this.shown = null;
      this.planned = null;
      this.draft = draft;
      this.inputs = new Inputs(places, draft);
      this.treatment = new Treatment(places.areas ?? [], {
        draw: (done, ended) => this.picture.drawArea(done, ended),
        changed: () => (this.picture.showAreas(this.treatment.pictured()), this.steps.treatment.tell(this.treatment.summary()), this.changed()),
      }, draft);
      if (draft) this.treatment.apply(draft.wish);
      this.keeper = new HL.planner.DraftKeeper(this, (kept) => this.actions.kept(kept));
      this.node = this.build();
      this.follow();
      this.outline();
      this.paint();
      this.keeper.begin();
      const style = document.querySelector("hl-missions")?.dataset.planStyle;
      if (style) {
        this.node.hidden = true;
        loadSheet(style).then(() => (this.node.hidden = false));
      }
    }

    build() {
      const input = (name) => this.inputs.get(name);
      this.problem = el("div", { class: "h-error", role: "alert", "data-testid": "plan-error" });
      this.previewButton = el("button", { class: "h-btn op pri p-preview", type: "submit", "data-testid": "plan-preview" });
      this.mend = el("div", { class: "h-col", hidden: true }, el("button", { type: "button", class: "h-btn", "data-testid": "plan-start-at-field", onclick: () => (this.inputs.startAtField(), this.look()) }, "Start at the field"));
      this.steps = {
        robot: new Step(1, "Robot and home", "robot", ...this.inputs.where(), this.mend),
        field: new Step(2, "Field", "field", input("field_id")),
        treatment: new Step(3, "Treatment", "treatment", this.treatment.node),
        preview: new Step(4, "Preview", "preview", ...this.inputs.how()),
        send: new Step(5, "Send", "send"),
      };
      this.steps.send.tell("Sending does not move the robot.");
      this.form = el("form", { class: "p-steps", novalidate: true, onsubmit: (event) => (event.preventDefault(), this.isPlanning ? this.cancel() : this.look()) },
        el("div", { class: "h-row h-wrap p-title" }, el("button", { type: "button", class: "h-btn q ico", "aria-label": "Back to the missions", onclick: () => this.leave() }, icon("arrow_back")), el("h2", { class: "h-sp h-ell", "data-testid": "plan-title" }, this.draft?.name ?? "Plan a mission"), el("span", { class: "h-row" }, this.keeper.button, el("button", { type: "button", class: "h-btn", "data-testid": "plan-templates", onclick: () => HL.planner.templates.choose((one) => this.apply(one)) }, "Templates"))),
        ...Object.values(this.steps).map((step) => step.node),
        el("div", { class: "p-go" }, this.problem, this.previewButton)); // in sight wherever the form is scrolled to
      this.picture = new Picture();
      this.scrubber = new Scrubber((t) => this.picture.place(t));
      this.picture.node.append(this.scrubber.node);
      this.compare = new Compare((pattern) => this.show(pattern, true));
      this.numbers = el("div", { class: "p-numbers" });
      this.checks = el("hl-plan-checks", { class: "p-checks" });
      this.checks.onLeave = () => this.end(); // whoever goes to another screen frees the planner
      this.notes = el("div", { class: "p-notes" });
      this.side = el("aside", { class: "p-side", "aria-label": "Numbers of the plan", hidden: true }, this.numbers, this.notes, this.compare.node, this.checks);
      this.strip = new HL.planner.QueueStrip(() => this.actions.queue?.());
      this.strip.enter();
      return el("div", { class: "p-plan" }, this.form, this.picture.node, this.side, this.strip.node, this.dock());
    }

    dock() {
      const button = (hook, sign, word, look, run) => el("button", { type: "button", class: `h-btn op ${look}`, "data-testid": hook, onclick: run }, sign ? icon(sign, "m") : "", word);
      this.sendWord = el("span");
      this.backWord = el("span", { class: "p-backword" });
      this.sendButton = button("plan-send", "route", this.sendWord, "pri", () => this.store("send"));
      this.storeButton = button("plan-store", "check", "Store", "", () => this.store(""));
      this.queueButton = HL.queue?.add ? button("plan-queue", "add", "Add to queue", "", () => this.store("queue")) : "";
      this.templateButton = button("plan-template", "", "Save as template", "q", () => HL.planner.templates.save(this.wish(), this.inputs.get("name").value.trim() || this.inputs.fieldPlace?.name || ""));
      this.dockHint = el("span", { class: "h-t13 h-2 p-hint", "data-testid": "plan-hint" });
      return el("div", { class: "p-dock", role: "toolbar", "aria-label": "Plan" }, button("plan-back", "arrow_back", this.backWord, "", () => (this.shown ? this.steps.treatment.open() : this.leave())), this.sendButton, this.storeButton, this.queueButton, this.templateButton, el("span", { class: "h-sp" }), this.dockHint);
    }

    // what is typed is kept, and a plan that no longer fits is not sent
    follow() {
      this.inputs.get("field_id").addEventListener("change", () => ((this.inputs.isFieldChosen = true), this.newField()));
      this.inputs.get("robot_id").addEventListener("change", () => (this.inputs.offerField() ? this.newField() : (this.inputs.offerWidth(), this.outline())));
      this.inputs.offerField();
      if (!this.inputs.isKept) this.inputs.offerWidth();
      this.form.addEventListener("input", () => this.changed());
      this.treatment.follow(this.inputs.fieldPlace);
      this.steps.treatment.fold(this.treatment.summary());
    }

    newField() {
      this.inputs.offerWidth();
      this.treatment.follow(this.inputs.fieldPlace);
      this.picture.areas = this.treatment.pictured();
      this.outline();
      this.changed();
    }

    wish() {
      const attended = this.draft?.wish.is_supervised === undefined ? {} : { is_supervised: this.draft.wish.is_supervised };
      return { ...this.inputs.wish(), ...this.treatment.wish(), ...attended };
    }

    // everything but the row order: candidates are of one such wish
    ground() {
      const { pattern, name, ...rest } = this.wish();
      return JSON.stringify(rest);
    }

    changed() {
      this.inputs.keep();
      this.refusal = "";
      this.mend.hidden = true;
      const pattern = this.inputs.get("pattern").value;
      if (this.planned === this.ground() && this.answers.get(pattern)?.state !== undefined) this.show(pattern, false);
      this.paint();
    }

    get isFresh() {
      return this.planned !== null && this.planned === this.ground() && this.answers.get(this.shown)?.state === "planned" && this.inputs.get("pattern").value === this.shown;
    }

    look() {
      this.cancel();
      text(this.problem, this.treatment.problem());
      this.refusal = "";
      if (this.treatment.problem()) return this.steps.treatment.open();
      const missing = this.inputs.missing();
      if (missing) return this.refused({ field: missing[0], text: missing[1] });
      this.answers = new Map();
      this.shown = null;
      this.planned = this.ground();
      this.isPlanning = true;
      this.step = null;
      this.begunAt = performance.now();
      clearInterval(this.ticker);
      this.ticker = setInterval(() => this.tick(), 1000);
      this.stop = HL.planner.compare(this.wish(), {
        line: (answer) => this.heard(answer),
        failed: (refusal) => this.refused(refusal),
        ended: () => ((this.isPlanning = false), this.paint()),
      });
      this.paint();
    }

    cancel() {
      this.stop?.();
      this.stop = null;
      if (this.isPlanning) this.planned = this.answers.size ? this.planned : null;
      this.isPlanning = false;
      this.paint();
    }

    // a second more of planning: only words change, so that a tap on a row is never lost
    tick() {
      if (!this.isPlanning || !this.node.isConnected) return clearInterval(this.ticker);
      this.compare.progress(this.answers.size, this.plannedForS(), this.step);
      return this.picture.say(this.said());
    }

    plannedForS() {
      return Math.floor((performance.now() - this.begunAt) / 1000);
    }

    // over the picture: what is under way, what went wrong, or that the plan is of before the last change
    said() {
      const isStale = this.shown !== null && !this.isFresh;
      if (this.isPlanning) return this.shown ? "" : HL.planner.planningWords(this.inputs.get("pattern").value, this.answers.size, this.plannedForS(), this.step);
      return this.refusal ? `Not planned. ${this.refusal}` : isStale ? "Changed. Preview again." : "";
    }

    heard(answer) {
      if (!answer.pattern) return;
      if (answer.state === "progress") return this.hearProgress(answer);
      this.step = null;
      this.answers.set(answer.pattern, answer);
      const wished = this.inputs.get("pattern").value;
      if (answer.pattern === wished && answer.state === "planned") this.show(wished, false);
      else if (answer.pattern === wished) this.refused(answer.state === "same" ? { text: "" } : answer, answer);
      this.paint();
    }

    // a planner that tells how far it is; only words change
    hearProgress(answer) {
      this.step = answer;
      this.compare.progress(this.answers.size, this.plannedForS(), answer);
      this.picture.say(this.said());
    }

    // answer: given when a row order, not the wish, was refused
    refused(refusal, answer) {
      if (answer?.state === "same") return this.show(answer.as, true);
      if (!answer) this.planned = this.answers.size ? this.planned : null;
      text(this.problem, refusal.text || "Not planned: the server did not answer. Try again.");
      this.refusal = this.problem.textContent;
      this.mend.hidden = refusal.code !== "home_unreachable";
      const input = refusal.field ? this.inputs.get(refusal.field) : null;
      const step = ["robot_id", "home", "home_id"].includes(refusal.field) ? this.steps.robot : refusal.field === "field_id" ? this.steps.field : refusal.field?.startsWith("treatment") ? this.steps.treatment : this.steps.preview;
      step.open();
      input?.focus?.();
      this.paint();
    }

    // a candidate into the picture; isChosen: by hand in the comparison
    show(pattern, isChosen) {
      let answer = this.answers.get(pattern);
      if (answer?.state === "same") answer = this.answers.get((pattern = answer.as));
      if (isChosen || answer?.pattern !== this.inputs.get("pattern").value) this.inputs.get("pattern").value = pattern;
      this.inputs.keep();
      text(this.problem, answer?.state === "refused" ? answer.text : "");
      if (answer?.state !== "planned") return this.paint();
      this.refusal = "";
      const isOther = this.shown !== pattern || this.drawn !== answer;
      this.shown = pattern;
      this.drawn = answer;
      if (isOther) {
        this.draw(answer);
        this.foldAll();
        if (!isChosen) this.node.scrollIntoView({ block: "start" }); // on a narrow screen the picture is above the inputs
      }
      this.paint();
    }

    draw({ drawing, statistics }) {
      const path = new Path(drawing);
      this.picture.draw(drawing, path, statistics);
      this.scrubber.load(path);
      this.numbers.replaceChildren(HL.planner.cards(statistics), HL.planner.energy(statistics));
      this.notes.replaceChildren(...HL.planner.place(statistics), ...(statistics.notes ?? []).map((note) => el("div", { class: "h-row h-t14 h-b" }, icon("warning", "m"), note)));
      this.strip.follow(this.inputs.robot, statistics);
      this.checks.set({ robot: this.inputs.get("robot_id").value, name: this.inputs.robot?.name ?? "The robot", statistics });
    }

    foldAll() {
      const { robot, home, fieldPlace } = this.inputs;
      const s = this.drawn?.statistics;
      this.steps.robot.fold(`${robot?.name ?? "Robot"}, ${home?.name ?? "its own home or the nearest"}`);
      this.steps.field.fold([fieldPlace?.name ?? "Field", s ? `${s.rows} rows${HL.planner.ALONG[s.rows_along] ?? ""}` : ""].filter(Boolean).join(", "));
      this.steps.treatment.fold(this.treatment.summary());
    }

    // the field alone, as long as there is no plan
    outline() {
      this.words();
      this.picture.areas = this.treatment.pictured();
      if (this.shown) return;
      const geometry = this.inputs.fieldPlace?.geometry;
      const rings = geometry?.type === "Polygon" ? geometry.coordinates : geometry?.coordinates?.[0];
      if (!rings) return this.picture.draw({ legs: [], places: { parcel: [] } }, null, null);
      const [lon0, lat0] = rings[0][0];
      const scale = 111320 * Math.cos((lat0 * Math.PI) / 180);
      const frame = { xy_m: [0, 0], lon_lat: [lon0, lat0], degrees_per_m: [[1 / scale, 0], [0, 1 / 111320]] };
      this.picture.draw({ frame, legs: [], places: { parcel: rings.map((ring) => ring.map(([lon, lat]) => [(lon - lon0) * scale, (lat - lat0) * 111320])) } }, null, null);
    }

    words() {
      text(this.sendWord, `Send to ${this.inputs.robot?.name ?? "robot"}`);
      this.inputs.offerSpacing();
      this.inputs.offerRows();
      this.strip.follow(this.inputs.robot, this.drawn?.statistics ?? null);
      HL.port.follow(this.inputs.get("robot_id").value || null, "plan");
    }

    paint() {
      const isFresh = this.isFresh;
      const isStale = this.shown !== null && !isFresh && !this.isPlanning;
      this.previewButton.replaceChildren(icon(this.isPlanning ? "cancel" : "visibility", "m"), this.isPlanning ? "Cancel planning" : isStale ? "Preview again" : "Preview");
      attr(this.previewButton, "data-state", this.isPlanning ? "planning" : isFresh ? "fresh" : "ready");
      this.previewButton.classList.toggle("pri", !isFresh && !this.isPlanning);
      this.storeButton.disabled = !isFresh || this.isStoring;
      this.sendButton.disabled = !isFresh || !this.maySend || this.isStoring;
      if (this.queueButton) this.queueButton.disabled = !isFresh || this.isStoring;
      this.side.hidden = !this.answers.size && !this.isPlanning;
      attr(this.node, "data-state", isFresh ? "fresh" : isStale ? "stale" : "none");
      this.compare.paint(this.answers, this.shown, this.isPlanning);
      if (this.isPlanning) this.compare.progress(this.answers.size, this.plannedForS());
      this.picture.say(this.said());
      text(this.backWord, this.shown ? "Treatment" : "Missions");
      attr(this.dockHint, "data-state", isFresh && this.maySend ? "fresh" : "off");
      text(this.dockHint, !this.maySend ? "Sending needs the operator role." : isFresh ? "The person on site starts it with a slide." : this.isPlanning ? "" : "Preview first.");
    }

    // what: "", "send" or "queue"
    async store(what) {
      if (!this.isFresh) return this.look();
      this.isStoring = true;
      this.paint();
      const answer = await HL.port.api("POST", "/missions/plan", { ...this.wish(), ...this.ofDraft() }, PLAN_LIMIT_MS);
      this.isStoring = false;
      this.paint();
      if (!answer.ok) return this.refused(answer);
      this.inputs.forget();
      this.treatment.forget();
      this.end();
      this.actions.stored(answer.data, what === "send");
      if (what === "queue") HL.queue.add(answer.data);
    }

    // which draft becomes the mission, as it was when it was opened
    ofDraft() {
      return this.draft ? { draft_id: this.draft.id, draft_revision: this.draft.revision } : {};
    }

    apply(template) {
      this.inputs.apply(template.wish);
      this.treatment.apply(template.wish);
      this.treatment.follow(this.inputs.fieldPlace);
      this.steps.treatment.tell(this.treatment.summary());
      this.outline();
      this.changed();
      HL.toast(`${template.name} is applied`, "check");
    }

    leave() {
      this.keeper.leave(() => (this.end(), this.actions.close()));
    }

    end() {
      this.cancel();
      this.scrubber.pause();
      this.strip.leave();
      HL.port.follow(null, "plan");
    }
  }

  HL.MissionForm = MissionForm;
})();
