// The Twin screen: the frame with the picture, what lies over it, and joints beside it.
(() => {
  "use strict";
  const { el, icon, text, attr, style, toggle, LiveElement } = HL;

  class Twin extends LiveElement {
    build() {
      this.frame = el("iframe", { class: "t-frame", title: "3D picture of the robot", tabindex: "0" });
      this.overlay = el("div", { class: "t-overlay", "aria-live": "polite" }, el("div", { class: "h-card h-row" }, (this.sign = icon("hourglass_top")), (this.words = el("b", { class: "h-t18 h-b" }))));
      this.append(this.frame, this.overlay);
    }

    enter() {
      const robot = this.dataset.robot;
      this.link = new HL.TwinLink(robot, this.frame);
      this.layers = new HL.TwinLayers(this.link);
      this.replay = new HL.TwinReplay(this.link, robot, this.dataset.noReplay);
      this.details = new HL.TwinDetails(robot, this.link, () => this.replay.isReplay || this.link.isPast());
      this.replay.onturn = () => this.details.close();
      this.model = new HL.TwinModel(robot, this.dataset.mayModel === "yes");
      this.parts = [this.layers.node, this.replay.node, this.details.node];
      this.append(...this.parts);
      this.layers.list.append(this.model.node);
      this.link.on("tap", (said) => this.details.show(said));
      this.link.on("status", (said) => this.details.follow(said.touched));
      this.link.on("key", ({ key }) => this.key(key));
      this.link.on("ready", () => this.themed());
      this.themes = new MutationObserver(() => this.themed());
      this.themes.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
      HL.twin = this;
      this.themed();
    }

    leave() {
      HL.twin = null;
      this.themes.disconnect();
      this.replay.close();
      this.details.close();
      this.link.close();
      this.parts.forEach((part) => part.remove());
    }

    key(key) {
      if (key === "0") this.layers.choose(this.layers.view);
      else this.link.send({ k: "zoom", by: key === "+" ? 0.8 : 1.25 });
    }

    themed() {
      const theme = document.documentElement.dataset.theme || "day";
      this.frame.contentWindow?.postMessage({ kind: "theme", theme }, location.origin);
      this.link?.wish("theme", { k: "theme", dark: theme === "night" });
    }

    paint() {
      if (!this.link) return;
      const isPast = this.link.isPast();
      const gap = isPast ? this.replay.gap() : "";
      const now = this.link.judge(isPast);
      const { state, text: words } = gap && now.state === "live" ? { state: "stale", text: gap } : now;
      attr(this, "data-state", state);
      const age = this.link.poseAge();
      attr(this, "data-age-ms", age === null ? null : Math.round(age * 1000));
      attr(this, "data-frames", this.link.picture.frames);
      toggle(this, "past", isPast);
      toggle(this, "stale", state === "stale");
      attr(this.overlay, "hidden", state === "live");
      text(this.words, words);
      text(this.sign, state === "connecting" ? "hourglass_top" : state === "stale" ? "schedule" : "map");
      const map = this.parentElement.querySelector(".t-map");
      const isMap = state === "unavailable";
      attr(map, "hidden", !isMap);
      style(this.frame, "visibility", isMap ? "hidden" : "visible");
      for (const part of [this.layers.node, this.replay.node]) toggle(part, "gone", isMap);
      this.layers.paint(isPast);
      this.replay.paint();
      this.details.paint();
      this.model.paint(this.link.status);
    }
  }

  class Side extends LiveElement {
    build() {
      this.side = new HL.TwinSide();
      this.append(this.side.node);
    }
    paint() {
      const isRecord = HL.twin?.replay.isReplay && HL.twin.link.isPast();
      if (HL.view.robot) this.side.paint(HL.view.robot, isRecord ? HL.twin.replay.past?.joints ?? {} : undefined);
    }
  }

  addEventListener("keydown", (event) => {
    const isTyping = event.target instanceof HTMLElement && event.target.closest("input:not([type=range]), textarea, select");
    if (HL.twin && !isTyping && !event.ctrlKey && !event.altKey && !event.metaKey && ["+", "-", "0"].includes(event.key)) HL.twin.key(event.key);
  });

  HL.superDefine("hl-twin", Twin);
  HL.superDefine("hl-twin-side", Side);
})();
