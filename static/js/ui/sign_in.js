// Sign-in, sign-out and enrolling this tablet. The token that makes STOP work without sign-in is kept by the browser.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define, words } = HL;
  const TOKEN_KEY = "headland.stop_token"; // shared with the STOP slab, see docs/protocols/stop.md
  const DEMO = ["viewer", "operator", "planner", "supervisor", "dispatcher", "admin"];
  const PIN_LENGTH = 4;

  function stopToken() {
    try {
      return localStorage.getItem(TOKEN_KEY) || "";
    } catch {
      return "";
    }
  }

  function keepToken(token) {
    try {
      if (token) localStorage.setItem(TOKEN_KEY, token);
      else localStorage.removeItem(TOKEN_KEY);
    } catch {
      // STOP still works in this page by the session
    }
  }

  async function post(path, body) {
    return HL.port.api("POST", path, body);
  }

  async function signIn(body) {
    const token = stopToken();
    const answer = await post("/session", token ? { ...body, stop_token: token } : body);
    if (answer.ok) {
      keepToken(answer.stop_token);
      HL.draft.clear("login-name");
      if (location.pathname === "/login") location.replace("/operate");
      else location.reload();
    }
    return answer;
  }

  async function signOut() {
    const answer = await HL.port.api("DELETE", "/session");
    if (!answer.ok && answer.status !== 401) return HL.toast(`Not signed out: ${answer.text}`, "block");
    keepToken(answer.stop_token || "");
    location.assign("/");
    return undefined;
  }

  // one control works in both: a person and a PIN where the tablet is enrolled, name and password everywhere
  class Login extends LiveElement {
    build() {
      this.people = [];
      this.pin = "";
      this.message = el("div", { class: "h-error", role: "alert", "data-testid": "login-error" });
      this.body = el("div");
      this.append(this.body);
      this.showForm();
      if (location.hash.startsWith("#wall=")) this.wall(location.hash.slice(6));
      else if (stopToken()) this.load();
    }
    // the key stands behind the #, so that no server and no log ever reads it in an address
    async wall(key) {
      history.replaceState(null, "", location.pathname);
      const answer = await post("/fleet/walls/open", { key });
      if (!answer.ok) return text(this.message, "This wall screen was taken out. Ask a supervisor for a new address.");
      keepToken(answer.stop_token);
      return location.replace("/wall");
    }
    async load() {
      try {
        const reply = await fetch(`${HL.config.apiPath}/people`, { headers: { "X-Headland-Stop-Token": stopToken() }, cache: "no-store" });
        const { people = [], device } = reply.ok ? await reply.json() : {};
        this.people = people;
        this.device = device?.name || "";
        if (people.length) this.showPeople();
      } catch {
        this.people = []; // name and password stay
      }
    }
    head(title) {
      return [el("div", { class: "h-t28 h-b" }, title), el("div", { class: "h-t14 h-2 where" }, [this.device, this.dataset.farm].filter(Boolean).join(", "))];
    }
    showForm() {
      this.name = HL.draft.bind(el("input", { class: "h-input", "data-testid": "login-name", name: "username", autocomplete: "username", autocapitalize: "none", spellcheck: "false", required: true }), "login-name");
      this.password = el("input", { class: "h-input", "data-testid": "login-password", type: "password", name: "password", autocomplete: "current-password", required: true });
      this.submit = el("button", { class: "h-btn op pri", type: "submit", "data-testid": "login-submit" }, "Sign in");
      const form = el("form", { onsubmit: (event) => this.send(event) },
        el("label", { class: "h-field" }, "Name", this.name), el("label", { class: "h-field" }, "Password", this.password), this.message,
        el("div", { class: "h-row" }, this.submit, this.people.length ? el("button", { class: "h-btn op q", type: "button", onclick: () => this.showPeople() }, icon("arrow_back", "m"), "People") : ""));
      this.body.replaceChildren(...this.head("Sign in"), el("div", { class: "h-formwrap" }, form), HL.config.demo ? this.demo() : "");
      if (matchMedia("(pointer: fine)").matches) this.name.focus({ preventScroll: true });
    }
    demo() {
      const pick = (name) => el("button", { type: "button", class: "h-btn", "data-testid": `demo-${name}`, onclick: () => { this.name.value = name; this.password.value = name; this.name.dispatchEvent(new Event("input")); this.submit.focus(); } }, name);
      return el("div", { class: "h-demo" }, "Demo accounts, password equals the name:", el("div", {}, ...DEMO.map(pick)));
    }
    async send(event) {
      event.preventDefault();
      await this.attempt({ name: this.name.value.trim(), password: this.password.value });
    }
    async attempt(body) {
      if (this.isBusy) return;
      this.isBusy = true;
      text(this.message, "");
      if (this.submit) text(this.submit, "Signing in");
      if (this.asks) text(this.asks, "Signing in");
      const answer = await signIn(body);
      this.isBusy = false;
      if (answer.ok) return;
      if (this.submit) text(this.submit, "Sign in");
      if (this.asks) text(this.asks, this.pinOf());
      text(this.message, answer.text || "Not signed in.");
      this.setPin("");
    }
    showPeople() {
      this.chosen ??= this.people[0];
      const tile = (person) => el("button", { type: "button", class: "h-person", "data-testid": `login-person-${person.id}`, "aria-pressed": String(person === this.chosen), onclick: () => this.choose(person) },
        el("span", { class: "face" }, words.initials(person.name)), el("span", {}, el("span", { class: "h-t18 h-b" }, person.name), el("br"), el("span", { class: "h-t13" }, person.role)), person === this.chosen ? icon("check", "h-end") : "");
      this.dots = el("div", { class: "h-dots", role: "img" }, ...Array.from({ length: PIN_LENGTH }, () => el("i")));
      const key = (label, act, hook) => el("button", { type: "button", class: "h-btn", "data-testid": hook, onclick: act }, label);
      const digit = (n) => key(String(n), () => this.setPin(this.pin + n), `pin-${n}`);
      this.body.replaceChildren(
        el("div", { class: "cols" },
          el("div", {}, ...this.head("Who is working?"), el("div", { class: "h-people" }, ...this.people.map(tile)),
            el("button", { type: "button", class: "h-btn q", "data-testid": "login-other", onclick: () => this.showForm() }, icon("badge"), "Another name")),
          el("div", { class: "pin" }, (this.asks = el("div", { class: "h-t14 h-b h-2" }, this.pinOf())), this.dots,
            el("div", { class: "h-keys" }, ...[1, 2, 3, 4, 5, 6, 7, 8, 9].map(digit), el("span"), digit(0), key(icon("backspace"), () => this.setPin(this.pin.slice(0, -1)), "pin-back")), this.message)),
      );
      this.setPin(this.pin);
    }
    pinOf() {
      return `PIN for ${this.chosen.name.split(" ")[0]}`;
    }
    choose(person) {
      if (this.isBusy) return; // the answer that is on its way is the other one's
      this.chosen = person;
      text(this.message, "");
      this.setPin("");
      this.showPeople();
      this.body.querySelector(".h-person[aria-pressed=true]").focus({ preventScroll: true });
    }
    setPin(pin) {
      this.pin = pin.slice(0, PIN_LENGTH);
      if (this.dots) attr(this.dots, "aria-label", `${this.pin.length} of ${PIN_LENGTH} digits`);
      [...(this.dots?.children || [])].forEach((dot, i) => dot.classList.toggle("on", i < this.pin.length));
      if (this.pin.length === PIN_LENGTH && !this.isBusy) this.attempt({ name: this.chosen.id, pin: this.pin });
    }
    enter() {
      this.onKey = (event) => {
        if (!this.dots?.isConnected || event.ctrlKey || event.altKey || event.metaKey) return;
        if (/^\d$/.test(event.key)) this.setPin(this.pin + event.key);
        else if (event.key === "Backspace") this.setPin(this.pin.slice(0, -1));
      };
      window.addEventListener("keydown", this.onKey);
    }
    leave() {
      window.removeEventListener("keydown", this.onKey);
    }
  }

  // an enrolled tablet stops robots without anybody signed in
  function enrol() {
    const name = HL.draft.bind(el("input", { class: "h-input", "data-testid": "enrol-name", maxlength: "40", placeholder: "Tablet 3", autofocus: true }), "enrol-name");
    const problem = el("div", { class: "h-error", role: "alert" });
    HL.sheet({
      title: "Enrol this tablet",
      body: [
        el("p", { class: "h-2 h-t16" }, "STOP then works on this tablet before sign-in, and people can sign in with a PIN. An admin can take it out again."),
        el("label", { class: "h-field" }, "Name of this tablet", name),
        problem,
      ],
      buttons: [
        ["Leave it", (close) => close()],
        ["Enrol", async (close) => {
          if (!name.value.trim()) return name.focus();
          const answer = await post("/devices", { name: name.value.trim() });
          if (!answer.ok) return text(problem, answer.text || "Not enrolled.");
          keepToken(answer.stop_token);
          HL.draft.clear("enrol-name");
          HL.config.device = name.value.trim();
          close();
          return HL.toast(`Enrolled as ${HL.config.device}. STOP works here without sign-in.`, "tablet");
        }, true],
      ],
    });
  }

  // a browser that lost the token but not its session asks for it again: STOP must not wait for the next sign-in
  async function refetchToken() {
    if (!HL.config.user || stopToken()) return;
    const answer = await HL.port.api("GET", "/session");
    if (answer.ok && answer.stop_token) keepToken(answer.stop_token);
  }

  define("hl-login", Login);
  refetchToken();
  Object.assign(HL, { signOut, enrol });
})();
