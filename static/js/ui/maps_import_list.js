// The shapes of a file to choose from: rows are made as they come into view, so that thousands stay quick.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const M = HL.maps;
  const AT_ONCE = 60;

  // longList(things, row(thing) -> node) -> node that grows as it is scrolled
  function longList(things, row) {
    const node = el("div", { class: "m-items" });
    const more = el("button", { type: "button", class: "h-btn", "data-testid": "import-more", onclick: () => grow() });
    let shown = 0;
    function grow() {
      node.append(...things.slice(shown, shown + AT_ONCE).map(row));
      shown = Math.min(things.length, shown + AT_ONCE);
      attr(more, "hidden", shown >= things.length);
      text(more, `Show more, ${things.length - shown} left`);
      node.append(more);
    }
    new IntersectionObserver((seen) => seen.some((one) => one.isIntersecting) && grow(), { rootMargin: "300px" }).observe(more);
    grow();
    return node;
  }

  const isParcel = (item) => item.kind === "parcel";
  const hasProblem = (item) => Boolean(item.problems?.length);

  class ImportList {
    // changed(): what is taken is another
    constructor(items, changed) {
      this.items = items;
      this.changed = changed;
      this.out = new Set(items.filter(hasProblem).map((one) => one.n)); // not taken
      this.kinds = new Map(); // chosen by hand
      this.rows = new Map();
      this.search = el("input", { class: "h-input", type: "search", placeholder: "Find by name", "aria-label": "Find by name", "data-testid": "import-search", oninput: () => this.draw() });
      const button = (hook, word, run) => el("button", { type: "button", class: "h-btn", "data-testid": hook, onclick: run }, word);
      const parcels = items.filter(isParcel).length;
      this.bar = el("div", { class: "h-row h-wrap m-importbar" }, button("import-all", "Take all", () => this.take(() => true)), button("import-none", "Take none", () => this.take(() => false)), parcels && parcels < items.length ? button("import-parcels", `Only ${M.count(parcels, "parcel")}`, () => this.take(isParcel)) : "", items.some(hasProblem) ? button("import-sound", "Only without problems", () => this.take((one) => !hasProblem(one))) : "", el("span", { class: "h-sp" }), items.length > AT_ONCE ? this.search : "");
      this.place = el("div", {});
      this.node = el("div", { class: "m-import", "data-testid": "import-list", "data-items": items.length }, items.length > 1 ? this.bar : "", this.place);
      this.draw();
    }

    get taken() {
      return this.items.filter((one) => !this.out.has(one.n));
    }

    kindOf(item) {
      return this.kinds.get(item.n) ?? item.kind;
    }

    draw() {
      const wanted = this.search.value.trim().toLowerCase();
      const found = wanted ? this.items.filter((one) => (one.name ?? "").toLowerCase().includes(wanted)) : this.items;
      this.rows.clear();
      this.place.replaceChildren(found.length ? longList(found, (item) => this.row(item)) : el("p", { class: "h-t14 h-2" }, "No shape has this name."));
    }

    take(isWanted) {
      this.out = new Set(this.items.filter((one) => !isWanted(one)).map((one) => one.n));
      for (const [n, box] of this.rows) box.checked = !this.out.has(n);
      this.changed();
    }

    row(item) {
      const box = el("input", { type: "checkbox", "data-testid": `import-item-${item.n}`, "aria-label": `Take ${item.name || `shape ${item.n}`}`, onchange: () => this.mark(item, box.checked) });
      box.checked = !this.out.has(item.n);
      this.rows.set(item.n, box);
      const kind = el("select", { class: "h-select", "data-testid": `import-kind-${item.n}`, "aria-label": "Kind", onchange: () => this.kinds.set(item.n, kind.value) }, ...(item.kinds?.length ? item.kinds : [item.kind]).map((one) => el("option", { value: one }, M.label(one))));
      kind.value = this.kindOf(item);
      const facts = [M.count(item.vertices ?? 0, "corner"), item.area_m2 ? M.words(M.area(item.area_m2)) : ""].filter(Boolean).join(", ");
      const problems = (item.problems ?? []).map((words) => el("div", { class: "h-row h-t13 h-b m-problem" }, HL.alarm(3, 20), words));
      return el("div", { class: "m-item" }, el("label", { class: "h-check" }, box), el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b h-ell" }, item.name || `Shape ${item.n}`), el("div", { class: "h-t13 h-2" }, facts), ...problems), kind);
    }

    mark(item, isTaken) {
      if (isTaken) this.out.delete(item.n);
      else this.out.add(item.n);
      this.changed();
    }
  }

  Object.assign(HL.maps, { ImportList, longList });
})();
