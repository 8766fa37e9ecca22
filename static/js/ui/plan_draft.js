// Drafts: missions that cannot be planned yet, kept on the server for everybody who plans.
(() => {
  "use strict";
  const { el, icon, text } = HL;
  const NO_PATH = "A draft has no path: it is not sent, queued or started. Open it and plan it first.";

  // choices of a form as they are kept; what was not chosen, or is no number yet, is left out
  function body(form) {
    const { name, ...wish } = form.wish();
    const chosen = Object.fromEntries(Object.entries(wish).filter(([, value]) => value !== "" && !Number.isNaN(value)));
    if (!(chosen.width_m > 0)) delete chosen.width_m;
    return { name: name || form.inputs.fieldPlace?.name || form.draft?.name || "Draft", wish: chosen };
  }

  const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

  class Keeper {
    // form: the MissionForm it belongs to; kept(mission): told of a draft that was kept
    constructor(form, kept) {
      this.form = form;
      this.kept = kept;
      this.button = el("button", { type: "button", class: "h-btn", "data-testid": "plan-draft", title: "Keep it as a draft, for everybody who plans", onclick: () => this.keep() }, "Save draft");
    }

    // as the form stands now nothing would be lost
    begin() {
      this.before = body(this.form);
    }

    get isChanged() {
      return Boolean(this.form.draft) && !same(this.before, body(this.form));
    }

    async keep() {
      const { form } = this;
      const given = body(form);
      this.button.disabled = true;
      const answer = form.draft
        ? await HL.port.api("PUT", `/missions/${encodeURIComponent(form.draft.id)}/draft`, { ...given, revision: form.draft.revision })
        : await HL.port.api("POST", "/missions/drafts", given);
      this.button.disabled = false;
      // the form was left before the answer came: what is open now stays open
      if (!form.node.isConnected) return HL.toast(answer.ok ? `${answer.data.name} is kept as a draft` : `${given.name} was not kept: ${answer.text || "no answer"}`, answer.ok ? "check" : "block");
      if (!answer.ok) {
        text(form.problem, `Not kept: ${answer.text || "no answer. Try again."}`);
        return form.steps.preview.open();
      }
      form.inputs.forget();
      form.treatment.forget();
      form.end();
      HL.toast(`${answer.data.name} is kept as a draft`, "check");
      return this.kept(answer.data);
    }

    // leave(): what is done when nothing is to be kept
    leave(leave) {
      if (!this.isChanged) return leave();
      return HL.sheet({ title: "Keep your changes?", hook: "draft-leave", body: [el("p", { class: "h-2 h-t16" }, `${this.form.draft.name} was changed and not saved.`)], buttons: [["Leave them", (close) => (close(), leave())], ["Save draft", (close) => (close(), this.keep()), true]] });
    }
  }

  // what a draft says in the missions' detail; open(): to go on with it
  function detail(mission, mayEdit, open) {
    const { wish } = mission;
    const chosen = [
      ["Field", mission.field_name || "not chosen"],
      ["Robot", mission.robot_id ? HL.port.fleet()[mission.robot_id]?.name ?? mission.robot_id : "not chosen"],
      ["Working width", wish.width_m ? `${wish.width_m} m` : "not chosen"],
      ["Row order", HL.planner.NAMES[wish.pattern ?? "shortest"]],
      ["Attendance", mission.is_supervised ? "A person must be there" : "May run unattended"],
    ];
    const button = el("button", { type: "button", class: "h-btn pri", "data-testid": "draft-open", disabled: !mayEdit, onclick: open }, icon("edit", "m"), "Open and plan");
    return [
      el("div", { class: "h-row h-wrap" }, button, el("span", { class: "h-t13 h-2", "data-testid": "draft-says" }, NO_PATH)),
      HL.records.table(["Chosen so far", ""], chosen.map((cells) => ({ cells }))),
    ];
  }

  Object.assign(HL.planner, { DraftKeeper: Keeper, draftDetail: detail });
})();
