// Changes that are not saved yet: kept in this browser, in order, until the server has taken each of them.
(() => {
  "use strict";
  const KEY = `headland.map.queue.${HL.config.user?.id ?? "-"}`;

  class Queue {
    constructor() {
      const kept = HL.keep.read(KEY, []);
      this.items = Array.isArray(kept) ? kept.filter((one) => one?.id && Array.isArray(one.changes)) : [];
    }
    get length() {
      return this.items.length;
    }
    get first() {
      return this.items[0] ?? null;
    }
    add(transaction) {
      this.items.push(transaction);
      this.keep();
    }
    remove(transaction) {
      this.items = this.items.filter((one) => one !== transaction);
      this.keep();
    }
    clear() {
      this.items = [];
      this.keep();
    }
    keep() {
      HL.keep.write(KEY, this.items);
    }
  }

  const inverse = (changes) => changes.toReversed().map(({ id, before, after }) => ({ id, before: after, after: before }));

  Object.assign(HL.maps, { Queue, inverse });
})();
