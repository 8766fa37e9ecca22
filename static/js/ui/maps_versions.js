// Published versions, and what a draft changes against one.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const { count, label } = HL.maps;
  const WHAT = { added: "add", removed: "delete", moved: "open_with", changed: "edit" };

  // act: {restore(version), mayEdit, reason}
  function showVersions(current, act) {
    const place = el("div", { class: "m-items" });
    HL.sheet({ title: "Versions of the map", hook: "versions", body: [place], buttons: [["Close", (close) => close(), true]] });
    HL.records.load(place, "Versions", "/map/versions", (answer) => {
      const rows = answer.versions ?? [];
      if (!rows.length) return [HL.records.empty("No version yet", "Publish a draft to make the first.")];
      return rows.map((one) => {
        const isNow = one.version === current;
        const button = isNow ? el("span", { class: "h-chip dark" }, "In use") : el("button", { type: "button", class: "h-btn", "data-testid": `version-restore-${one.version}`, disabled: !act.mayEdit, title: act.mayEdit ? "Opens a draft with this content" : act.reason, onclick: () => act.restore(one.version) }, icon("history", "m"), "Restore");
        return el("div", { class: "m-item", "data-testid": `version-${one.version}` }, el("b", { class: "h-t18 h-b m-version" }, `v${one.version}`), el("div", { class: "h-sp" }, el("div", { class: "h-t14 h-b" }, one.note || "No note"), el("div", { class: "h-t13 h-2" }, `${HL.records.when(one.published_utc)} · ${one.by ?? "–"} · ${count(one.features ?? one.size ?? 0, "shape")}`)), button);
      });
    });
  }

  // act: {show(difference)}
  function showDifferences(version, act) {
    const place = el("div", { class: "m-items" });
    const close = HL.sheet({ title: `Compare with v${version}`, hook: "compare", body: [place], buttons: [["Close", (done) => done(), true]] });
    const line = (one) => [el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b" }, one.name || label(one.kind)), el("div", { class: "h-t13 h-2" }, `${label(one.kind)}, ${one.text || one.what}`))];
    const mine = (one) => el("button", { type: "button", class: "m-item m-diff", "data-testid": `difference-${one.id}`, "data-state": one.what, onclick: () => (close(), act.show(one)) }, icon(WHAT[one.what] ?? "edit"), ...line(one), icon("chevron_right"));
    const theirs = (one) => el("div", { class: "m-item m-diff", "data-testid": `meanwhile-${one.id}`, "data-state": one.what }, icon(WHAT[one.what] ?? "edit"), ...line(one));
    HL.records.load(place, "The comparison", "/map/draft/diff", (answer) => {
      const rows = (answer.differences ?? []).map(mine);
      const shown = rows.length ? rows : [HL.records.empty("No difference", `The draft is what v${version} is.`)];
      const { base_version: base, newest_version: newest = base, meanwhile = [] } = answer;
      if (newest === base) return shown;
      const told = el("p", { class: "h-t16 h-b", role: "alert", "data-testid": "compare-outdated" }, `v${newest} was published since this draft began on v${base}. The draft cannot be published over it: discard it and do again on v${newest} what is still needed.`);
      const head = (words) => el("h3", { class: "h-t16 h-b" }, words);
      return [told, head("What this draft changes"), ...shown, head(`What changed up to v${newest} meanwhile`), ...(meanwhile.length ? meanwhile.map(theirs) : [HL.records.empty("Nothing", `v${newest} is what v${base} was.`)])];
    });
  }

  // act: {drop}
  function showUnsaved(items, act) {
    const list = el("ol", { class: "m-log" }, ...items.map((one) => el("li", {}, one.label)));
    HL.sheet({ title: `Not saved yet: ${count(items.length, "change")}`, hook: "unsaved", body: [el("p", { class: "h-t16 h-2" }, "They are kept in this browser and go out, in this order, when the server takes them."), list], buttons: [["Drop them", (close) => (close(), act.drop())], ["Keep them", (close) => close(), true]] });
  }

  function showRefused(labels, why) {
    const body = [el("p", { class: "h-t16" }, why || "The draft was changed meanwhile."), el("p", { class: "h-t14 h-2" }, "The draft was loaded again. Look at it, then do what is still needed.")];
    const list = el("ol", { class: "m-log", "data-testid": "refused-list" }, ...labels.map((one) => { const row = el("li"); text(row, one); return row; }));
    HL.sheet({ title: `Not taken: ${count(labels.length, "change")}`, hook: "refused", body: [list, ...body], buttons: [["Close", (close) => close(), true]] });
  }

  Object.assign(HL.maps, { showVersions, showDifferences, showUnsaved, showRefused });
})();
