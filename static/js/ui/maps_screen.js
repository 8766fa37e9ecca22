// The screen Maps: the published map to look at, or its draft with everything that changes it.
(() => {
  "use strict";
  const { el, icon, text, attr, define } = HL;
  const M = HL.maps;
  const CHECK_MS = 400; // changes come close together
  const LATE_MS = 5000;
  const LOOK_MS = 30000; // who looks on sees the draft of others come and go

  class Maps extends M.MapEdits {
    build() {
      this.may = { edit: this.dataset.mayEdit === "yes", take: this.dataset.mayTake === "yes" };
      this.chosen = [];
      this.shownChoice = "";
      this.tool = "select";
      this.checks = null;
      this.client = new M.MapClient({ changed: () => this.changed(), replaced: () => this.replaced(), patched: (changes) => this.patched(changes), refused: (labels, why) => this.refused(labels, why), looked: (words) => HL.toast(words, "info") });
      const act = this.actions();
      this.tools = new M.Tools(act);
      this.bar = new M.Bar(act, { mayEdit: this.may.edit });
      this.hint = new M.Hint(act);
      this.panel = new M.FeaturePanel(act);
      this.reshape = new M.Reshape({
        trial: (op, ids, args) => this.trial(op, ids, args),
        operate: (op, ids, args, what) => this.operate(op, ids, args, what),
        show: (features) => this.editor?.setTrial(features),
        turning: (degrees) => this.editor?.setTurning(degrees),
        unlock: (isOn) => this.unlock(isOn),
        isUnlocked: () => Boolean(this.isUnlocked),
      });
      this.checkList = new M.Checks({ robot: () => this.check(), fix: (one) => this.operate(one.fix.op, one.fix.features, one.fix.args, one.fix.label), show: (one) => this.show([one.feature_id, one.other_id]) });
      this.changes = new M.Changes();
      this.cloud = new M.CloudWishes({ client: this.client, mayEdit: this.may.edit, reason: () => this.dataset.noEdit, look: (features, trial) => this.look(features, trial) });
      this.dock = new M.Dock(act);
      this.chips = new M.Chips(act, this.dataset.farm);
      this.walk = new M.Walk({ finished: (kind, places, accuracy, robot) => this.walked(kind, places, accuracy, robot) }, this.dataset.farm);
      this.surface = new M.Surface({ scripts: this.dataset.scripts, vendor: this.dataset.vendor }, this.told());
      this.file = el("input", { type: "file", hidden: true, accept: M.ACCEPT, "data-testid": "import-file", onchange: () => this.picked() });
      this.status = el("div", { class: "h-card m-status h-t13", hidden: true, "data-testid": "editor-place" });
      this.notice = el("div", { class: "m-notice" });
      this.field = el("div", { class: "m-map", "aria-label": "Map" }, this.surface.node, this.hint.node, this.walk.node, this.status, this.notice, this.file);
      this.side = el("aside", { class: "m-side", "aria-label": "Details" }, this.cloud.node, this.reshape.node, this.panel.node, this.checkList.node, this.changes.node);
      this.append(this.chips.node, el("div", { class: "m-work" }, this.bar.node, this.tools.column, this.field), this.side, this.dock.node);
      this.drops();
      this.addEventListener("headland:base-maps", () => this.baseMaps());
    }

    enter() {
      this.onKey = (event) => this.key(event);
      document.addEventListener("keydown", this.onKey);
      this.unsubscribe = [window.headland?.on("event", (event) => event?.kind === "map" && (event.what === "proposals" ? this.cloud.load() : this.client.isEditing ? this.stillMine() : this.lookAgain())), window.headland?.on("link", (state) => state === "ok" && this.client.queue.length && this.client.flush())];
      this.timer = setInterval(() => this.lookAgain(), LOOK_MS);
      this.load();
      this.cloud.load();
    }

    leave() {
      document.removeEventListener("keydown", this.onKey);
      this.unsubscribe.forEach((end) => end?.());
      clearInterval(this.timer);
      clearTimeout(this.checkTimer);
      this.walk.leave();
      this.surface.destroy();
    }

    paint() {
      if (!this.client.published) return;
      this.walk.look();
      this.dock.paintRunning();
      this.chips.paint(this.client);
    }

    // ---- what the parts may ask for

    actions() {
      const { client } = this;
      return {
        tool: (name) => name === this.tool && this.editor?.isDrawing || this.leaving(() => this.take(name)), // the tool in hand again: its drawing goes on
        undo: () => this.step("undo"),
        redo: () => this.step("redo"),
        snap: (isOn) => this.editor?.setSnap(isOn),
        layers: () => this.replaced(),
        walk: () => this.walk.open(),
        pick: () => this.file.click(),
        baseMaps: () => this.baseMaps(),
        versions: () => M.showVersions(client.published.version, { mayEdit: this.may.edit && !this.lockReason(), reason: this.lockReason() || this.dataset.noEdit, restore: (version) => this.restore(version) }),
        undoPoint: () => this.editor?.undoPoint(),
        finish: () => this.editor?.finish(),
        merge: () => this.merge(),
        commit: (label, changes) => this.commit(label, changes),
        select: (ids) => this.select(ids),
        fit: (ids) => this.surface.fit(ids),
        copy: () => this.copy(),
        remove: () => this.remove(),
        nudge: (x, y) => this.editor?.nudge(x, y),
        removeVertex: () => this.editor?.removeVertex(),
        setVertex: (place) => this.editor?.setVertex(place),
        unlockBody: (isOn) => this.unlock(isOn),
        reshape: (id) => this.reshape.open(id, client.features.get(id)),
        history: (id) => this.history(id),
        pen: (name) => this.another(name),
        radius: (metres) => this.editor?.setRadius(metres) ?? false,
        several: (isOn) => this.several(isOn),
        publish: () => M.askPublish(client, { done: (version) => (HL.toast(`v${version} is published`, "check"), this.check()), checked: (found) => this.found(found) }),
        checks: () => this.checkList.node.scrollIntoView({ block: "start" }), // they may lie below a long list of fields
        compare: () => M.showDifferences(client.baseVersion, { show: (one) => this.showDifference(one) }),
        discard: () => M.askDiscard(client, () => HL.toast("Draft discarded", "check")),
        edit: () => this.open(false),
        take: () => this.open(true),
        unsaved: () => M.showUnsaved(client.queue.items, { drop: () => client.dropUnsaved() }),
      };
    }

    // brings features into sight, with others drawn over the map that are not on it
    look(features, trial) {
      if (features) this.surface.fit(features);
      this.editor?.setTrial(trial);
    }

    // what the drawing surface tells
    told() {
      return {
        onSelect: (ids) => { this.lockAgain(); this.chosen = [...ids]; this.point = this.corner(); this.changed(); },
        onTurn: (degrees) => this.reshape.turned(degrees),
        onChange: ({ label, changes }) => this.commit(label, changes, true),
        onMeasure: (words) => { this.measured = words; this.paintHint(); },
        onDrawn: (drawn) => this.drawn(drawn),
        onPoint: (place) => this.pointed(place),
        onNotice: (words) => words && HL.toast(words, "info"),
        onReady: () => this.ready(),
        isReadOnly: () => !this.client.isEditing,
        features: () => [...this.client.features.values()].filter((one) => this.bar.isShown(M.kindOf(one))),
      };
    }

    // where the pointer is, or the corner that was chosen; comes with every move of the mouse
    pointed(place) {
      attr(this.status, "hidden", !place);
      if (place) text(this.status, M.place(place));
      const corner = this.corner();
      if (String(corner) === String(this.point)) return;
      this.point = corner;
      this.reshape.corner(this.editor?.vertex?.index ?? null);
      this.changed();
    }

    corner() {
      return this.editor?.vertex?.position ?? null;
    }

    get editor() {
      return this.surface.editor;
    }

    // ---- loading and states

    async load() {
      this.say("loading");
      const late = setTimeout(() => !this.client.published && this.say("late"), LATE_MS);
      const answer = await this.client.load();
      clearTimeout(late);
      if (!this.isConnected) return;
      this.failure = answer.ok ? null : answer;
      this.changed();
      if (this.may.edit) this.walk.comeBack();
    }

    async lookAgain() {
      if (document.hidden || this.client.isEditing || !this.client.published || document.querySelector(".h-scrim")) return;
      const [version, editor] = [this.client.published.version, this.client.draft?.until_utc];
      const answer = await HL.port.api("GET", "/map");
      if (!answer.ok || !this.isConnected || this.client.isEditing) return;
      if (answer.version !== version || answer.draft?.until_utc !== editor) this.load();
      else this.client.state(answer.draft); // its lock may have run out
    }

    // somebody took the draft, threw it away or published
    async stillMine() {
      if (this.client.queue.length || this.client.isClosing) return; // its answer will tell
      const answer = await HL.port.api("GET", "/map");
      if (!answer.ok || !this.isConnected || answer.draft?.is_mine || !this.client.isEditing || this.client.isClosing) return;
      await this.client.load();
      HL.toast(answer.draft ? `${answer.draft.editor.name} edits the map now.` : "This draft is closed.", "lock");
    }

    say(state) {
      if (this.said === state) return;
      this.said = state;
      const version = this.client.published?.version;
      const again = el("button", { type: "button", class: "h-btn", onclick: () => this.load() }, icon("refresh", "m"), "Try again");
      const bars = () => [el("i"), el("i"), el("i")];
      const made = {
        loading: () => el("div", { class: "h-card h-skeleton m-loading", "data-testid": "maps-loading" }, el("span", { class: "h-t14 h-2" }, version ? `Loading map v${version}` : "Loading map"), ...bars()),
        late: () => el("div", { class: "h-card h-skeleton m-loading", "data-testid": "maps-loading" }, el("span", { class: "h-t14 h-2" }, "Loading map. It is large, or the link is slow."), ...bars()),
        error: () => el("div", { class: "h-card h-notice", role: "alert", "data-testid": "maps-error" }, icon("cloud_off", "l"), el("b", { class: "h-t18 h-b" }, "Map did not load"), el("span", { class: "h-2" }, this.failure.text || "Server did not answer. STOP still works."), again),
        kept: () => el("div", { class: "h-card m-kept", role: "alert", "data-testid": "maps-error" }, icon("cloud_off", "m"), el("span", { class: "h-b" }, `Map did not load. Showing v${version} from this tablet.`), again),
        empty: () => el("div", { class: "h-card h-notice m-empty", "data-testid": "maps-empty" }, el("b", { class: "h-t18 h-b" }, "No map yet"), el("span", { class: "h-2" }, this.may.edit ? "Draw a field, walk its edge, or import" : this.dataset.noEdit), this.may.edit ? el("div", { class: "h-row h-wrap" }, el("button", { type: "button", class: "h-btn pri", "data-testid": "empty-draw", onclick: () => this.start() }, icon("pentagon", "m"), "Draw a field"), el("button", { type: "button", class: "h-btn", onclick: () => this.file.click() }, icon("upload_file", "m"), "Import"), el("button", { type: "button", class: "h-btn", "data-testid": "empty-here", onclick: () => this.lookHere() }, icon("my_location", "m"), "Go to where I am")) : ""),
      }[state];
      this.notice.replaceChildren(...(made ? [made()] : []));
    }

    // a farm that has neither map nor robots yet lies anywhere
    async lookHere() {
      const { place, problem } = await M.tabletPlace();
      if (problem) return HL.toast(problem, "block");
      return this.surface.fit(M.groundAround([{ lon: place[0], lat: place[1] }]));
    }

    notices() {
      if (this.failure) return this.client.published ? "kept" : "error";
      if (!this.client.published) return "loading";
      return this.client.features.size || this.tool !== "select" ? "" : "empty";
    }

    // ---- the draft

    lockReason() {
      const { draft } = this.client;
      return M.isLocked(draft) && !draft.is_mine ? `${draft.editor.name} edits until ${M.clockOf(draft.until_utc)}.` : "";
    }

    editReason() {
      return this.client.isEditing ? "" : this.may.edit ? this.lockReason() || "Edit the map first." : this.dataset.noEdit;
    }

    publishReason() {
      const { client, checks } = this;
      const isNew = (client.draft?.log ?? []).some((one) => !one.is_undone);
      if (client.queue.length && !client.isSending) return `Not saved yet: ${M.count(client.queue.length, "change")}.`;
      if (client.unsure) return "An answer was lost. The map is loaded again first.";
      if (client.isOutdated) return `v${client.published.version} was published meanwhile: see Compare.`;
      if (checks?.blocks) return M.blockedWords(checks.blocks);
      if (!isNew && !client.queue.length) return "Nothing is changed yet.";
      return checks?.error ? "Not checked yet." : "";
    }

    async open(isTaking) {
      if (this.client.isEditing) return true;
      if (this.opening) return this.opening;
      this.opening = this.client.open(isTaking);
      const answer = await this.opening;
      this.opening = null;
      if (answer.ok) return true;
      const by = answer.by ?? answer.editor?.name;
      HL.toast(answer.code === "locked" && by ? `${by} edits until ${M.clockOf(answer.until_utc)}.` : answer.text || "The draft did not open. Try again.", "lock");
      this.lookAgain();
      return false;
    }

    async start() {
      if (await this.open(false)) this.take("parcel");
    }

    async restore(version) {
      const answer = await this.client.restore(version);
      if (!answer.ok) return HL.toast(M.notDone("Not restored", answer), "block");
      HL.closeSheet();
      return HL.toast(`The draft has the content of v${version}. Publish it to use it.`, "history");
    }

    commit(label, changes, isDrawn = false) {
      if (!this.client.isEditing) return;
      if (!isDrawn) this.editor?.patch(changes);
      this.client.commit(label, changes);
      this.checkSoon();
    }

    async step(way) {
      if (!this.client.isEditing || this.stepping) return;
      this.stepping = true;
      this.tell(await this.client[way](), way === "undo" ? "Not undone" : "Not redone");
      this.stepping = false;
    }

    async operate(op, ids, args, what) {
      const answer = await this.client.operate(op, ids, args);
      this.tell(answer, `${what}: not done`);
      return answer;
    }

    tell(answer, words) {
      if (answer && !answer.ok) HL.toast(M.notDone(words, answer), "block");
      else this.checkSoon();
    }

    // ---- after a change

    replaced() {
      this.chosen = this.chosen.filter((id) => this.client.features.has(id));
      if (!this.client.isEditing && !M.isFree(this.tool)) this.tool = "select";
      if (!this.client.isEditing || !this.client.features.has(this.reshape.id)) this.reshape.close();
      if (this.isConnected) this.surface.show(!this.client.isEditing);
      this.checkSoon();
    }

    patched(changes) {
      const shown = changes.filter(({ before, after }) => this.bar.isShown(M.kindOf(after ?? before)));
      this.editor?.patch(shown);
      this.chosen = this.chosen.filter((id) => this.client.features.has(id));
      if (!this.client.features.has(this.reshape.id)) this.reshape.close();
    }

    ready() {
      this.editor.setSnap(this.bar.isSnap);
      if (this.tool !== "select" && this.tool !== "merge") this.editor.setTool(this.pen ?? this.tool);
      if (this.chosen.length) this.editor.select(this.chosen);
      if (this.checks?.findings) this.editor.setFindings(this.checks.findings);
      this.changed(); // what this device can draw is known now
    }

    refused(labels, why) {
      if (labels.length) M.showRefused(labels, why);
      else HL.toast(why || "Somebody else edits the map now.", "lock");
      this.checkSoon();
    }

    checkSoon() {
      clearTimeout(this.checkTimer);
      this.checkTimer = setTimeout(() => this.check(), CHECK_MS);
    }

    async check() {
      if (!this.isConnected || !this.client.isEditing) return this.found(null);
      if (this.client.queue.length) return this.checkSoon(); // the server checks what it has
      const answer = await this.client.checks(this.checkList.robot);
      if (!this.isConnected || !this.client.isEditing) return undefined;
      return this.found(answer.ok ? { findings: answer.findings ?? [], blocks: answer.blocks ?? 0, looks: answer.looks ?? 0 } : { findings: [], error: answer.text });
    }

    found(checks) {
      this.checks = checks;
      this.editor?.setFindings(checks?.findings ?? []);
      this.changed();
    }

    changed() {
      const { client } = this;
      this.say(this.notices());
      attr(this, "data-state", client.isEditing ? "draft" : client.published ? "published" : "loading");
      attr(this, "data-features", client.features.size);
      if (!client.published) return;
      if (!this.shownChoice) this.listTop = this.side.scrollTop;
      const reason = this.editReason();
      const lock = this.lockReason();
      this.tools.paint(this.tool, reason, this.editor?.drawingReason ?? "");
      this.bar.paint({ undo: client.undoLabel, redo: client.redoLabel, reason, version: client.published.version, hasDraft: Boolean(client.draft), isEmpty: !client.features.size, isNew: !client.published.version });
      this.paintHint();
      this.panel.paint({ features: client.features, chosen: this.chosen, canEdit: client.isEditing, point: this.point, farm: this.dataset.farm, isSeveral: Boolean(this.isSeveral), isUnlocked: Boolean(this.isUnlocked), revision: client.revision });
      attr(this.checkList.node, "hidden", !client.isEditing);
      attr(this.changes.node, "hidden", !client.isEditing);
      this.checkList.paint(this.checks, client.isEditing, (id) => { const one = client.features.get(id); return one ? M.nameOf(one) : ""; });
      this.changes.paint(client.draft?.log, client.queue.items);
      this.dock.paint({
        isEditing: client.isEditing, reason: client.isEditing ? this.publishReason() : "", isBlocked: Boolean(this.checks?.blocks), next: client.nextVersion, base: client.baseVersion, isOutdated: client.isOutdated,
        edit: this.may.edit ? { label: client.draft && !lock ? "Continue draft" : "Edit map", reason: client.isKept ? "Not without the server." : lock, isOff: Boolean(lock) || Boolean(client.isKept) } : { label: "", reason: this.dataset.noEdit, isOff: true },
        canTake: this.may.edit && this.may.take && Boolean(lock),
      });
      this.chips.paint(client);
      this.cloud.follow();
      this.beginAtTop();
    }

    // another choice is read from its name on; the list of the farm stays where it was scrolled to
    beginAtTop() {
      const shown = this.chosen.join(" ");
      if (shown === this.shownChoice) return;
      this.shownChoice = shown;
      this.side.scrollTop = shown ? 0 : this.listTop;
    }

    paintHint() {
      this.hint.paint(this.tool, this.pen, this.measured, this.tool === "merge" ? this.mergeable().length : 0, this.editor ?? {});
    }

    key(event) {
      if (this.tools.key(event, this.client.isEditing)) event.preventDefault();
    }
  }

  M.loadSheet(document.querySelector("hl-maps")?.dataset.style ?? "").then(() => define("hl-maps", Maps), () => HL.toast("This screen did not load. Open it again.", "cloud_off"));
})();
