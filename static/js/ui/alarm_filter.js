// Above the list: which tab, which robot, how urgent, words to search for, and whether it can be heard.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const TABS = [["active", "Active"], ["shelved", "Shelved"], ["journal", "Journal"], ["statistics", "Statistics"]];
  const LEVELS = [["0", "All priorities"], ...[1, 2, 3, 4].map((level) => [String(level), `Priority ${level}`])];

  class Filter {
    constructor(onchange) {
      this.tab = "active";
      this.onchange = onchange;
      this.tabs = TABS.map(([name, label]) => el("button", { type: "button", "data-tab": name, "data-testid": `alarms-tab-${name}`, onclick: () => this.go(name) }, label));
      this.robot = el("select", { class: "h-select", "aria-label": "Robot", "data-testid": "alarm-filter-robot", onchange }, el("option", { value: "" }, "All robots"));
      this.level = el("select", { class: "h-select", "aria-label": "Priority", "data-testid": "alarm-filter-priority", onchange }, ...LEVELS.map(([value, label]) => el("option", { value }, label)));
      this.search = el("input", { class: "h-input", type: "search", placeholder: "Search", "aria-label": "Search alarms", "data-testid": "alarm-search", oninput: onchange });
      this.soundSign = icon("volume_up", "m");
      this.soundWord = el("span");
      this.sound = el("button", { type: "button", class: "h-btn al-sound", "data-testid": "alarm-sound-button", onclick: () => HL.bell?.turnOn() }, this.soundSign, this.soundWord);
      this.node = el("div", { class: "al-tools" }, el("div", { class: "h-seg", role: "group", "aria-label": "Alarms" }, ...this.tabs), el("span", { class: "h-sp" }), this.robot, this.level, this.search, this.sound);
    }

    go(name) {
      this.tab = name;
      this.onchange();
    }

    value() {
      return { robot: this.robot.value, priority: Number(this.level.value), q: this.search.value.trim() };
    }

    isOn() {
      const { robot, priority, q } = this.value();
      return Boolean(robot || priority || q);
    }

    clear() {
      this.robot.value = this.search.value = "";
      this.level.value = "0";
      this.onchange();
    }

    paint(active, aside, sources) {
      this.tabs.forEach((button, i) => attr(button, "aria-pressed", String(TABS[i][0] === this.tab)));
      text(this.tabs[0], `Active ${active}`);
      text(this.tabs[1], `Shelved ${aside}`);
      this.offer(sources);
      for (const field of [this.robot, this.level, this.search]) attr(field, "hidden", this.tab === "statistics"); // those are of all
      const state = HL.bell?.state() ?? "blocked";
      attr(this.sound, "data-state", state);
      text(this.soundSign, state === "on" ? "volume_up" : "volume_off");
      text(this.soundWord, state === "on" ? "Sound on" : state === "silenced" ? `Silent ${HL.words.clock(HL.bell.silentMs() / 1000)}` : "Sound is off. Tap to turn on.");
      attr(this.sound, "title", state === "on" ? "Play a test tone" : "Turn the sound on");
    }

    // robots and other sources, by name; one that is chosen stays on offer
    offer(sources) {
      const key = JSON.stringify(sources);
      if (key === this.offered) return;
      this.offered = key;
      const chosen = this.robot.value;
      const all = chosen && !sources.some(([id]) => id === chosen) ? [...sources, [chosen, chosen]] : sources;
      this.robot.replaceChildren(el("option", { value: "" }, "All robots"), ...all.map(([id, name]) => el("option", { value: id }, name)));
      this.robot.value = chosen;
    }
  }

  HL.AlarmFilter = Filter;
})();
