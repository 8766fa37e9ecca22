// Pictures that were kept: a drawer with preview, place, time, and the file to take away.
(() => {
  "use strict";
  const { el, icon } = HL;
  const MOST = 40;
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

  function row(one) {
    const said = [one.text, one.note].filter(Boolean).join(". ");
    const line = (text) => (text ? el("span", { class: "h-t13 h-2" }, text) : "");
    const length = one.duration_s ? `${Math.round(one.duration_s)} s, ` : "";
    return el("li", { class: "c-picture", "data-testid": `picture-${one.id}` }, preview(one),
      el("div", { class: "h-col" }, el("b", { class: "h-t16" }, `${one.robot_name || one.robot}, ${one.camera}`), el("span", { class: "h-t14" }, length, HL.records.when(one.captured_utc)), line([place(one), work(one)].filter(Boolean).join(" · ")), line(said), line(one.by ? `Kept by ${one.by}` : "")),
      el("a", { class: "h-btn ico", href: `${one.file}?download=true`, download: one.file_name ?? "", "aria-label": "Download", "data-testid": `picture-download-${one.id}` }, icon("download")));
  }

  class Drawer {
    constructor() {
      this.kind = "";
      this.list = el("ul", { class: "c-pictures", "data-testid": "pictures-list" });
      this.more = el("button", { type: "button", class: "h-btn", hidden: true, "data-testid": "pictures-more", onclick: () => this.load(this.next) }, "Show more");
      this.room = el("p", { class: "h-error", role: "status" });
      this.kinds = KINDS.map(([key, word]) => el("button", { type: "button", "data-testid": `pictures-kind-${key || "all"}`, onclick: () => this.choose(key) }, word));
      this.body = [el("div", { class: "h-seg", role: "group", "aria-label": "Kind" }, ...this.kinds), this.room, this.list, this.more];
      this.choose("");
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
      const answer = await HL.port.api("GET", `/pictures?limit=${MOST}${kind ? `&kind=${kind}` : ""}${before ? `&before=${encodeURIComponent(before)}` : ""}`);
      if (kind !== this.kind) return undefined;
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

  Object.assign(HL.camera, { pictures: { open } });
})();
