// Changes that are not saved yet: kept in this browser, in order, until the server has taken each of them;
// and those that were taken back before they went out, until they are made again or something else is done.
(() => {
  "use strict";

  class Queue {
    constructor(name = "queue") {
      this.key = `headland.map.${name}.${HL.config.user?.id ?? "-"}`;
      const kept = HL.keep.read(this.key, []);
      this.items = Array.isArray(kept) ? kept.filter((one) => one?.id && Array.isArray(one.changes)) : [];
    }
    get length() {
      return this.items.length;
    }
    get first() {
      return this.items[0] ?? null;
    }
    get last() {
      return this.items.at(-1) ?? null;
    }
    add(transaction) {
      this.items.push(transaction);
      this.keep();
    }
    remove(transaction) {
      this.items = this.items.filter((one) => one !== transaction);
      this.keep();
    }
    // it goes to the server now, which may have it from here on, whatever comes back
    tried(transaction) {
      if (transaction.isTried) return;
      transaction.isTried = true;
      this.keep();
    }
    clear() {
      this.items = [];
      this.keep();
    }
    keep() {
      HL.keep.write(this.key, this.items);
    }
  }

  const inverse = (changes) => changes.toReversed().map(({ id, before, after }) => ({ id, before: after, after: before }));

  Object.assign(HL.maps, { Queue, inverse });
})();
