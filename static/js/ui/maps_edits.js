// What a person does to the features of a draft: tools, merge, holes and cuts, copy, delete, import. The screen builds on it.
(() => {
  "use strict";
  const M = HL.maps;
  const PREVIEW_MS = 15000;
  const ROAD_M = 4; // as a drawn road, until somebody says otherwise
  const COPY = " copy";
  const COPY_M = 8; // a copy lies beside its original, not on it

  // needs of the screen: client, editor, chosen, tool, changed(), commit(label, changes), operate(op, ids, args, what), open(isTaking)
  class MapEdits extends HL.LiveElement {
    take(name) {
      this.reshape.close();
      this.hideGone();
      if (this.tool === "merge" && name !== "merge") this.several(false);
      this.measured = "";
      if (name === "merge" && this.mergeable().length >= 2) return void this.merge();
      this.tool = name;
      this.pen = M.penOf(name);
      this.editor?.setTool(name === "merge" ? "select" : this.pen);
      if (name === "merge") this.several(true);
      this.changed();
    }

    // a drawing that is enough to be kept is not thrown away by going on to something else
    leaving(go) {
      if (!this.editor?.canFinish || this.tool === "measure") return void go();
      const finish = (close) => {
        close();
        this.editor?.finish();
        go();
      };
      HL.sheet({ title: "The drawing is not done", hook: "unfinished", body: [HL.el("p", { class: "h-t16" }, "Keep it as it is, or throw it away?")], buttons: [["Throw it away", (close) => (close(), go())], ["Done", finish, true]] });
    }

    // another of the things a tool can draw
    draw(pen) {
      this.pen = pen;
      this.measured = "";
      this.editor?.setTool(pen);
      this.changed();
    }

    // another way to draw with the same tool, which a finished drawing has put away
    another(pen) {
      const { tool } = this;
      this.leaving(() => {
        if (this.tool !== tool) this.take(tool);
        this.draw(pen);
      });
    }

    unlock(isOn) {
      this.isUnlocked = isOn;
      this.editor?.unlockBody(isOn);
      this.changed();
    }

    // what an operation would do, asked when the server has everything of ours
    async trial(op, ids, args) {
      await this.client.flush();
      if (this.client.queue.length) return { ok: false, text: "No connection. What it would look like is not known." };
      return HL.port.api("POST", "/map/draft/preview", { op, features: ids, args }, PREVIEW_MS);
    }

    history(id) {
      const feature = this.client.features.get(id);
      if (!feature) return;
      M.showHistory(id, feature, { canEdit: this.client.isEditing, reason: this.editReason(), setDay: (key, day) => this.setDay(id, key, day) });
    }

    setDay(id, key, day) {
      const before = this.client.features.get(id);
      const field = M.fieldsOf(before).find((one) => one.key === key);
      const after = M.withDay(before, key, day);
      this.commit(`${field?.label ?? key} ${day ? `valid from ${day}` : "valid from publishing"}`, [{ id, before, after }]);
    }

    // for merging a tap takes only what can be merged with what is chosen, so that none takes the farm around it
    several(isOn) {
      this.isSeveral = isOn;
      if (this.editor) this.editor.several = isOn && this.tool === "merge" ? (one) => this.mergeable(one).includes(one.id) : isOn;
      this.changed();
    }

    mergeable(...more) {
      return M.mergeable([...this.chosen.map((id) => this.client.features.get(id)), ...more]).map((one) => one.id);
    }

    async merge() {
      const ids = this.mergeable();
      if (ids.length < 2) return;
      const answer = await this.operate("merge", ids, {}, "Merge");
      if (!answer.ok) return;
      this.take("select");
      this.several(false);
      this.select((answer.changes ?? []).filter((one) => one.after).map((one) => one.id));
    }

    async drawn({ tool, coordinates, target }) {
      this.take("select");
      if (tool !== "hole" && tool !== "split") return; // a new feature: it came as a change
      const [op, args] = tool === "hole" ? ["add_hole", { ring: coordinates }] : ["split", { line: coordinates }];
      const answer = await this.operate(op, [target].flat(), args, tool === "hole" ? "Hole" : "Split");
      if (answer.ok && this.tool === "select") this.select((answer.changes ?? []).filter((one) => one.after).map((one) => one.id).slice(0, 1)); // or the next is begun already
    }

    // places: a closed ring of an area, or the points of a road or guide line; false when there is no draft to take it
    async walked(kind, places, accuracyM, robot) {
      if (!(await this.open(false))) return false; // a long walk may outlast the lock
      const id = M.newId(kind);
      const isLine = kind === "road" || kind === "rows";
      const own = { road: () => ({ width_m: ROAD_M }), rows: () => this.rowsOf(places) }[kind]?.() ?? {};
      const properties = { id, kind, name: `Walked with ${robot}`, ...own, ...(accuracyM === null ? {} : { accuracy_m: Number(accuracyM.toFixed(3)) }) };
      const after = { type: "Feature", id, properties, geometry: isLine ? { type: "LineString", coordinates: places } : { type: "Polygon", coordinates: [outward(places)] } };
      this.commit(`${isLine ? "Line" : "Edge"} walked with ${robot}`, [{ id, before: null, after }]);
      this.select([id]);
      this.editor?.fit([id]);
      return true;
    }

    // a guide line belongs to the field that its middle lies in
    rowsOf(places) {
      const middle = places[places.length >> 1];
      const field = [...this.client.features].find(([, one]) => M.kindOf(one) === "parcel" && one.geometry.type === "Polygon" && M.isInRing(middle, one.geometry.coordinates[0]));
      return { type: places.length > 2 ? "curve" : "a-b", ...(field && { parcel_id: field[0] }) };
    }

    copy() {
      const before = this.client.features.get(this.chosen[0]);
      if (!before) return;
      const id = M.newId(M.kindOf(before));
      const after = M.moved({ ...before, id, properties: { ...before.properties, id, name: `${M.nameOf(before).slice(0, M.NAME_CHARS - COPY.length)}${COPY}` } }, COPY_M, -COPY_M);
      this.commit(`${M.nameOf(before)} copied`, [{ id, before: null, after }]);
      this.select([id]);
    }

    // rows go with their parcel
    remove() {
      const found = this.chosen.filter((id) => this.client.features.has(id));
      if (!found.length) return;
      const rows = [...this.client.features].filter(([id, one]) => M.kindOf(one) === "rows" && found.includes(one.properties.parcel_id) && !found.includes(id)).map(([id]) => id);
      const name = found.length === 1 ? M.nameOf(this.client.features.get(found[0])) : M.count(found.length, "shape");
      this.commit(`${name} deleted`, [...found, ...rows].map((id) => ({ id, before: this.client.features.get(id), after: null })));
      this.select([]);
      HL.toast(`${name} deleted. Undo brings it back.`, "delete");
    }

    // of a comparison; what was removed is shown where it was
    showDifference({ id }) {
      const gone = this.client.features.has(id) ? null : this.client.base.get(id);
      if (!gone) return this.show([id]);
      this.select([]);
      this.isGoneShown = true;
      this.editor?.setTrial([gone]);
      this.editor?.fit([gone]);
      return HL.toast(`${M.nameOf(gone)} was here. It is not in this draft.`, "delete");
    }

    hideGone() {
      if (this.isGoneShown) this.editor?.setTrial([]);
      this.isGoneShown = false;
    }

    select(ids) {
      this.chosen = ids;
      this.point = null;
      this.lockAgain();
      this.editor?.select(ids);
      this.changed();
    }

    // a shape taken off its lock is locked again when another is chosen
    lockAgain() {
      this.reshape.close();
      this.hideGone();
      if (!this.isUnlocked) return;
      this.isUnlocked = false;
      this.editor?.unlockBody(false);
    }

    show(ids) {
      const found = ids.filter((id) => id && this.client.features.has(id));
      if (!found.length) return;
      this.select(found.slice(0, 1));
      this.editor?.fit(found);
    }

    // ---- import

    drops() {
      const isFile = (event) => this.may.edit && [...(event.dataTransfer?.types ?? [])].includes("Files");
      this.field.addEventListener("dragover", (event) => isFile(event) && (event.preventDefault(), this.field.classList.add("drop")));
      this.field.addEventListener("dragleave", () => this.field.classList.remove("drop"));
      this.field.addEventListener("drop", (event) => {
        this.field.classList.remove("drop");
        if (!isFile(event)) return;
        event.preventDefault();
        if (event.dataTransfer.files[0]) this.import(event.dataTransfer.files[0]);
      });
    }

    picked() {
      const [file] = this.file.files;
      this.file.value = "";
      if (file) this.import(file);
    }

    import(file) {
      if (M.isBaseFile(file)) return this.baseMaps(file);
      M.importFile(file, { opened: () => this.open(false), take: (...chosen) => this.imported(...chosen) });
      return undefined;
    }

    baseMaps(file = null) {
      M.showBaseMaps({ mayEdit: this.may.edit, reason: this.dataset.noEdit, show: (one) => this.editor?.showBase(one.id, one.bounds) }, file);
    }

    async imported(importId, items, kinds, limitMs) {
      const answer = await this.client.ask(`/map/imports/${importId}/take`, { id: window.headland.uuid(), items, kinds }, limitMs);
      if (!answer.ok) return answer;
      const ids = (answer.changes ?? []).filter((one) => one.after).map((one) => one.id);
      HL.toast(`${M.count(ids.length, "shape")} imported`, "check");
      if (ids.length) this.editor?.fit(ids);
      this.checkSoon();
      return answer;
    }
  }

  // outer rings run counter-clockwise
  function outward(ring) {
    let twice = 0;
    for (let i = 0; i < ring.length - 1; i += 1) twice += ring[i][0] * ring[i + 1][1] - ring[i + 1][0] * ring[i][1];
    return twice < 0 ? ring.toReversed() : ring;
  }

  M.MapEdits = MapEdits;
})();
