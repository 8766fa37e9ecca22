// The two menus of the top bar: which robot, and who am I.
(() => {
  "use strict";
  const { el, icon, robotGlyph, text, attr, LiveElement, define, words } = HL;

  // a button with a panel below it; one panel at a time, Escape and a touch elsewhere close it
  class Menu extends LiveElement {
    toggle() {
      this.panel.hidden ? this.open() : this.close();
    }
    open() {
      document.querySelectorAll("hl-robot-switch, hl-user").forEach((menu) => menu !== this && menu.close());
      this.fill();
      this.panel.hidden = false;
      attr(this.button, "aria-expanded", "true");
      this.panel.querySelector("a, button")?.focus({ preventScroll: true });
    }
    close() {
      if (!this.panel || this.panel.hidden) return;
      if (this.panel.contains(document.activeElement)) this.button.focus({ preventScroll: true });
      this.panel.hidden = true;
      attr(this.button, "aria-expanded", "false");
    }
    enter() {
      this.onDown = (event) => this.contains(event.target) || this.close();
      this.onKey = (event) => event.key === "Escape" && this.close();
      document.addEventListener("pointerdown", this.onDown);
      document.addEventListener("keydown", this.onKey);
    }
    leave() {
      document.removeEventListener("pointerdown", this.onDown);
      document.removeEventListener("keydown", this.onKey);
    }
  }

  class RobotSwitch extends Menu {
    build() {
      this.sign = el("span", { class: "h-row" });
      this.name = el("span", { class: "h-t18 h-b h-nw" });
      this.kind = el("span", { class: "sub" });
      this.button = el(
        "button",
        { type: "button", class: "h-btn h-robotbtn", "data-testid": "robot-switch", "aria-haspopup": "true", "aria-expanded": "false", onclick: () => this.toggle() },
        this.sign, el("span", {}, this.name, this.kind), icon("unfold_more"),
      );
      this.panel = el("div", { class: "h-menu", hidden: true });
      this.append(this.button, this.panel);
    }
    fill() {
      const rows = Object.entries(HL.port.fleet()).sort((a, b) => a[1].name.localeCompare(b[1].name));
      this.panel.replaceChildren(
        ...rows.map(([id, robot]) =>
          el("a", { class: "item", href: HL.view.path(id), "data-testid": `robot-option-${id}`, "aria-current": id === HL.view.robot ? "true" : null, onclick: () => this.close() },
            robotGlyph(robot.family),
            el("span", {}, robot.name, el("span", { class: "sub" }, [robot.is_registered === false ? "New, not accepted yet" : robot.text, robot.is_online === false ? "not heard" : ""].filter(Boolean).join(" · "))),
          ),
        ),
        rows.length ? "" : el("div", { class: "line h-2" }, "No robots yet."),
      );
    }
    paint() {
      attr(this, "hidden", !HL.view.robot && HL.view.screen !== "operate");
      const known = HL.view.robot ? HL.port.robot(HL.view.robot).id : null;
      text(this.name, HL.view.robot ? HL.view.name() : "Choose a robot");
      text(this.kind, HL.view.robot ? `${known?.kind_label ?? "Robot"} · switch robot` : "");
      const family = known?.family ?? "weeder";
      if (this.family !== family) {
        this.family = family;
        this.sign.replaceChildren(robotGlyph(family));
      }
    }
  }

  const UNITS = [["speed", "Speed"], ["area", "Area"], ["length", "Length"], ["temperature", "Temperature"]];

  function choice(key, label, hook) {
    const row = el("div", { class: "h-seg", role: "radiogroup", "aria-label": label, "data-testid": hook });
    const draw = () =>
      row.replaceChildren(
        ...HL.preferences.CHOICES[key].map((value) =>
          el("button", { type: "button", role: "radio", "aria-checked": String(HL.preferences.get(key) === value), "data-value": value, onclick: () => (HL.preferences.set(key, value), draw()) }, value),
        ),
      );
    draw();
    return el("div", { class: "line" }, label, row);
  }

  class UserMenu extends Menu {
    build() {
      const user = HL.config.user;
      this.button = el(
        "button",
        { type: "button", class: "h-btn ico round", "data-testid": "user-menu", "aria-haspopup": "true", "aria-expanded": "false", "aria-label": `${user.name}, ${user.role}`, onclick: () => this.toggle() },
        words.initials(user.name),
      );
      this.button.style.justifyContent = "center";
      this.panel = el("div", { class: "h-menu right", hidden: true });
      this.append(this.button, this.panel);
    }
    fill() {
      const { user, device, rights } = HL.config;
      const item = (sign, label, act, hook) => el("button", { type: "button", class: "item", "data-testid": hook, onclick: () => (this.close(), act()) }, icon(sign), label);
      this.panel.replaceChildren(
        el("div", { class: "line" }, el("span", {}, el("span", { class: "h-t18 h-b" }, user.name), el("span", { class: "sub" }, [user.role, device || "this browser"].join(" · ")))),
        el("hr"),
        el("div", { "data-testid": "units" }, ...UNITS.map(([key, label]) => choice(key, label, `units-${key}`))),
        choice("confirm", "Confirm by", "confirm-by"),
        el("div", { class: "line h-2 h-t14", "data-testid": "stay-awake" }, HL.awake.line()),
        el("hr"),
        rights.includes("enrol_device") ? item("tablet", device ? `Enrolled as ${device}` : "Enrol this tablet", HL.enrol, "enrol") : "",
        item("keyboard", "Keys", HL.showKeys, "keys"),
        item("logout", "Sign out", HL.signOut, "sign-out"),
      );
    }
  }

  define("hl-robot-switch", RobotSwitch);
  define("hl-user", UserMenu);
})();
