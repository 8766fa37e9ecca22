// A picture with its name, its delay, what its robot does, and what to do when there is none.
(() => {
  "use strict";
  const { el, icon, text, attr, toggle } = HL;
  const NS = "http://www.w3.org/2000/svg";
  const SHAPES = { 1: "M3 3h18v18H3z", 2: "M12 1.5 23.5 22H.5z", 3: "M12 .5 23.5 12 12 23.5.5 12z", 4: "M12 2a10 10 0 1 0 0 20 10 10 0 0 0 0-20z" };

  // on a bar of its own colour the sign is drawn the other way round
  function inverted(level) {
    const sign = document.createElementNS(NS, "svg");
    for (const [key, value] of Object.entries({ width: 26, height: 26, viewBox: "-1 -1 26 26", role: "img", "aria-label": `priority ${level}` })) sign.setAttribute(key, value);
    const shape = document.createElementNS(NS, "path");
    shape.setAttribute("d", SHAPES[level]);
    shape.setAttribute("fill", `var(--hl-on-p${level})`);
    const number = document.createElementNS(NS, "text");
    for (const [key, value] of Object.entries({ x: 12, y: level === 2 ? 20 : 16.8, "font-size": 13, "font-weight": 800, "text-anchor": "middle", fill: `var(--hl-p${level})` })) number.setAttribute(key, value);
    number.textContent = level;
    sign.append(shape, number);
    return sign;
  }

  async function restart(robot, camera, viewer) {
    const answer = await HL.port.api("POST", `/cameras/${encodeURIComponent(robot)}/${encodeURIComponent(camera)}/restart`, {});
    HL.toast(answer.ok ? "The camera is being started again." : `Not restarted: ${answer.text}`, answer.ok ? "refresh" : "block");
    if (answer.ok) viewer.again();
  }
  const mayRestart = (info) => HL.config.rights.includes("restart_camera") && info?.state !== "off" && info?.source !== "upload"; // one that sends by itself cannot be opened anew

  // what lies over a picture that is none: since when, why, and the way to start it again
  class NoPicture {
    constructor(viewer) {
      this.viewer = viewer;
      this.head = el("b", { class: "h-t18" });
      this.line = el("span", { class: "h-t14 c-why" });
      this.button = el("button", { type: "button", class: "h-btn", "data-testid": `camera-restart-${viewer.robot}-${viewer.camera}`, onclick: (event) => (event.stopPropagation(), restart(viewer.robot, viewer.camera, viewer)) }, "Restart camera");
      this.sign = icon("videocam_off", "big");
      this.node = el("div", { class: "c-none", hidden: true }, el("div", {}, this.sign, this.head, this.line, this.button));
    }
    paint() {
      const { judged, info, problem } = this.viewer;
      const isLoading = judged?.state === "connecting";
      attr(this.node, "hidden", !(judged?.state === "off" || isLoading));
      if (this.node.hidden) return;
      text(this.sign, isLoading ? "hourglass_top" : "videocam_off");
      text(this.head, isLoading ? "Starting" : `No picture for ${HL.words.since(HL.camera.says.goneMs(judged))}`);
      text(this.line, isLoading ? "" : HL.camera.says.reason(info, problem));
      attr(this.button, "hidden", isLoading || !mayRestart(info));
    }
  }

  class Tile {
    constructor(one, { hasDirect, fps, chosen, opened }) {
      this.one = one;
      const hook = `camera-${one.robot}-${one.camera}`;
      this.viewer = new HL.camera.Viewer({ robot: one.robot, camera: one.camera, label: one.label, hasDirect, fps });
      this.none = new NoPicture(this.viewer);
      this.found = new HL.camera.Detections(this.viewer, { isCover: () => this.node.parentElement?.dataset.size !== "1" });
      this.sign = el("span", { class: "sign" });
      this.name = el("b", { class: "h-ell" });
      this.label = el("span", { class: "h-ell c-label" });
      this.corner = el("span", { class: "end" });
      this.head = el("div", { class: "c-head" }, this.sign, this.name, this.label, this.corner);
      this.said = el("span", { class: "h-ell" });
      this.last = el("span", { class: "end" });
      this.foot = el("div", { class: "c-foot" }, this.said, this.last);
      this.node = el("div", { class: "c-tile", role: "button", tabindex: "0", "data-testid": hook, "data-state": "connecting", onclick: () => chosen(this), onfocus: () => chosen(this), ondblclick: () => opened(this) }, this.viewer.node, this.found.node, this.none.node, this.head, this.foot);
    }

    open() {
      this.viewer.open();
    }
    close() {
      this.viewer.close();
    }

    // robot: its entry of the fleet and the verdict on it; both may be missing for a camera of the field
    paint(item) {
      const { viewer, one } = this;
      const { judged, how } = viewer;
      const verdict = item?.verdict;
      this.level(verdict?.level ?? null);
      text(this.name, one.robot === "field" ? "Field" : item?.robot.name ?? one.robot);
      text(this.label, one.label || one.camera);
      text(this.said, verdict?.isLost && Number.isFinite(item.ageMs) ? `No link for ${HL.words.since(item.ageMs)}` : verdict?.head ?? "");
      if (!judged) return;
      this.none.paint();
      this.found.paint(HL.port.inside(one.robot).detections ?? null, HL.looksInside === one.robot);
      attr(this.node, "data-boxes", this.found.count);
      text(this.corner, HL.camera.says.corner(judged, how));
      const isOld = ["frozen", "off", "late"].includes(judged.state) && judged.hasPicture;
      text(this.last, !isOld ? HL.camera.says.note(judged, how) : judged.ageMs !== null ? `Last picture ${HL.words.wallSeconds(new Date(Date.now() - judged.ageMs))}` : "");
      attr(this.node, "data-state", HL.camera.says.hook(judged, how));
      attr(this.node, "data-way", how.way);
      attr(this.node, "data-delay-ms", judged.delayMs === null ? null : Math.round(judged.delayMs));
      attr(this.node, "data-age-ms", judged.ageMs === null ? null : Math.round(judged.ageMs));
      attr(this.node, "data-fps", judged.fps === null ? null : judged.fps.toFixed(1));
      attr(this.node, "aria-label", `${this.name.textContent}. ${HL.camera.says.sentence(this.label.textContent, judged, how)}. ${this.said.textContent}`);
    }

    level(level) {
      if (level === this.shownLevel) return;
      this.shownLevel = level;
      attr(this.node, "data-level", level);
      this.sign.replaceChildren(...(level ? [level < 4 ? inverted(level) : HL.alarm(4, 22)] : []));
    }

    choose(isChosen) {
      toggle(this.node, "chosen", isChosen);
      attr(this.node, "aria-pressed", String(isChosen));
    }
  }

  Object.assign(HL.camera, { Tile, NoPicture, mayRestart });
})();
