// The map as this browser knows it: published version, draft, and the changes on their way to the server.
(() => {
  "use strict";
  const { Queue, inverse } = HL.maps;
  const LOAD_MS = 20000; // a whole farm over a weak radio
  const OPERATION_MS = 30000;
  const RETRY_MS = 2000;
  const KEPT = "headland.map.kept";
  const MOST_KEPT = 1500000; // characters; browsers keep 5 MB for a whole site
  const STATE = ["base_version", "saved_utc", "editor", "until_utc", "left_s", "is_mine", "undo", "redo", "undo_id", "redo_id", "log"];
  const NO_LINK = "No connection. Your changes are kept here and go out when it is back.";
  const UNSURE = "An answer was lost: the last step may be done or not. The map is loaded again when the link is back.";
  const LOOKED = "An answer was lost, so the map was loaded again. Look at it, then go on.";

  const isUnknown = (answer) => answer.status === 0 || answer.status >= 500; // the server may have done it
  const isLost = (answer) => isUnknown(answer) || answer.status === 429;
  const byId = (collection) => new Map((collection?.features ?? []).map((one) => [one.id ?? one.properties.id, one]));

  const held = (draft) => ({ ...draft, heldMs: performance.now() + 1000 * (draft.left_s ?? 0) }); // until when its lock holds

  // whether a step of the log, of which only the newest are told, is done: others may have gone out since
  const hasStep = ({ undo_id: newest, log }, id) => newest === id || log.some((one) => one.id === id && !one.is_undone);

  // on: {changed(), replaced(), patched(changes), refused(labels, text), looked(text)}
  class MapClient {
    constructor(on) {
      this.on = on;
      this.queue = new Queue();
      this.undone = new Queue("undone"); // taken back before it was sent; under: the step it stood on
      this.unsure = null; // what was asked of the draft without an answer: {isDone(draft), known(isDone)}
      this.published = null;
      this.draft = null;
      this.features = new Map();
      this.base = new Map();
      this.line = Promise.resolve();
      this.isSending = false;
      this.isOffline = false;
      this.revision = 0; // of the features shown
    }

    get isEditing() {
      return Boolean(this.draft?.is_mine);
    }
    get nextVersion() {
      return Math.max(this.published?.version ?? 0, this.draft?.base_version ?? 0) + 1;
    }
    get baseVersion() {
      return this.draft?.base_version ?? this.published?.version ?? 0;
    }
    // somebody published since the draft began: it cannot be published over that
    get isOutdated() {
      return this.isEditing && (this.published?.version ?? 0) > this.draft.base_version;
    }
    get undoLabel() {
      return this.queue.last?.label ?? this.draft?.undo ?? null;
    }
    get redoLabel() {
      return this.ownRedo?.label ?? this.draft?.redo ?? null;
    }
    // the newest step of the draft as it is shown
    get newest() {
      return this.queue.last?.id ?? this.draft?.undo_id ?? null;
    }
    get ownRedo() {
      const { last } = this.undone;
      return last?.under === this.newest ? last : null;
    }

    async load() {
      const answer = await this.load0();
      if (!answer.ok) return this.recall(answer);
      this.keep(answer);
      this.flush();
      return answer;
    }

    // the last map this browser saw, when the server gives none
    recall(answer) {
      const kept = HL.keep.read(KEPT, null);
      if (kept?.features && !this.published) {
        this.isKept = true;
        this.published = { version: kept.version, published_utc: kept.published_utc, by: kept.by, note: kept.note };
        this.base = byId(kept.features);
        this.take(null);
      }
      return answer;
    }

    keep({ version, published_utc, by, note, features }) {
      if (JSON.stringify(features ?? null).length < MOST_KEPT) HL.keep.write(KEPT, { version, published_utc, by, note, features });
    }

    // a whole draft, or none: what is not saved yet goes on top
    take(draft) {
      this.draft = draft ? held(draft) : null;
      this.revision += 1;
      this.features = new Map(draft?.is_mine && draft.features ? byId(draft.features) : this.base);
      if (this.isEditing) for (const one of this.queue.items) this.apply(one.changes);
      this.on.replaced();
      this.on.changed();
    }

    state(draft) {
      if (!draft) return;
      this.draft = held({ ...this.draft, ...Object.fromEntries(STATE.filter((key) => key in draft).map((key) => [key, draft[key]])) });
      this.on.changed();
    }

    apply(changes) {
      this.revision += 1;
      for (const { id, after } of changes) {
        if (after) this.features.set(id, after);
        else this.features.delete(id);
      }
    }

    // one after the other: the server's log has one order
    serial(work) {
      const done = this.line.then(work, work);
      this.line = done.catch(() => {});
      return done;
    }

    async open(isTaking = false) {
      const answer = await HL.port.api("POST", "/map/draft", { take: isTaking }, LOAD_MS);
      if (answer.ok) {
        this.take(answer.data);
        this.flush();
      }
      return answer;
    }

    commit(label, changes) {
      this.undone.clear();
      this.apply(changes);
      this.queue.add({ id: window.headland.uuid(), label: String(label).slice(0, 120), changes });
      this.on.changed();
      this.flush();
    }

    flush() {
      return this.serial(() => this.send());
    }

    async send() {
      if (this.unsure && !(await this.look())) return;
      clearTimeout(this.timer);
      const refused = [];
      let why = "";
      while (this.queue.length && this.isEditing) {
        const one = this.queue.first;
        this.isSending = one;
        this.queue.tried(one);
        this.on.changed();
        const { id, label, changes } = one;
        const answer = await HL.port.api("POST", "/map/draft/transactions", { id, label, changes });
        this.isSending = null;
        this.isOffline = !answer.ok && isLost(answer);
        if (this.isOffline) {
          this.again(RETRY_MS);
          break;
        }
        if (answer.status === 423 || answer.status === 401 || answer.status === 403) {
          await this.lockLost(answer);
          break;
        }
        this.queue.remove(one);
        if (answer.ok) await (answer.draft.undo_id === id ? this.stepped(answer.draft) : this.load0()); // or it was undone meanwhile
        else {
          refused.push(one.label);
          why = answer.text;
        }
      }
      this.on.changed();
      if (refused.length) {
        this.undone.clear();
        await this.load0();
        this.on.refused(refused, why);
      }
    }

    // the draft as the server holds it, without sending again
    async load0() {
      const answer = await HL.port.api("GET", "/map", null, LOAD_MS);
      if (!answer.ok) return answer;
      const { unsure } = this;
      this.isKept = false;
      this.unsure = null;
      if (!answer.draft) this.undone.clear();
      this.published = { version: answer.version ?? 0, published_utc: answer.published_utc, by: answer.by, note: answer.note };
      this.base = byId(answer.features);
      this.take(answer.draft);
      unsure?.known(Boolean(answer.draft && unsure.isDone(answer.draft)));
      return answer;
    }

    // after a step of ours; one that this screen never saw may have got in before it: asked here long ago, or on another page
    async stepped(draft) {
      const seen = this.draft?.undo_id;
      this.state(draft);
      const [newest, before] = (draft?.log ?? []).filter((one) => !one.is_undone).map((one) => one.id);
      if (draft?.undo_id && seen !== newest && (seen ?? undefined) !== before) await this.load0();
    }

    // how the draft is, after an answer that was lost; until that is known nothing goes out
    async look() {
      const answer = await this.load0();
      if (!answer.ok) this.again(RETRY_MS);
      return answer.ok;
    }

    again(afterMs) {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.flush(), afterMs);
    }

    // sends what waits, and says why nothing can be asked of the draft now: null if it can
    async unready() {
      if (this.unsure) {
        const isKnown = await this.look();
        if (isKnown) this.flush();
        return { ok: false, status: 0, isUnsure: true, text: isKnown ? LOOKED : UNSURE };
      }
      await this.send();
      return this.queue.length ? { ok: false, status: 0, text: NO_LINK } : null;
    }

    // later: resolves to whether it was done after all
    lost(isDone) {
      const later = new Promise((known) => (this.unsure = { isDone, known }));
      later.then((done) => this.on.looked(done ? "The step whose answer was lost is done." : "The step whose answer was lost is not done. Do it again."));
      this.again(0);
      this.on.changed();
      return { ok: false, status: 0, isUnsure: true, text: UNSURE, later };
    }

    async lockLost(answer) {
      await this.load0();
      if (this.isEditing) this.draft = { ...this.draft, is_mine: false };
      this.on.replaced();
      this.on.refused([], answer.text);
    }

    dropUnsaved() {
      this.queue.clear();
      this.undone.clear();
      return this.load0();
    }

    undo() {
      const { last } = this.queue;
      if (!last) return this.walk("undo");
      if (last.isTried) return this.walk("undo", last.id); // the server may have it: only there it can be taken back
      this.queue.remove(last);
      this.undone.add({ ...last, under: this.newest });
      return this.done(inverse(last.changes));
    }

    redo() {
      const last = this.ownRedo;
      if (!last) return this.walk("redo");
      this.undone.remove(last);
      this.queue.add(last);
      this.flush();
      return this.done(last.changes);
    }

    // names the step, so that no other one is taken back or made again
    walk(way, id = null) {
      return this.ask(`/map/draft/${way}`, () => ({ id: id ?? this.draft?.[`${way}_id`] ?? null }), undefined, way);
    }

    operate(op, features, args = {}) {
      return this.ask("/map/draft/operations", { id: window.headland.uuid(), op, features, args }, OPERATION_MS);
    }

    // what the server does to the draft: only when it has all of ours. way: of a walk along the log, whose body is made then
    ask(path, body, limitMs, way = null) {
      return this.serial(async () => {
        const why = await this.unready();
        if (why) return why;
        const isBack = way === "undo";
        const sent = way ? body() : body;
        const answer = await HL.port.api("POST", path, sent, limitMs);
        if (isUnknown(answer)) return this.lost((draft) => hasStep(draft, sent.id) !== isBack);
        if (answer.status === 423) await this.lockLost(answer);
        if (answer.code === "changed") await this.load0();
        if (!answer.ok) return answer;
        if (!way) this.undone.clear();
        if (isBack) this.state(answer.draft);
        else await this.stepped(answer.draft);
        this.done(answer.changes ?? []);
        return answer;
      });
    }

    done(changes) {
      this.apply(changes);
      this.on.patched(changes);
      this.on.changed();
      return { ok: true, changes };
    }

    // robot: whose width parcels are checked for; empty: nobody's
    async checks(robot) {
      return HL.port.api("GET", `/map/draft/checks${robot ? `?robot=${encodeURIComponent(robot)}` : ""}`, null, LOAD_MS);
    }

    async publish(note, isShrinkingOk) {
      const why = await this.serial(() => this.unready());
      if (why) return why;
      const body = { note, is_shrinking_ok: isShrinkingOk, last_id: this.draft?.undo_id ?? null };
      const answer = await this.closing(() => HL.port.api("POST", "/map/draft/publish", body, OPERATION_MS), () => this.load0());
      if (answer.code === "changed") await this.load0();
      return answer;
    }

    discard() {
      return this.closing(() => HL.port.api("DELETE", "/map/draft"), () => this.dropUnsaved());
    }

    // the draft ends by our own hand: the news of it, which may be faster than the answer, is none to us
    async closing(ask, then) {
      this.isClosing = true;
      try {
        const answer = await ask();
        if (answer.ok) await then();
        return answer;
      } finally {
        this.isClosing = false;
      }
    }

    // may begin a draft: changes that wait since the last one was taken from us do not hold it up
    restore(version) {
      return this.serial(async () => {
        const why = this.unsure || this.isEditing ? await this.unready() : null;
        if (why) return why;
        const seen = this.draft?.undo_id ?? null;
        const answer = await HL.port.api("POST", `/map/versions/${version}/restore`, {}, OPERATION_MS);
        if (isUnknown(answer)) return this.lost((draft) => draft.undo_id !== seen);
        if (answer.ok) this.take(answer.data);
        return answer;
      });
    }
  }

  // what a lost answer leaves open is not said to be not done
  const notDone = (words, { text, isUnsure }) => (isUnsure ? text : `${words}: ${text || "the server did not answer"}`);

  Object.assign(HL.maps, { MapClient, notDone });
})();
