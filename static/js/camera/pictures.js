// Pictures that were kept: a drawer with preview, place, time, and the file to take away.
(() => {
  "use strict";
  const { el, icon, attr } = HL;
  const MOST = 40;
  const MOST_NAMED = 6;
  const SURE_MS = 6000;
  const OLD_PLACE_S = 2;
  const KINDS = [["", "All"], ["snapshot", "Snapshots"], ["clip", "Clips"], ["mission", "Missions"]];

  const isClip = (one) => (one.media_type ?? "").startsWith("video/");

  // where it was taken; a position of another moment is not passed off as this one's
  function place(one) {
    if (typeof one.lat_deg !== "number" || typeof one.lon_deg !== "number") return "Position unknown";
    const apart = Math.abs(one.position_age_s ?? 0);
    return `${one.lat_deg.toFixed(6)}, ${one.lon_deg.toFixed(6)}${apart > OLD_PLACE_S ? ` (${HL.words.age(apart * 1000)} apart)` : ""}`;
  }

  const work = ({ mission }) => (mission ? `${mission.name || mission.id}${mission.row ? `, row ${mission.row}` : ""}` : "");

  function preview(one) {
    if (isClip(one)) {
      const node = el("video", { class: "c-thumb", src: one.file, controls: true, playsinline: true, preload: "none", "aria-label": "Clip" });
      node.muted = true;
      return node;
    }
    return el("a", { href: one.file, target: "_blank", rel: "noopener", "aria-label": "Open the picture" }, el("img", { class: "c-thumb", src: one.file, alt: "", loading: "lazy" }));
  }

  const may = (right) => HL.config.rights.includes(right);
  const button = (sign, word, hook, act) => el("button", { type: "button", class: "h-btn", "data-testid": hook, onclick: act }, icon(sign, "m"), word);

  // who took it: a robot and which of its cameras; a station of the field by its name
  const station = ({ camera }) => HL.camera.wall.cameras?.find((one) => one.robot === "field" && one.camera === camera)?.label || camera;
  const taker = (one) => (one.robot === "field" ? station(one) : `${one.robot_name || one.robot}, ${one.camera}`);

  // one kept picture: what is known of it, and what may be done with it
  class Row {
    constructor(one) {
      this.node = el("li", { class: "c-picture", "data-testid": `picture-${one.id}` });
      this.show(one);
    }
    show(one) {
      this.one = one;
      this.isSure = false;
      const line = (text) => (text ? el("span", { class: "h-t13 h-2" }, text) : "");
      const length = one.duration_s ? `${Math.round(one.duration_s)} s, ` : "";
      const keep = button(one.is_kept ? "check" : "add", one.is_kept ? "Marked" : "Mark", `picture-mark-${one.id}`, () => this.change({ is_kept: !one.is_kept }));
      attr(keep, "aria-pressed", String(Boolean(one.is_kept)));
      attr(keep, "title", "Marked pictures stay, whatever their age");
      const acts = may("keep_pictures") ? [keep, button("edit", "Note", `picture-note-${one.id}`, () => this.write())] : [];
      if (may("manage_cameras")) acts.push((this.gone = button("delete", "Delete", `picture-delete-${one.id}`, () => this.remove())));
      this.acts = el("div", { class: "c-acts" }, ...acts);
      this.node.replaceChildren(preview(one),
        el("div", { class: "h-col" }, el("b", { class: "h-t16" }, taker(one)), el("span", { class: "h-t14" }, length, HL.records.when(one.captured_utc), (one.age_s ?? one.duration_s) == null ? ", when it came" : ""), line([place(one), work(one)].filter(Boolean).join(" · ")), line(one.text), one.note ? el("span", { class: "h-t14 h-b" }, one.note) : "", line(one.by ? `Kept by ${one.by}` : ""), this.acts),
        el("a", { class: "h-btn ico", href: `${one.file}?download=true`, download: one.file_name ?? "", "aria-label": "Download", "data-testid": `picture-download-${one.id}` }, icon("download")));
    }
    // the note is written where it stands
    write() {
      this.isSure = false;
      const input = el("input", { class: "h-input", type: "text", maxlength: "500", value: this.one.note ?? "", placeholder: "What is to be seen", "aria-label": "Note", "data-testid": `picture-note-text-${this.one.id}`, onkeydown: (event) => event.key === "Enter" && this.change({ note: input.value.trim() }) });
      this.acts.replaceChildren(input, button("check", "Save", `picture-note-save-${this.one.id}`, () => this.change({ note: input.value.trim() })), button("close", "Cancel", `picture-note-cancel-${this.one.id}`, () => this.show(this.one)));
      input.focus();
    }
    async change(wish) {
      const answer = await HL.port.api("PATCH", `/pictures/${this.one.id}`, wish);
      if (!answer.ok) return HL.toast(`Not changed: ${answer.text}`, "block");
      return this.show({ ...this.one, ...wish });
    }
    // asked once more on the same button, for what is deleted is gone
    async remove() {
      if (!this.isSure) {
        this.isSure = true;
        this.gone.replaceChildren(icon("delete", "m"), "Delete for good?");
        setTimeout(() => this.isSure && this.show(this.one), SURE_MS);
        return undefined;
      }
      const answer = await HL.port.api("DELETE", `/pictures/${this.one.id}`);
      if (!answer.ok) return HL.toast(`Not deleted: ${answer.text}`, "block");
      return this.node.remove();
    }
  }

  const row = (one) => new Row(one).node;

  // those with a camera, by name
  function robots() {
    const ids = [...new Set((HL.camera.wall.cameras ?? []).map((one) => one.robot))];
    const named = ids.map((id) => [id, id === "field" ? "Field" : HL.port.fleet()[id]?.name ?? id]);
    return named.sort((a, b) => a[1].localeCompare(b[1])).map(([id, name]) => el("option", { value: id }, name));
  }

  // of which robots a STOP would leave what led to it: those whose camera is recorded now; of the others only what follows
  function keptNow(cameras) {
    const robots = (is) => [...new Set(cameras.filter((one) => one.robot !== "field" && Boolean(one.is_kept) === is).map((one) => one.robot))];
    const kept = robots(true);
    const others = robots(false).filter((id) => !kept.includes(id));
    const named = (ids) => ids.map((id) => HL.port.fleet()[id]?.name ?? id).sort((a, b) => a.localeCompare(b)).join(", ");
    if (!kept.length && !others.length) return "";
    const rest = others.length > MOST_NAMED ? `${others.length}${kept.length ? " other" : ""} robots` : named(others);
    const without = others.length ? ` Not of ${rest}: a camera keeps it while somebody watches it.` : "";
    return kept.length ? `The minute before a STOP is being kept of ${named(kept)}.${without}` : `The minute before a STOP is kept of no robot now.${without}`;
  }

  class Drawer {
    constructor() {
      this.kind = "";
      this.list = el("ul", { class: "c-pictures", "data-testid": "pictures-list" });
      this.more = el("button", { type: "button", class: "h-btn", hidden: true, "data-testid": "pictures-more", onclick: () => this.load(this.next) }, "Show more");
      this.room = el("p", { class: "h-error", role: "status" });
      this.kinds = KINDS.map(([key, word]) => el("button", { type: "button", "data-testid": `pictures-kind-${key || "all"}`, onclick: () => this.choose(key) }, word));
      this.robot = el("select", { class: "h-select c-group", "aria-label": "Robot", "data-testid": "pictures-robot", onchange: () => this.choose(this.kind) }, el("option", { value: "" }, "All robots"), ...robots());
      this.kept = el("p", { class: "h-t14 h-2", role: "status", "data-testid": "pictures-kept-now" });
      this.body = [el("div", { class: "h-row c-filter" }, el("div", { class: "h-seg", role: "group", "aria-label": "Kind" }, ...this.kinds), this.robot), this.room, this.kept, this.list, this.more];
      this.choose("");
      this.sayKept();
    }
    async sayKept() {
      const answer = await HL.port.api("GET", "/cameras");
      this.kept.textContent = answer.ok ? keptNow(answer.cameras ?? []) : "";
    }
    choose(kind) {
      this.kind = kind;
      this.kinds.forEach((button, i) => button.setAttribute("aria-pressed", String(KINDS[i][0] === kind)));
      this.say("hourglass_top", "Loading pictures", "");
      this.load("");
    }
    say(sign, head, text) {
      this.list.replaceChildren(el("li", { class: "h-row c-said" }, icon(sign), el("span", {}, el("b", {}, head), text ? el("br") : "", text)));
      this.more.hidden = true;
    }
    async load(before) {
      const { kind } = this;
      const robot = this.robot.value;
      const answer = await HL.port.api("GET", `/pictures?limit=${MOST}${kind ? `&kind=${kind}` : ""}${robot ? `&robot=${encodeURIComponent(robot)}` : ""}${before ? `&before=${encodeURIComponent(before)}` : ""}`);
      if (kind !== this.kind || robot !== this.robot.value) return undefined;
      if (answer.status === 403) return this.say("lock", "Pictures are not shared with you.", answer.text);
      if (!answer.ok) return this.say("cloud_off", "The list did not load.", answer.text);
      const pictures = answer.pictures ?? [];
      this.room.textContent = answer.room && !answer.room.is_ok ? answer.room.text : "";
      if (!pictures.length && !before) return this.say("photo_library", "No pictures kept yet.", "Snapshot keeps one with its place and time.");
      if (before) this.list.append(...pictures.map(row));
      else this.list.replaceChildren(...pictures.map(row));
      this.next = answer.next;
      this.more.hidden = !answer.next;
      return undefined;
    }
  }

  const open = () => HL.sheet({ title: "Pictures", hook: "pictures", body: new Drawer().body, buttons: [["Close", (close) => close(), true]] });

  Object.assign(HL.camera, { pictures: { open, keptNow } });
})();
