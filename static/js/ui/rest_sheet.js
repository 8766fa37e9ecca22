// The rest of a mission: change it while it runs, or take it up again from where the robot stands.
// Everything is planned and shown first; what was sent counts only when the robot has read it back.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const WAIT_MS = 700; // after the last tap
  const PLAN_MS = 60000;
  const SEND_MS = 15000;
  const SPEEDS = [["", "As planned"], ["0.2", "0.20 m/s"], ["0.3", "0.30 m/s"], ["0.45", "0.45 m/s"], ["0.6", "0.60 m/s"]];

  const of = (id) => `/missions/${encodeURIComponent(id)}`;
  const kwh = (j) => `${(j / 3.6e6).toFixed(1)} kWh`;
  const share = (part) => `${Math.round(100 * part)} %`;
  const area = (m2) => { const shown = HL.units.area(m2); return `${shown.text} ${shown.unit}`; };
  // a difference that its own words round to nothing is no difference anybody can see
  const less = (before, after, words) => (words(Math.abs(after - before)) === words(0) ? (before === after ? "same" : "about the same") : `${after < before ? "−" : "+"}${words(Math.abs(after - before))}`);

  function table(shown) {
    const { before: a, after: b } = shown;
    const lines = [["Time", a.duration_s, b.duration_s, HL.words.left], ["Energy", a.energy_j, b.energy_j, kwh], ["Battery", a.battery_share, b.battery_share, share], ["Area", a.area_m2, b.area_m2, area], ["Rows", a.rows, b.rows, String]];
    return HL.records.table(["Left to do", "Now", "New", "Difference"], lines.map(([name, was, is, words]) => ({ cells: [name, words(was), words(is), less(was, is, words)] })));
  }

  // whether the rest is another one although nobody asked for anything: most often the field or what stands in it changed
  const isOther = ({ before: a, after: b, notes }) => notes.length > 0 || Math.abs(a.length_m - b.length_m) > 1 || Math.abs(a.area_m2 - b.area_m2) > 1;

  class Sheet {
    constructor(mission, kind) {
      Object.assign(this, { mission, kind, out: new Set(), turn: 0 });
      this.said = el("div", { class: "h-t16 h-b", role: "status", "data-testid": "rest-said" }, "Looking at how far it is");
      this.options = el("div", { class: "h-col" });
      this.shown = el("div", { class: "h-col" });
      const robot = HL.port.fleet()[mission.robot_id]?.name ?? "the robot";
      this.map = new HL.RestMap(`New path of ${mission.name}`, kind === "change" ? `The arrow is where ${robot} was when this was planned.` : "The arrow is where it goes on.", () => this.soon());
      this.close = HL.sheet({ title: kind === "change" ? `Change the rest: ${mission.name}` : `Resume later: ${mission.name}`, hook: "rest-sheet", body: [el("div", { class: "h-restcols" }, el("div", { class: "h-col" }, this.options, this.said, this.shown), this.map.node)], buttons: [["Keep it as it is", (close) => close()], [kind === "change" ? "Send update" : "Send the way back", () => this.send(), true]] });
      this.button = document.querySelector("[data-testid=rest-sheet] .foot .pri");
      attr(this.button, "data-testid", "rest-send");
      this.button.disabled = true;
      this.load();
    }
    async load() {
      const [rest, places, shape] = await Promise.all([HL.port.api("GET", `${of(this.mission.id)}/rest`), HL.port.api("GET", "/fields"), HL.port.api("GET", `${of(this.mission.id)}/map.geojson`)]);
      if (!rest.ok) return this.say(`Not loaded: ${rest.text || "no answer"}`, "error");
      this.rest = rest.data;
      if (!this.rest.progress) return this.say("How far it came is not known. Start it fresh.", "error");
      if (this.kind === "change") this.options.replaceChildren(...this.choices(places.ok ? places.data.homes : []));
      else this.options.replaceChildren(el("p", { class: "h-t16" }, `It goes on exactly where it stopped${this.place()}: nothing twice, nothing left out. First it drives there with the tool off.`));
      this.map.areas = this.rest.areas ?? [];
      this.asItIs = JSON.stringify(this.wish());
      this.map.tools.hidden = this.map.note.hidden = this.map.list.hidden = this.kind !== "change";
      if (shape.ok) this.map.show((this.base = shape.data), this.rest.progress);
      this.plan();
    }
    place() {
      const first = this.rest.pieces[0];
      return first ? `, ${first.is_present ? "inside" : "before"} ${first.name.toLowerCase()}` : "";
    }
    choices(homes) {
      const rows = new Map(); // a row may lie there in several pieces, e.g. on both sides of an obstacle
      for (const one of this.rest.pieces) {
        const key = one.row || `lap ${one.lap ?? one.number}`;
        if (rows.has(key)) rows.get(key).push(one.number);
        else rows.set(key, Object.assign([one.number], { one }));
      }
      const chips = [...rows.values()].map((numbers) => {
        const { one } = numbers;
        const chip = el("button", { type: "button", class: "h-btn h-piece", role: "checkbox", "aria-checked": "true", title: `${one.name}, ${one.length_m} m`, "data-testid": `rest-piece-${one.number}`, onclick: () => { const isOut = !this.out.has(one.number); for (const number of numbers) isOut ? this.out.add(number) : this.out.delete(number); attr(chip, "aria-checked", String(!isOut)); this.soon(); } }, one.row ? String(one.row) : `Lap ${one.lap ?? ""}`.trim());
        return chip;
      });
      const pick = (label, hook, options) => el("label", { class: "h-field" }, label, (this[hook] = el("select", { class: "h-select", "data-testid": `rest-${hook}`, onchange: () => this.soon() }, ...options.map(([value, name]) => el("option", { value }, name)))));
      return [
        el("p", { class: "h-t14 h-2" }, `Row ${this.rest.progress.row} of ${this.rest.progress.rows}. Tap what shall not be done; what is done stays done.`),
        el("div", { class: "h-pieces", role: "group", "aria-label": "Rows still to do" }, ...chips),
        el("div", { class: "h-restgrid" },
          pick("Order", "order", [["", "As planned"], ["turned", "Last row first"]]),
          pick("Working speed", "speed", SPEEDS),
          pick("At the end", "end", [["as_planned", "As planned"], ["stay", "Stay there"], ["home", "Drive home"], ...homes.map((one) => [`home:${one.id}`, `Drive to ${one.name || one.id}`])])),
      ];
    }
    wish() {
      if (this.kind !== "change") return { kind: "later" };
      const [end, home] = this.end.value.split(":");
      return { kind: "change", leave_out: [...this.out], areas: this.map.areas, is_reversed: this.order.value === "turned", row_speed_mps: this.speed.value ? Number(this.speed.value) : null, end, home_id: home ?? null };
    }
    soon() {
      clearTimeout(this.timer);
      this.button.disabled = true;
      this.turn += 1; // what is still on its way was planned without this
      this.planned = null;
      this.say("Planning", "");
      this.timer = setTimeout(() => this.plan(), WAIT_MS);
    }
    async plan() {
      const turn = ++this.turn;
      this.button.disabled = true;
      this.say("Planning the rest", "busy");
      const wish = this.wish(), wished = JSON.stringify(wish);
      const answer = await HL.port.api("POST", `${of(this.mission.id)}/rest/preview`, wish, PLAN_MS);
      if (turn !== this.turn || !this.said.isConnected) return;
      this.shown.replaceChildren();
      if (answer.code === "not_standing") { // it was paused a moment ago
        this.say(`${answer.text} It is planned as soon as it stands.`, "busy");
        this.timer = setTimeout(() => this.said.isConnected && this.plan(), WAIT_MS);
        return;
      }
      if (!answer.ok) return this.say(answer.text || "Not planned: no answer. Try again.", "error");
      this.planned = answer.data;
      this.wished = wished;
      const { left_out: out, notes, kept_until: kept, way_m: way } = this.planned;
      const isAsItWas = this.kind === "change" && this.wished === this.asItIs;
      const isSame = isAsItWas && !isOther(this.planned);
      this.say(isSame ? "Nothing changed yet." : this.kind !== "change" ? `Way back ${Math.round(way)} m.` : isAsItWas ? `You changed nothing, yet it comes out another way now. ${kept}` : kept, "ready");
      const lines = [...(out.length ? [`Left out: ${out.join(", ")}.`] : []), ...notes];
      this.shown.append(this.kind === "change" ? table(this.planned) : "", ...lines.map((line) => el("div", { class: "h-row h-t14 h-b" }, icon("info", "m"), line)));
      this.map.show(this.pictured(this.planned.geometry), this.planned.progress);
      this.button.disabled = isSame;
    }
    // areas with a dose of their own stay as they were planned
    pictured(geometry) {
      const doses = (this.base?.features ?? []).filter((one) => one.properties.kind === "dose");
      return { ...geometry, features: [...geometry.features, ...doses] };
    }
    async send() {
      if (this.button.disabled) return;
      if (!this.planned || JSON.stringify(this.wish()) !== this.wished) return this.soon();
      const { turn } = this;
      const tick = window.headland.tick();
      if (tick === null) return this.say("Not sent: the link to the server is lost.", "error");
      this.button.disabled = true;
      this.say("Update sent, not confirmed", "busy");
      const answer = await HL.port.api("POST", `${of(this.mission.id)}/rest`, { sha256: this.planned.sha256, tick }, SEND_MS);
      const isTaken = answer.data?.outcome === "accepted" || answer.outcome === "accepted";
      if (isTaken) {
        this.close();
        return HL.toast(this.kind === "change" ? "The robot has read the new rest back" : "The robot has the way back. Slide to resume", "check");
      }
      if (turn !== this.turn) return HL.toast(`Not changed: ${answer.data?.text || answer.text || "no answer"}`, "cloud_off"); // another one is planned already
      this.say(`Not changed: ${answer.data?.text || answer.text || "no answer. Look at the robot before you send again."}`, "error");
      this.button.disabled = false;
    }
    say(words, state) {
      text(this.said, words);
      attr(this.said, "data-state", state);
    }
  }

  // the whole mission again; what is done is forgotten
  async function fresh(id) {
    const tick = window.headland.tick();
    if (tick === null) return { outcome: "refused", text: "The link to the server is lost." };
    const answer = await HL.port.api("POST", `${of(id)}/fresh`, { tick }, SEND_MS);
    if (answer.data?.text?.includes("drawn")) HL.toast(answer.data.text, "warning");
    return { outcome: answer.data?.outcome ?? answer.outcome ?? "refused", text: answer.data?.text || answer.text || "No answer. Look at the robot." };
  }

  const forgets = (mission) => (mission?.row ? `Forgets row ${mission.row} of ${mission.rows}, ${area(mission.area_done_m2 ?? 0)} done` : "Begins at the first row");

  // Operate fetches what draws on the map only when somebody opens the sheet
  let fetched = null;
  function drawing() {
    if (HL.RestMap) return Promise.resolve(true);
    fetched ??= new Promise((resolve) => {
      const script = el("script", { src: document.querySelector("hl-screen")?.dataset.draw, onload: () => resolve(true), onerror: () => ((fetched = null), script.remove(), resolve(false)) });
      document.head.append(script);
    });
    return fetched;
  }

  async function open(mission, kind) {
    if (await drawing()) return new Sheet(mission, kind);
    return HL.toast("This part did not load. Try again.", "cloud_off");
  }

  HL.rest = { change: (mission) => open(mission, "change"), later: (mission) => open(mission, "later"), fresh, forgets };
})();
