// The end of the robot's own log, in a sheet: followed while it is open, searched on the server, by node if wanted.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement } = HL;
  const FOLLOW_MS = 3000; // a person reads slower
  const TYPING_MS = 300;
  const LINES = 200;

  class Log extends LiveElement {
    build() {
      const options = (HL.superNodes.all() ?? []).map((one) => el("option", { value: one.name }, one.label));
      this.node = el("select", { class: "h-select", "aria-label": "Node", "data-testid": "logs-node", onchange: () => this.ask() }, el("option", { value: "" }, "All nodes"), ...options);
      this.node.value = this.dataset.node || "";
      this.words = el("input", { class: "h-input", type: "search", placeholder: "Search", maxlength: "100", "aria-label": "Search the log", "data-testid": "logs-search", oninput: () => this.soon() });
      this.follow = el("input", { type: "checkbox", class: "h-check", checked: true });
      this.said = el("div", { class: "h-t13 h-2", role: "status", "data-testid": "logs-said" });
      this.lines = el("pre", { class: "s-log", tabindex: "0", "aria-label": "Log", "data-testid": "logs-lines" });
      this.again = el("button", { type: "button", class: "h-btn", onclick: () => this.ask() }, icon("refresh", "m"), "Try again");
      this.append(el("div", { class: "s-logbar" }, this.words, this.node, el("label", { class: "h-row" }, this.follow, "Follow")), this.said, this.again, this.lines);
      this.count = 0;
    }
    enter() {
      this.robot = HL.view.robot;
      this.timer = setInterval(() => this.follow.checked && !document.hidden && !this.isAsking && this.ask(), FOLLOW_MS);
      text(this.said, "Reading the log");
      this.ask();
    }
    leave() {
      clearInterval(this.timer);
      clearTimeout(this.typing);
    }
    soon() {
      clearTimeout(this.typing);
      this.typing = setTimeout(() => this.ask(), TYPING_MS);
    }
    async ask() {
      const number = ++this.count;
      this.isAsking = true;
      const query = new URLSearchParams({ lines: LINES, q: this.words.value.trim(), node: this.node.value });
      const answer = await HL.port.api("GET", `/robots/${encodeURIComponent(this.robot)}/logs?${query}`, null, 8000);
      if (number !== this.count || !this.isConnected) return; // a newer question is under way
      this.isAsking = false;
      this.show(answer);
    }
    show(answer) {
      attr(this.again, "hidden", answer.ok);
      attr(this, "data-state", answer.ok ? "read" : "failed");
      if (!answer.ok) return text(this.said, this.lines.textContent ? `${answer.text} What is shown was read ${this.at}.` : answer.text);
      this.at = `at ${HL.words.wallSeconds(new Date())}`;
      const isSearch = Boolean(this.words.value.trim() || this.node.value);
      const isAtEnd = this.lines.scrollHeight - this.lines.scrollTop - this.lines.clientHeight < 40;
      text(this.said, said(answer, isSearch, this.at));
      const lines = answer.lines.join("\n");
      if (lines !== this.lines.textContent) {
        this.lines.textContent = lines;
        if (isAtEnd || !this.isRead) this.lines.scrollTop = this.lines.scrollHeight;
      }
      this.isRead = true;
      return undefined;
    }
  }

  function said({ lines, found, read }, isSearch, at) {
    if (!read) return `Its log is empty. Read ${at}.`;
    if (!isSearch) return `The last ${lines.length} lines, read ${at}.`;
    if (!found) return `Nothing found in its last ${read} lines. Read ${at}.`;
    return `${found === lines.length ? found : `The last ${lines.length} of ${found}`} found in its last ${read} lines. Read ${at}.`;
  }

  function open(node = "") {
    if (!HL.config.rights.includes("read_logs")) return HL.toast("Reading a robot's log needs the operator role.", "lock");
    return HL.sheet({ title: `Log of ${HL.view.name()}`, hook: "logs-sheet", body: [el("hl-super-log", { "data-node": node })], buttons: [["Close", (close) => close(), true]] });
  }

  HL.superDefine("hl-super-log", Log);
  Object.assign(HL, { superLogs: { open, said } });
})();
