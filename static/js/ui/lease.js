// Who has control of the robot: shown to everybody, asked for, given, kept, taken.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define } = HL;

  const of = (robot) => HL.port.robot(robot).lease || { owner: null, asked: [] };
  const isMine = (robot) => Boolean(HL.config.session) && of(robot).owner?.session === HL.config.session;

  // what stands in the way of an act that needs control; a free robot is taken by the act itself
  function obstacle(robot) {
    const { owner } = of(robot);
    return owner && !isMine(robot) ? `${owner.name} has control. Ask for it.` : "";
  }

  async function ask(robot, op, extra) {
    const reply = await HL.port.lease(robot, op, extra);
    if (reply.text) HL.toast(reply.text, "key");
  }

  function take(robot) {
    const reason = HL.draft.bind(el("input", { class: "h-input", "aria-label": "Reason", placeholder: "Reason, for the log", maxlength: "200", autofocus: true }), "take-reason");
    HL.sheet({
      title: `Take control of ${HL.view.name()}?`,
      body: [el("p", { class: "h-2 h-t16" }, `${of(robot).owner?.name ?? "Nobody"} loses control at once. The robot stays in its state.`), reason],
      buttons: [
        ["Leave it", (close) => close()],
        ["Take control", async (close) => {
          if (!reason.value.trim()) return reason.focus();
          close();
          await ask(robot, "take", { reason: reason.value.trim() });
          HL.draft.clear("take-reason");
        }, true],
      ],
    });
  }

  class Lease extends LiveElement {
    build() {
      this.who = el("span", { class: "h-b h-nw h-ell", "data-testid": "lease-owner" });
      const button = (label, hook, act) => el("button", { type: "button", class: "h-btn", "data-testid": hook, onclick: act }, label);
      this.request = button("Ask for it", "lease-request", () => ask(HL.view.robot, "request"));
      this.takeIt = button("Take", "lease-take", () => take(HL.view.robot));
      this.release = button("Give up", "lease-release", () => ask(HL.view.robot, "release"));
      this.line = el("div", { class: "h-row h-leaseline" }, icon("key", "m"), this.who, this.request, this.takeIt, this.release);
      this.asker = el("span", { class: "h-b" });
      this.grant = button("Give", "lease-grant", () => this.answer("grant"));
      this.keep = button("Keep", "lease-keep", () => this.answer("keep"));
      this.question = el("div", { class: "h-row h-leaseline ask", role: "alert" }, this.asker, this.grant, this.keep);
      this.append(this.line, this.question);
    }
    answer(op) {
      const [first] = of(HL.view.robot).asked || [];
      if (first) ask(HL.view.robot, op, { session: first.session });
    }
    paint() {
      const lease = of(HL.view.robot);
      const rights = HL.config.rights;
      const mine = isMine(HL.view.robot);
      const other = lease.owner && !mine;
      const asked = mine ? lease.asked || [] : [];
      const haveAsked = other && (lease.asked || []).some((one) => one.session === HL.config.session);
      attr(this, "hidden", false);
      attr(this.who, "data-value", lease.owner?.user ?? "");
      attr(this.who, "data-state", mine ? "mine" : other ? "other" : "free");
      text(this.who, mine ? "You have control" : other ? `${lease.owner.name} has control` : "Nobody has control");
      attr(this.request, "hidden", mine || !rights.includes("lease"));
      attr(this.request, "disabled", haveAsked);
      text(this.request, haveAsked ? "Asked" : other ? "Ask for it" : "Take control");
      attr(this.takeIt, "hidden", !other || !rights.includes("take_lease"));
      attr(this.release, "hidden", !mine);
      attr(this.question, "hidden", !asked.length);
      if (asked.length) text(this.asker, `${asked[0].name} asks for control.`);
    }
  }

  define("hl-lease", Lease);
  Object.assign(HL, { lease: { of, isMine, obstacle } });
})();
