// Why is it not moving: one sentence, what clears it, who can.
(() => {
  "use strict";
  const { el, icon, text, attr, LiveElement, define } = HL;

  const RIGHT_OF = { operator: "lease", admin: "manage_robots" };
  const isMe = (who) => HL.config.rights.includes(RIGHT_OF[who]);

  class Why extends LiveElement {
    build() {
      this.head = el("b");
      this.line = el("span", { class: "h-2" });
      this.append(icon("info"), el("div", {}, this.head, this.line));
    }
    paint() {
      const why = HL.port.robot(HL.view.robot).why;
      const isOld = HL.linkState() !== "ok" && HL.linkState() !== "stale";
      const stop = HL.stops.worst(HL.view.robot);
      attr(this, "hidden", !why || isOld || Boolean(stop && stop.state !== "reset"));
      attr(this, "data-value", why?.code ?? "");
      if (!why) return;
      text(this.head, why.text);
      text(this.line, [why.clears, why.who && !isMe(why.who) ? `Who: ${why.who}.` : ""].filter(Boolean).join(" "));
    }
  }

  define("hl-why", Why);
})();
