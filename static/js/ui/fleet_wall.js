// Wall mode: the same facts in big type for a screen nobody touches. It rotates nothing; STOP is where it always is.
(() => {
  "use strict";
  const { el, alarm, robotGlyph, text, attr, LiveElement } = HL;
  const GAP_PX = 8; // as in its style
  const MOST = 12; // what can be read across a room

  class WallRow {
    constructor() {
      this.sign = el("span");
      this.name = el("b", { class: "h-ell" });
      this.head = el("span", { class: "head h-ell" });
      this.line = el("span", { class: "line h-ell" });
      this.time = el("span", { class: "time" });
      this.node = el("div", { class: "w-row" }, this.sign, this.name, el("span", { class: "said" }, this.head, this.line), this.time);
    }
    paint(one) {
      const { verdict, robot } = one;
      const key = `${verdict.level}/${verdict.look}/${robot.family}`;
      if (key !== this.key) {
        this.key = key;
        this.sign.replaceChildren(verdict.level ? alarm(verdict.level, 40, verdict.look) : robotGlyph(robot.family, 40));
      }
      attr(this.node, "data-testid", `wall-row-${one.id}`);
      attr(this.node, "data-level", verdict.level);
      text(this.name, robot.name);
      text(this.head, verdict.head);
      text(this.line, verdict.line);
      const asks = typeof verdict.since === "number" && (verdict.waits || !verdict.isLost);
      text(this.time, asks ? HL.words.clock(HL.port.age(verdict.since) / 1000) : "");
    }
  }

  class Wall extends LiveElement {
    build() {
      this.rows = [];
      this.sum = el("div", { class: "w-sum", role: "status", "data-testid": "wall-sum" });
      this.list = el("div", { class: "w-list" });
      this.rest = el("div", { class: "w-rest" });
      this.old = el("div", { class: "w-old", role: "alert", hidden: true });
      this.append(this.old, this.sum, this.list, this.rest);
    }
    enter() {
      HL.fleet.begin();
      this.sizes = new ResizeObserver(() => (this.looked = null));
      this.sizes.observe(this.list);
    }
    leave() {
      HL.fleet.end();
      this.sizes.disconnect();
    }
    // whole rows alone: half a row says nothing
    room() {
      const high = this.rows[0]?.node.offsetHeight;
      return high ? Math.min(MOST, Math.max(1, Math.floor((this.list.clientHeight + GAP_PX) / (high + GAP_PX)))) : MOST;
    }
    paint() {
      const silentMs = HL.port.server().silentMs;
      const isSilent = silentMs >= HL.STALE_MS;
      const isOld = isSilent || HL.alarms.isOld();
      attr(this.old, "hidden", !isOld);
      text(this.old, isSilent ? `No data for ${HL.words.since(silentMs)}. What is below is old.` : `Alarms are ${HL.words.since(HL.alarms.ageMs() ?? 0)} old. Do not rely on them.`);
      attr(this, "data-old", isOld ? "" : null);
      if (this.isUnsure !== (isOld || !HL.alarms.summary())) this.looked = null;
      this.isUnsure = isOld || !HL.alarms.summary();
      if (this.looked === HL.fleet.looks) return;
      this.looked = this.rows.length ? HL.fleet.looks : null; // before the first row nothing could be measured
      const sections = HL.fleetOrder.sections(HL.fleet.items, { groups: HL.fleet.groups, notices: HL.fleet.notices });
      const [needs, watch, normal] = sections;
      const shown = [...needs.items, ...watch.items].slice(0, this.room());
      while (this.rows.length < shown.length) this.rows.push(new WallRow());
      const nodes = shown.map((one, i) => (this.rows[i].paint(one), this.rows[i].node));
      if (nodes.length !== this.list.children.length) this.list.replaceChildren(...nodes);
      const count = needs.items.length;
      const none = this.isUnsure ? "Who is needed is not known" : HL.fleet.items.length ? "Nobody is needed" : "No robots yet";
      text(this.sum, count ? `${count} ${count === 1 ? "needs" : "need"} somebody` : none);
      const askers = needs.items.slice(shown.length).length;
      const watched = watch.items.length - (shown.length - (count - askers));
      text(this.rest, [askers ? `${askers} more ${askers === 1 ? "needs" : "need"} somebody` : "", watched ? `${watched} ${watched < watch.items.length ? "more " : ""}to watch` : "", HL.fleet.items.length ? `${normal.count} normal` : ""].filter(Boolean).join(" · "));
    }
  }

  // make and take out wall screens
  async function walls() {
    const list = el("div", { class: "f-kept" });
    const name = el("input", { class: "h-input", maxlength: "80", placeholder: "Where it hangs", "aria-label": "Where it hangs", "data-testid": "wall-name" });
    const said = el("div", { class: "h-t14" });
    const draw = async () => {
      const answer = await HL.port.api("GET", "/fleet/walls");
      if (!answer.ok) return list.replaceChildren(el("span", { class: "h-error" }, answer.text));
      const open = answer.walls.filter((one) => !one.revoked_at);
      return list.replaceChildren(...(open.length ? open.map((one) => el("div", { class: "h-row" }, el("span", { class: "h-col f-view" }, el("b", {}, one.name), el("span", { class: "h-2 h-t13" }, `Made by ${one.made_by}, ${HL.records.when(one.made_at)}`)), el("button", { type: "button", class: "h-btn", "data-testid": `wall-revoke-${one.name}`, onclick: async () => (await HL.port.api("DELETE", `/fleet/walls/${one.id}`), draw()) }, "Take out"))) : [el("span", { class: "h-2" }, "No wall screens yet.")]));
    };
    const make = async () => {
      const answer = await HL.port.api("POST", "/fleet/walls", { name: name.value.trim() });
      if (!answer.ok) return said.replaceChildren(el("span", { class: "h-error" }, answer.text));
      const link = `${location.origin}/login#wall=${answer.key}`;
      name.value = "";
      said.replaceChildren(el("p", {}, "Open this address once on the wall screen, signed out. It is shown only now."), el("input", { class: "h-input", readonly: true, value: link, "aria-label": "Address for the wall screen", "data-testid": "wall-link", onfocus: (event) => event.target.select() }));
      return draw();
    };
    await draw();
    HL.sheet({ title: "Wall screens", hook: "wall-sheet", body: [el("p", { class: "h-2 h-t16" }, "A wall screen shows the fleet, may stop, and can do nothing else. It does not sign out by itself."), list, el("div", { class: "h-row" }, name, el("button", { type: "button", class: "h-btn", "data-testid": "wall-make", onclick: make }, "Make one")), said], buttons: [["Close", (close) => close(), true]] });
  }

  Object.assign(HL, { Wall, fleetWalls: walls });
})();
