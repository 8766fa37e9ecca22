// Windows in which nothing starts by itself: the list, and one of them to change.
(() => {
  "use strict";
  const { el, icon } = HL;
  const { DAYS } = HL.queue;
  const { field } = HL.queueFields;

  const time = (minutes) => `${String(Math.floor(minutes / 60)).padStart(2, "0")}:${String(minutes % 60).padStart(2, "0")}`;
  const minutes = (text) => Number(text.slice(0, 2)) * 60 + Number(text.slice(3, 5));
  const dayWords = (days) => (days.length === 7 ? "every day" : days.length === 5 && days.every((one) => one < 5) ? "Mon to Fri" : days.map((one) => DAYS[one]).join(", "));
  const words = (one) => `${dayWords(one.days)}, ${time(one.from_min)} to ${time(one.to_min)}${one.to_min <= one.from_min ? " the next day" : ""}`;

  function list(queue, mayEdit, changed) {
    const names = Object.fromEntries(queue.robots.map((one) => [one.robot_id, one.name]));
    const rows = queue.blackouts.map((one) => el("div", { class: "h-card h-row", "data-testid": `queue-blackout-${one.id}` }, el("div", { class: "h-col h-sp" }, el("b", { class: "h-t16" }, one.name), el("span", { class: "h-t14 h-2" }, `${words(one)}${one.robots.length ? `, ${one.robots.map((id) => names[id] ?? id).join(", ")}` : ", all robots"}`)), el("button", { type: "button", class: "h-btn ico", "aria-label": `Change ${one.name}`, disabled: !mayEdit, onclick: () => edit(one, queue, changed) }, icon("edit", "m")), el("button", { type: "button", class: "h-btn ico", "aria-label": `Delete ${one.name}`, disabled: !mayEdit, onclick: () => remove(one, changed) }, icon("delete", "m"))));
    HL.sheet({ title: "Blackout windows", hook: "queue-blackouts", body: [el("p", { class: "h-t14 h-2" }, `In these hours the queue starts nothing. What runs goes on. Times are those of ${HL.queue.zoneName(queue.zone)}.`), ...(rows.length ? rows : [el("p", { class: "h-t16" }, "No windows yet.")]), mayEdit ? "" : el("p", { class: "h-t13 h-2" }, "Changing windows needs the operator or planner role.")], buttons: [["Close", (close) => close()], ...(mayEdit ? [["Add a window", () => edit(null, queue, changed), true]] : [])] });
  }

  function edit(window, queue, changed) {
    const name = el("input", { class: "h-input", maxlength: "80", autofocus: true, placeholder: "Night, Sunday, school run", "data-testid": "blackout-name" });
    name.value = window?.name ?? "";
    const days = DAYS.map((one, k) => el("button", { type: "button", "aria-pressed": String(window ? window.days.includes(k) : true), "data-testid": `blackout-day-${k}`, onclick: (event) => event.currentTarget.setAttribute("aria-pressed", String(event.currentTarget.getAttribute("aria-pressed") !== "true")) }, one));
    const clock = (hook, value) => {
      const input = el("input", { class: "h-input", type: "time", required: true, "data-testid": hook });
      input.value = time(value);
      return input;
    };
    const from = clock("blackout-from", window?.from_min ?? 22 * 60);
    const to = clock("blackout-to", window?.to_min ?? 6 * 60);
    const robots = queue.robots.map((one) => {
      const input = el("input", { type: "checkbox" });
      input.checked = window?.robots.includes(one.robot_id) ?? false;
      return { id: one.robot_id, input, label: el("label", { class: "h-check" }, input, one.name) };
    });
    const problem = el("div", { class: "h-error", role: "alert" });
    const save = async (close) => {
      const body = { name: name.value.trim(), days: days.flatMap((one, k) => (one.getAttribute("aria-pressed") === "true" ? [k] : [])), from_min: minutes(from.value || "00:00"), to_min: minutes(to.value || "00:00"), robots: robots.filter((one) => one.input.checked).map((one) => one.id) };
      if (!body.name || !body.days.length || !from.value || !to.value) return (problem.textContent = !body.name ? "Give it a name." : "Choose days and times.");
      const answer = await HL.port.api(window ? "PUT" : "POST", window ? `/queue/blackouts/${window.id}` : "/queue/blackouts", body);
      if (!answer.ok) return (problem.textContent = HL.queue.failed(answer));
      close();
      HL.toast("Saved. The queues it is about are disarmed.", "check");
      return changed();
    };
    HL.sheet({ title: window ? `Change ${window.name}` : "Add a blackout window", hook: "queue-blackout", body: [field("Name", name), el("div", { class: "h-seg q-week", role: "group", "aria-label": "Days on which it begins" }, ...days), el("div", { class: "h-form" }, field("From", from), field("To", to, "earlier than the beginning: on the next day")), el("div", { class: "h-col" }, el("span", { class: "h-t13 h-b h-2" }, "Robots (none: all)"), el("div", { class: "q-robots" }, ...robots.map((one) => one.label))), problem], buttons: [["Leave it", (close) => close()], ["Save", save, true]] });
  }

  async function remove(window, changed) {
    const answer = await HL.port.api("DELETE", `/queue/blackouts/${window.id}`);
    if (!answer.ok) return HL.toast(`Not deleted: ${HL.queue.failed(answer)}`, "block");
    HL.closeSheet();
    HL.toast(`${window.name} is deleted`, "check");
    changed();
  }

  Object.assign(HL.queue, { blackouts: { list }, minutes: time });
})();
