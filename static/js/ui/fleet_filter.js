// Finding robots: a search, an order, filters, and views that a person keeps.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle } = HL;
  const SORTS = [["attention", "Attention"], ["group", "Group"], ["name", "Name"]];
  const STATES = [["", "Any state"], ["needs", "Needs you"], ["working", "Working"], ["idle", "Not working"], ["offline", "No link"]];

  class FleetFilter {
    constructor() {
      this.input = el("input", { class: "h-input", type: "search", placeholder: "Find a robot, mission or field", "aria-label": "Find a robot, mission or field", "data-testid": "fleet-search" });
      this.input.value = HL.fleet.filter.q;
      this.input.addEventListener("input", () => HL.fleet.setFilter({ q: this.input.value.trim() }));
      this.sorts = SORTS.map(([key, label]) => el("button", { type: "button", "data-testid": `fleet-sort-${key}`, onclick: () => HL.fleet.setFilter({ sort: key }) }, label));
      this.more = el("button", { type: "button", class: "h-btn ico", "aria-label": "Filters and views", title: "Filters and views", "data-testid": "fleet-filter", onclick: () => openFilters() }, icon("tune"));
      this.node = el("div", { class: "f-find" }, el("label", { class: "f-search" }, icon("search", "m"), this.input, el("span", { class: "h-key" }, "/")), el("div", { class: "f-findrow" }, el("div", { class: "h-seg", role: "group", "aria-label": "Order" }, ...this.sorts), this.more));
      this.paint();
    }
    paint() {
      const { filter } = HL.fleet;
      this.sorts.forEach((button, i) => attr(button, "aria-pressed", String(filter.sort === SORTS[i][0])));
      toggle(this.more, "on", HL.fleet.isNarrowed({ ...filter, q: "" }));
      if (this.input.value.trim() !== filter.q && document.activeElement !== this.input) this.input.value = filter.q;
    }
  }

  const check = (label, isOn, hook, change) => {
    const box = el("input", { type: "checkbox", "data-testid": hook, onchange: () => change(box.checked) });
    box.checked = isOn;
    return el("label", { class: "f-check" }, box, el("span", {}, label));
  };

  // draws now and whenever somebody saved or deleted a group, as long as the node is shown
  function whileOpen(node, draw) {
    draw();
    const again = () => (node.isConnected ? draw() : window.removeEventListener("hl-groups", again));
    window.addEventListener("hl-groups", again);
  }

  function openFilters() {
    const { filter } = HL.fleet;
    const families = Object.entries(HL.fleetOrder.FAMILIES).filter(([key]) => HL.fleet.items.some((one) => one.robot.family === key));
    const state = el("select", { class: "h-select", "data-testid": "fleet-filter-state", onchange: () => HL.fleet.setFilter({ state: state.value }) }, ...STATES.map(([value, label]) => el("option", { value }, label)));
    const group = el("select", { class: "h-select", "data-testid": "fleet-filter-group", onchange: () => HL.fleet.setFilter({ group: group.value }) });
    state.value = filter.state;
    whileOpen(group, () => {
      group.replaceChildren(el("option", { value: "" }, "Any group"), ...HL.fleet.groups.map((one) => el("option", { value: one.id }, `${one.name} (${one.robots.length})`)));
      group.value = HL.fleet.filter.group;
    });
    const kinds = families.map(([key, label]) => check(label, filter.families.includes(key), `fleet-filter-${key}`, (isOn) => HL.fleet.setFilter({ families: isOn ? [...HL.fleet.filter.families, key] : HL.fleet.filter.families.filter((one) => one !== key) })));
    HL.sheet({
      title: "Filters and views", hook: "fleet-filters",
      body: [
        check("Mine: robots I am responsible for", filter.mine, "fleet-filter-mine", (isOn) => HL.fleet.setFilter({ mine: isOn })),
        el("div", { class: "f-checks" }, ...kinds),
        el("div", { class: "h-form" }, el("label", { class: "h-field" }, "State", state), el("label", { class: "h-field" }, "Group", group)),
        views(), groupsOf(),
        el("div", { class: "h-row" }, el("a", { class: "h-btn", href: "/wall", "data-testid": "wall-open", onclick: () => HL.closeSheet() }, icon("tablet", "m"), "Wall mode"), HL.fleet.can("manage_walls") ? el("button", { type: "button", class: "h-btn", "data-testid": "wall-manage", onclick: () => HL.fleetWalls() }, "Wall screens") : ""),
      ],
      buttons: [["Show all", (close) => (HL.fleet.setFilter({ ...HL.fleet.NO_FILTER }), close())], ["Done", (close) => close(), true]],
    });
  }

  // what a view keeps, in words
  function filterWords({ q, sort, families = [], group, mine, state }) {
    const named = HL.fleet.groups.find((one) => one.id === group)?.name;
    const isGone = group && !named && HL.fleet.areGroupsKnown;
    const parts = [mine ? "mine" : "", ...families.map((key) => (HL.fleetOrder.FAMILIES[key] ?? key).toLowerCase()), state ? STATES.find(([value]) => value === state)?.[1].toLowerCase() : "", named ? `group ${named}` : isGone ? "a group that was deleted" : "", q ? `“${q}”` : "", sort && sort !== "attention" ? `by ${sort}` : ""];
    return parts.filter(Boolean).join(", ") || "all robots";
  }

  // what was kept is not gone by one tap, and a refusal is told
  function askDelete(title, text, path, load) {
    const go = async () => {
      const answer = await HL.port.api("DELETE", path);
      await load();
      openFilters();
      if (!answer.ok) HL.toast(answer.text, "block");
    };
    HL.sheet({ title, hook: "fleet-delete", body: [el("p", { class: "h-2 h-t16" }, text)], buttons: [["Keep it", () => openFilters()], ["Delete", go, true]] });
  }
  const dropView = (view) => askDelete(`Delete view ${view.name}?`, "It cannot be brought back.", `/fleet/views/${view.id}`, HL.fleet.loadViews);
  const dropGroup = (group) => askDelete(`Delete group ${group.name}?`, `${group.robots.length === 1 ? "One robot is" : `${group.robots.length} robots are`} in it. It is gone for everybody on this farm and cannot be brought back.`, `/fleet/groups/${group.id}`, HL.fleet.loadGroups);

  function views() {
    const list = el("div", { class: "f-kept" });
    const name = el("input", { class: "h-input", maxlength: "80", placeholder: "Name of this view", "aria-label": "Name of this view", "data-testid": "fleet-view-name" });
    const said = el("span", { class: "h-error", role: "alert" });
    const draw = () => list.replaceChildren(...HL.fleet.views.map((view) => el("div", { class: "h-row" },
      el("button", { type: "button", class: "h-btn f-view", "data-testid": `fleet-view-${view.id}`, onclick: () => (HL.fleet.setFilter({ ...HL.fleet.NO_FILTER, ...view.filter }), HL.closeSheet()) }, view.name, el("span", { class: "h-2 h-t13 h-plain h-ell" }, filterWords(view.filter))),
      el("button", { type: "button", class: "h-btn q ico", "aria-label": `Delete view ${view.name}`, "data-testid": `fleet-view-drop-${view.id}`, onclick: () => dropView(view) }, icon("delete", "m")))));
    const save = async () => {
      if (!name.value.trim()) return text(said, "Give the view a name.");
      const { q, ...filter } = HL.fleet.filter;
      const answer = await HL.port.api("POST", "/fleet/views", { name: name.value, filter: { ...filter, q } });
      text(said, answer.ok ? "" : answer.text);
      if (answer.ok) name.value = "";
      await HL.fleet.loadViews();
      draw();
      return undefined;
    };
    draw();
    return el("section", { class: "f-kepts" }, el("b", { class: "h-t16" }, "My views"), list, el("div", { class: "h-row" }, name, el("button", { type: "button", class: "h-btn", "data-testid": "fleet-view-save", onclick: save }, "Save this view")), said);
  }

  function groupsOf() {
    const list = el("div", { class: "f-kept" });
    const node = el("section", { class: "f-kepts" }, el("b", { class: "h-t16" }, "Groups of this farm"), list);
    const draw = () => {
      attr(node, "hidden", !HL.fleet.groups.length);
      list.replaceChildren(...HL.fleet.groups.map((one) => el("div", { class: "h-row" },
        el("button", { type: "button", class: "h-btn f-view", "data-testid": `fleet-choose-${one.id}`, onclick: () => (HL.fleet.chooseAll(one.robots.filter((id) => id in HL.port.fleet())), HL.closeSheet()) }, `Choose ${one.name}`, el("span", { class: "h-2" }, ` ${one.robots.length}`)),
        HL.fleet.can("pause") ? el("button", { type: "button", class: "h-btn q ico", "aria-label": `Delete group ${one.name}`, "data-testid": `fleet-group-drop-${one.id}`, onclick: () => dropGroup(one) }, icon("delete", "m")) : "")));
    };
    whileOpen(node, draw);
    return node;
  }

  Object.assign(HL, { FleetFilter, fleetFilters: openFilters, fleetFilterWords: filterWords });
})();
