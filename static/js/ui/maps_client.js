// The map as this browser knows it: published version, draft, and the changes on their way to the server.
(() => {
  "use strict";
  const { Queue, inverse } = HL.maps;
  const LOAD_MS = 20000; // a whole farm over a weak radio
  const OPERATION_MS = 30000;
  const RETRY_MS = 2000;
  const KEPT = "headland.map.kept";
  const MOST_KEPT = 1500000; // characters; browsers keep 5 MB for a whole site
  const STATE = ["base_version", "saved_utc", "editor", "until_utc", "is_mine", "undo", "redo", "log"];
  const NO_LINK = "No connection. Your changes are kept here and go out when it is back.";

  const isLost = (answer) => answer.status === 0 || answer.status >= 500 || answer.status === 429;
  const byId = (collection) => new Map((collection?.features ?? []).map((one) => [one.id ?? one.properties.id, one]));

  // on: {changed(), replaced(), patched(changes), refused(labels, text)}
  class MapClient {
    constructor(on) {
      this.on = on;
      this.queue = new Queue();
      this.undone = []; // taken back before it was sent
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
    get undoLabel() {
      return this.queue.items.at(-1)?.label ?? this.draft?.undo ?? null;
    }
    get redoLabel() {
      return this.undone.at(-1)?.label ?? this.draft?.redo ?? null;
    }

    async load() {
      const answer = await HL.port.api("GET", "/map", null, LOAD_MS);
      if (!answer.ok) return this.recall(answer);
      this.isKept = false;
      this.published = { version: answer.version ?? 0, published_utc: answer.published_utc, by: answer.by, note: answer.note };
      this.base = byId(answer.features);
      this.keep(answer);
      this.take(answer.draft);
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
      this.draft = draft ?? null;
      this.revision += 1;
      this.features = new Map(draft?.is_mine && draft.features ? byId(draft.features) : this.base);
      if (this.isEditing) for (const one of this.queue.items) this.apply(one.changes);
      this.on.replaced();
      this.on.changed();
    }

    state(draft) {
      if (!draft) return;
      this.draft = { ...this.draft, ...Object.fromEntries(STATE.filter((key) => key in draft).map((key) => [key, draft[key]])) };
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
      this.undone = [];
      this.apply(changes);
      this.queue.add({ id: window.headland.uuid(), label: String(label).slice(0, 120), changes });
      this.on.changed();
      this.flush();
    }

    flush() {
      return this.serial(() => this.send());
    }

    async send() {
      clearTimeout(this.timer);
      const refused = [];
      let why = "";
      while (this.queue.length && this.isEditing) {
        const one = this.queue.first;
        this.isSending = one;
        this.on.changed();
        const answer = await HL.port.api("POST", "/map/draft/transactions", one);
        this.isSending = null;
        this.isOffline = !answer.ok && isLost(answer);
        if (this.isOffline) {
          this.timer = setTimeout(() => this.flush(), RETRY_MS);
          break;
        }
        if (answer.status === 423 || answer.status === 401 || answer.status === 403) {
          await this.lockLost(answer);
          break;
        }
        this.queue.remove(one);
        if (answer.ok) this.state(answer.draft);
        else {
          refused.push(one.label);
          why = answer.text;
        }
      }
      this.on.changed();
      if (refused.length) {
        this.undone = [];
        await this.load0();
        this.on.refused(refused, why);
      }
    }

    // the draft as the server holds it, without sending again
    async load0() {
      const answer = await HL.port.api("GET", "/map", null, LOAD_MS);
      if (!answer.ok) return;
      this.published = { version: answer.version ?? 0, published_utc: answer.published_utc, by: answer.by, note: answer.note };
      this.base = byId(answer.features);
      this.take(answer.draft);
    }

    async lockLost(answer) {
      await this.load0();
      if (this.isEditing) this.draft = { ...this.draft, is_mine: false };
      this.on.replaced();
      this.on.refused([], answer.text);
    }

    dropUnsaved() {
      this.queue.clear();
      this.undone = [];
      return this.load0();
    }

    undo() {
      const last = this.queue.items.at(-1);
      if (last && last !== this.isSending) {
        this.queue.remove(last);
        this.undone.push(last);
        return this.done(inverse(last.changes));
      }
      return this.walk("undo");
    }

    redo() {
      const last = this.undone.pop();
      if (!last) return this.walk("redo");
      this.queue.add(last);
      this.flush();
      return this.done(last.changes);
    }

    walk(way) {
      return this.ask(`/map/draft/${way}`, {});
    }

    operate(op, features, args = {}) {
      return this.ask("/map/draft/operations", { id: window.headland.uuid(), op, features, args }, OPERATION_MS);
    }

    // what the server does to the draft: only when it has all of ours
    ask(path, body, limitMs) {
      this.flush();
      return this.serial(async () => {
        if (this.queue.length) return { ok: false, status: 0, text: NO_LINK };
        const answer = await HL.port.api("POST", path, body, limitMs);
        if (answer.status === 423) await this.lockLost(answer);
        if (!answer.ok) return answer;
        this.undone = [];
        this.state(answer.draft);
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
      await this.flush();
      if (this.queue.length) return { ok: false, status: 0, text: NO_LINK };
      return this.closing(() => HL.port.api("POST", "/map/draft/publish", { note, is_shrinking_ok: isShrinkingOk }, OPERATION_MS), () => this.load0());
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

    async restore(version) {
      const answer = await HL.port.api("POST", `/map/versions/${version}/restore`, {}, OPERATION_MS);
      if (answer.ok) this.take(answer.data);
      return answer;
    }
  }

  HL.maps.MapClient = MapClient;
})();
