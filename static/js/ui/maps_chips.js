// Title of the screen and what a person must know about the draft: saved or not, and who may edit until when.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const { count } = HL.maps;
  const time = (utc) => HL.words.wall(new Date(utc));

  class Chips {
    // act: {unsaved}
    constructor(act, farm) {
      this.farm = farm;
      this.main = el("div", { class: "h-t18 h-b", role: "heading", "aria-level": "1" });
      this.line = el("div", { class: "h-t13 h-2 h-plain h-ell" });
      this.saved = el("span", { class: "h-ell" });
      this.waiting = el("span", { class: "h-ell" });
      this.savedChip = el("span", { class: "h-chip line m-chip", "data-testid": "editor-saved" }, icon("edit", "s"), this.saved);
      this.waitingChip = el("button", { type: "button", class: "h-chip line m-chip waiting", "data-testid": "editor-unsaved", onclick: () => act.unsaved() }, icon("cloud_off", "s"), this.waiting);
      this.lockSign = icon("lock_person", "s");
      this.lockWord = el("span", { class: "h-ell" });
      this.lock = el("span", { class: "h-chip line m-chip", "data-testid": "editor-lock" }, this.lockSign, this.lockWord);
      this.node = el("div", { class: "m-top" }, el("div", { class: "m-title" }, this.main, this.line), el("div", { class: "m-chips", role: "status" }, this.waitingChip, this.savedChip, this.lock));
    }

    paint(client) {
      const { draft, isEditing, queue } = client;
      const version = client.published?.version;
      text(this.main, isEditing ? "Map builder" : "Maps");
      text(this.line, isEditing ? `${this.farm}, draft of v${client.nextVersion}` : version ? `${this.farm}, v${version}` : this.farm);
      const waiting = queue.length;
      const isQuiet = client.isSending && waiting === 1 && !client.isOffline; // on its way: no news yet
      const isWaiting = waiting > 0 && !isQuiet;
      attr(this.waitingChip, "hidden", !isWaiting);
      text(this.waiting, `Not saved yet: ${count(waiting, "change")}`);
      attr(this.savedChip, "hidden", isWaiting || !isEditing || !draft.saved_utc);
      if (draft?.saved_utc) text(this.saved, `Draft, saved ${HL.words.wallSeconds(new Date(draft.saved_utc))}`);
      attr(this.lock, "hidden", !draft?.editor);
      if (draft?.editor) text(this.lockWord, this.lockLine(draft, isEditing));
      text(this.lockSign, isEditing || !isOpen(draft) ? "lock_person" : "lock");
    }

    lockLine(draft, isEditing) {
      if (isEditing) return isOpen(draft) ? `Only you can edit until ${time(draft.until_utc)}` : `Anybody can edit since ${time(draft.until_utc)}`;
      return isOpen(draft) ? `${draft.editor.name} edits until ${time(draft.until_utc)}` : `${draft.editor.name} has a draft`;
    }
  }

  // by what the server said is left of it: this tablet's clock may be set wrong
  const isOpen = (draft) => (draft?.heldMs ?? 0) > performance.now();

  Object.assign(HL.maps, { Chips, isLocked: isOpen, clockOf: time });
})();
