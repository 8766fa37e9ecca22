// What somebody changed in the cloud: listed until it is taken into the draft or refused. Nothing is taken by itself.
(() => {
  "use strict";
  const { el, icon, attr } = HL;
  const { count, label } = HL.maps;
  const SIGNS = { added: "add", removed: "delete", changed: "edit" };

  const SHOWN = 5; // the map's own lists stand below

  class CloudWishes {
    // act: {client, mayEdit, reason(), look(features, trial)}
    constructor(act) {
      this.act = act;
      this.rows = [];
      this.head = el("h3", { class: "h-t16 h-b" });
      this.list = el("div", { class: "m-items" });
      this.about = el("p", { class: "h-t13 h-2" }, "Nothing of it is on your map. Take puts it into your draft; Refuse writes this map over it in the cloud.");
      this.node = el("section", { class: "m-changes", "aria-label": "Changes from the cloud", "data-testid": "map-proposals", hidden: true }, this.head, this.about, this.list);
    }

    async load() {
      const answer = await HL.port.api("GET", "/map/proposals");
      if (!answer.ok || !this.node.isConnected) return; // the list stays; it is asked again with the next change
      this.rows = answer.proposals ?? [];
      this.paint();
    }

    // what stands in the draft may be taken back or thrown away
    follow() {
      const step = this.act.client.draft?.undo_id ?? null;
      if (step === this.step) return;
      this.step = step;
      if (this.rows.length) this.load();
    }

    paint() {
      attr(this.node, "hidden", !this.rows.length);
      this.head.textContent = `From the cloud: ${count(this.rows.length, "change")}`;
      const rest = this.rows.length - SHOWN;
      if (this.shown) this.draw(this.rows.find((one) => one.id === this.shown) ?? null, false); // the view stays where it was moved to
      this.list.replaceChildren(...this.rows.slice(0, SHOWN).map((one) => this.row(one)), rest > 0 ? el("p", { class: "h-t13 h-2" }, `${count(rest, "more change")} after these`) : "");
    }

    // the shape as it would become, dashed over the map; of one that would go, what goes
    draw(one, isMoving = true) {
      const drawn = one && (one.after ?? one.before);
      this.shown = drawn ? one.id : null;
      this.act.look(drawn && isMoving ? [one.before, one.after].filter(Boolean) : null, drawn ? [drawn] : []);
    }

    show(one) {
      this.draw(this.shown === one.id ? null : one);
      this.paint();
    }

    row(one) {
      const mayEdit = this.act.mayEdit;
      const button = (hook, sign, word, run, isOff, title) => el("button", { type: "button", class: "h-btn", "data-testid": `${hook}-${one.id}`, disabled: isOff, title, onclick: run }, icon(sign, "m"), word);
      const says = one.problem ? `Cannot be taken: ${one.problem}` : one.in_draft_by ? `${one.text}. In the draft of ${one.in_draft_by}; it stays here until it is published.` : one.text;
      return el("div", { class: "m-item h-wrap m-ask", "data-testid": `proposal-${one.id}`, "data-state": one.what },
        el("div", { class: "h-row m-wish" }, icon(SIGNS[one.what] ?? "edit"), el("div", { class: "h-sp" }, el("div", { class: "h-t16 h-b" }, one.name || label(one.kind)), el("div", { class: "h-t13 h-2" }, `${label(one.kind)}. ${says}`))),
        one.before || one.after ? button("proposal-show", "my_location", this.shown === one.id ? "Hide" : "Show", () => this.show(one), false, "The change, dashed on the map") : "",
        button("proposal-take", "check", "Take", () => this.take(one), !mayEdit || Boolean(one.problem), mayEdit ? "Puts it into your draft" : this.act.reason()),
        button("proposal-refuse", "close", "Refuse", () => this.refuse(one), !mayEdit, mayEdit ? "The cloud gets what is on this map" : this.act.reason()));
    }

    async take(one) {
      const { client } = this.act;
      if (!client.isEditing) {
        const opened = await client.open(false);
        if (!opened.ok) return HL.toast(`Not taken: ${opened.text || "no answer"}`, "block");
      }
      const answer = await client.ask(`/map/proposals/${encodeURIComponent(one.id)}/take`, { id: window.headland.uuid() });
      if (answer.ok) this.draw(null);
      HL.toast(answer.ok ? `${one.name} is in your draft. Undo takes it back.` : HL.maps.notDone("Not taken", answer), answer.ok ? "check" : "block");
      answer.later?.then(() => this.load());
      return this.load();
    }

    refuse(one) {
      HL.sheet({
        title: `Refuse the change of ${one.name}?`, hook: "proposal-refuse",
        body: [el("p", { class: "h-t16 h-2" }, "The cloud gets what is on this map. What was changed there is gone.")],
        buttons: [["Keep it", (close) => close()], ["Refuse", async (close) => {
          close();
          const answer = await HL.port.api("POST", `/map/proposals/${encodeURIComponent(one.id)}/refuse`, {});
          HL.toast(answer.ok ? "Refused" : `Not refused: ${answer.text || "no answer"}`, answer.ok ? "check" : "block");
          this.load();
        }, true]],
      });
    }
  }

  HL.maps.CloudWishes = CloudWishes;
})();
