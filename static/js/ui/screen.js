// The screen that is shown: it announces itself, so that frame, lane and STOP follow without a reload.
(() => {
  "use strict";
  const { el, icon, robotGlyph, text, attr, LiveElement, define } = HL;
  const LAST_KEY = "headland.robot";

  function show(screen) {
    Object.assign(HL.view, { screen: screen.dataset.screen, robot: screen.dataset.robot || null, title: screen.dataset.title || "" });
    document.querySelector(".h-app")?.setAttribute("data-screen", HL.view.screen);
    attr(document.querySelector("main.q-page"), "role", "presentation"); // ours is the one landmark
    document.title = `${HL.view.title} · Headland`;
    for (const link of document.querySelectorAll("[data-nav]")) attr(link, "aria-current", link.dataset.nav === HL.view.screen ? "page" : null);
    document.querySelector(".h-app")?.toggleAttribute("data-one-robot", Boolean(HL.view.robot));
    document.querySelector("[data-nav][aria-current]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
    HL.rail?.mark();
    if (HL.view.robot) HL.keep.write(LAST_KEY, HL.view.robot);
    HL.port.watch();
    window.headlandStop?.setScope(HL.view.robot ? { kind: "robot", id: HL.view.robot, name: HL.view.name() } : { kind: "all" });
    HL.repaint();
  }

  // scripts that only this screen needs, those of data-late after the first picture; its elements come to life when they have arrived
  const loaded = new Map();
  function load(src) {
    if (!loaded.has(src)) loaded.set(src, new Promise((done) => {
      const script = el("script", { src, onload: done });
      script.async = false; // the first named comes first
      script.onerror = () => (loaded.delete(src), HL.toast("This screen did not load. Open it again.", "cloud_off"), done());
      document.head.append(script);
    }));
    return loaded.get(src);
  }
  const sources = (list) => (list || "").split(" ").filter(Boolean);

  // what a late script brings, for who asks before it has come; undefined where it did not load
  async function late(name) {
    if (!HL[name]) await Promise.all(sources(document.querySelector("hl-screen")?.dataset.late).map(load));
    return HL[name];
  }

  // a section pressed before its script has come: it says so at once and is the one that opens
  function pressEarly(event) {
    const tab = event.target.closest("[data-tab]");
    if (!tab || event.currentTarget.querySelector(":defined > .h-sec")) return;
    HL.draft.set(`${HL.view.screen}-tab`, tab.dataset.tab);
    for (const one of event.currentTarget.querySelectorAll("[data-tab]")) attr(one, "aria-pressed", String(one === tab));
  }

  class Screen extends HTMLElement {
    connectedCallback() {
      show(this);
      if (this.querySelector("[data-tab]")) this.addEventListener("click", pressEarly);
      for (const src of sources(this.dataset.code)) load(src);
      if (this.dataset.late) HL.port.firstPicture().then(() => sources(this.dataset.late).forEach(load));
    }
  }

  // opens the robot shown last; when there is none, offers those there are
  class PickRobot extends LiveElement {
    build() {
      this.list = el("div", { class: "h-pick" });
      this.append(el("h1", { class: "h-t22 h-b h-pickhead" }, "Choose a robot"), this.list);
      const known = (this.dataset.known || "").split(" ").filter(Boolean);
      const last = HL.keep.read(LAST_KEY, "");
      const target = known.includes(last) ? last : known.length === 1 ? known[0] : "";
      if (target) setTimeout(() => this.isConnected && go(HL.view.path(target), true), 0);
    }
    paint() {
      const robots = Object.entries(HL.port.fleet()).sort((a, b) => a[1].name.localeCompare(b[1].name));
      const key = robots.map(([id, robot]) => `${id}:${robot.name}:${robot.text}`).join("|") + HL.port.server().isKnown;
      if (key === this.drawn) return;
      this.drawn = key;
      this.list.replaceChildren(
        ...robots.map(([id, robot]) => el("a", { class: "h-card", href: HL.view.path(id), "data-testid": `robot-option-${id}` }, robotGlyph(robot.family, 40), el("span", {}, el("b", { class: "h-t18 h-b" }, robot.name), el("br"), el("span", { class: "h-2 h-t14" }, robot.is_registered ? robot.text : "New, not accepted yet")))),
        robots.length ? "" : el("div", { class: "h-notice h-card" }, icon("smart_toy", "l"), el("b", { class: "h-t22 h-b" }, HL.port.server().isKnown ? "No robot yet" : "Loading robots"), el("span", { class: "h-2 h-t16" }, HL.port.server().isKnown ? "Robots that are heard appear here by themselves." : "The list comes with the first answer of the server.")),
      );
    }
  }

  // moves inside the shell, as a link of it would
  function go(path, isReplacing) {
    const link = el("a", { href: path });
    link.style.display = "none";
    document.body.append(link);
    if (isReplacing) HL.isReplacing = true;
    link.click();
    link.remove();
  }

  // until the first values are there; after five seconds it says what is wrong
  class Connecting extends LiveElement {
    build() {
      this.head = el("b", { class: "h-t18 h-b" });
      this.line = el("span", { class: "h-2 h-t14" });
      this.append(el("div", { class: "h-card h-row" }, icon("hourglass_top"), el("span", { class: "h-col" }, this.head, this.line)));
      this.from = performance.now();
    }
    paint() {
      const { mode, link } = HL.port.robot(HL.view.robot);
      attr(this, "hidden", Boolean(mode));
      if (mode) return;
      const isLate = performance.now() - this.from > 5000;
      text(this.head, isLate ? `${this.dataset.name} does not answer` : `Connecting to ${this.dataset.name}`);
      text(this.line, isLate ? (link?.t ? `Last heard ${HL.words.age(HL.port.age(link.t))} ago.` : "It was not heard since the server started. Look at its power and radio.") : "Waiting for its first values");
    }
  }

  class DockHint extends LiveElement {
    build() {
      this.append(el("span", { class: "h-hint" }, ...(this.dataset.text || "").split("|").flatMap((line, i) => (i ? [el("br"), line] : [line]))));
    }
  }

  HL.view = {
    screen: "", robot: null, title: "",
    path: (id) => `/${HL.view.screen || "operate"}/${id}`, // another robot on this screen
    name: () => HL.port.robot(HL.view.robot).id?.name || HL.port.fleet()[HL.view.robot]?.name || HL.view.title || HL.view.robot || "",
  };
  define("hl-pick-robot", PickRobot);
  define("hl-connecting", Connecting);
  define("hl-dock-hint", DockHint);
  Object.assign(HL, { go, load, late, startScreens: () => define("hl-screen", Screen) });
})();
