// What a person chose on this device: theme, units, how to confirm; and drafts that outlive an outage.
(() => {
  "use strict";
  const { el, icon, LiveElement, define, attr, text } = HL;
  const KEY = "headland.preferences";
  const CHOICES = {
    theme: ["day", "night", "sunlight"],
    speed: ["m/s", "km/h", "mph"],
    area: ["ha", "ac"],
    length: ["m", "ft"],
    temperature: ["°C", "°F"],
    confirm: ["slide", "hold"],
  };

  function read(key, fallback) {
    try {
      return JSON.parse(localStorage.getItem(key)) ?? fallback;
    } catch {
      return fallback;
    }
  }

  function write(key, value) {
    try {
      localStorage.setItem(key, JSON.stringify(value));
    } catch {
      // a full or forbidden store only costs the convenience
    }
  }

  let kept = read(KEY, {});
  const get = (key) => (CHOICES[key].includes(kept[key]) ? kept[key] : CHOICES[key][0]);

  function set(key, value) {
    kept = { ...read(KEY, {}), [key]: value };
    write(KEY, kept);
    if (key === "theme") document.documentElement.dataset.theme = value;
    HL.emit("headland:preferences", { key, value });
    HL.repaint();
  }

  window.addEventListener("storage", (event) => {
    if (event.key !== KEY) return;
    kept = read(KEY, {});
    document.documentElement.dataset.theme = get("theme");
    HL.repaint();
  });

  // drafts: text somebody typed stays until it was sent, per person
  const draftKey = (name) => `headland.draft.${HL.config.user?.id || "-"}.${name}`;
  const draft = {
    get: (name) => read(draftKey(name), ""),
    set: (name, value) => (value ? write(draftKey(name), value) : draft.clear(name)),
    clear: (name) => {
      try {
        localStorage.removeItem(draftKey(name));
      } catch {
        // nothing was kept then
      }
    },
    // keeps an input's text; never used for passwords and PINs
    bind(input, name) {
      input.value = draft.get(name) || input.value;
      input.addEventListener("input", () => draft.set(name, input.value));
      return input;
    },
  };

  const THEME_ICONS = { day: "light_mode", night: "dark_mode", sunlight: "wb_sunny" };

  class ThemeButton extends LiveElement {
    build() {
      this.sign = icon("light_mode");
      this.button = el("button", { type: "button", class: "h-btn ico", "data-testid": "theme", onclick: () => this.next() }, this.sign);
      this.append(this.button);
    }
    next() {
      const themes = CHOICES.theme;
      set("theme", themes[(themes.indexOf(get("theme")) + 1) % themes.length]);
    }
    paint() {
      text(this.sign, THEME_ICONS[get("theme")]);
      attr(this.button, "data-state", get("theme"));
      attr(this.button, "aria-label", `Theme: ${get("theme")}. Change`);
    }
  }

  define("hl-theme", ThemeButton);
  Object.assign(HL, { preferences: { get, set, CHOICES }, draft, keep: { read, write } });
})();
