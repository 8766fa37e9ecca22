// The wall of pictures: as many as fit, attention first, each paused while nobody can see it.
(() => {
  "use strict";
  const { el, icon, text, attr, style, LiveElement } = HL;
  const SIZES = [2, 3, 4];
  const MODES = [["attention", "Attention first"], ["group", "Group"], ["mine", "My wall"]];
  const REST_MS = 3000; // pictures hold still so long after a touch
  const LATE_MS = 5000;
  const DIRECT_SIZE = 2; // a direct picture costs an encoder there and a decoder here: small ones come as single pictures
  const SMALL_FPS = { 2: 15, 3: 5, 4: 3 };

  class Cameras extends LiveElement {
    build() {
      this.tiles = new Map();
      this.sizes = SIZES.map((n) => el("button", { type: "button", "data-testid": `cameras-size-${n}`, onclick: () => HL.camera.wall.choose({ size: n }) }, `${n} × ${n}`));
      this.modes = MODES.map(([key, label]) => el("button", { type: "button", "data-testid": `cameras-mode-${key}`, onclick: () => this.mode(key) }, label));
      this.group = el("select", { class: "h-select c-group", "aria-label": "Group", "data-testid": "cameras-group", onchange: () => HL.camera.wall.choose({ group: this.group.value }) });
      this.mine = el("button", { type: "button", class: "h-btn", "data-testid": "cameras-mine", onclick: () => HL.camera.wall.chooseMine() }, icon("tune", "m"), "Choose");
      this.sum = el("span", { class: "h-t14 h-2 c-sum", "data-testid": "cameras-sum", role: "status" });
      this.full = icon("fullscreen");
      this.bar = el("div", { class: "c-bar" },
        el("div", { class: "h-seg", role: "group", "aria-label": "Pictures" }, ...this.sizes), el("div", { class: "h-seg", role: "group", "aria-label": "Which" }, ...this.modes), this.group, this.mine, this.sum,
        el("button", { type: "button", class: "h-btn", "aria-label": "Pictures", title: "Pictures", "data-testid": "cameras-pictures", onclick: () => HL.camera.pictures.open() }, icon("photo_library"), el("span", { class: "c-word" }, "Pictures")),
        HL.camera.snapshot.button(() => this.current()?.one && { ...this.current().one, label: this.named(this.current()) }),
        el("button", { type: "button", class: "h-btn ico", "aria-label": "Full screen", "data-testid": "cameras-full", onclick: () => this.fullScreen() }, this.full));
      this.strip = el("div", { class: "c-strip", role: "alert", "data-testid": "cameras-strip", hidden: true });
      this.grid = el("div", { class: "c-grid", onpointerdown: () => (this.touchedAt = performance.now()) });
      this.blank = el("div", { class: "h-notice h-card", "data-testid": "cameras-notice", hidden: true }, (this.blankSign = icon("videocam_off", "l")), (this.blankHead = el("b", { class: "h-t22" })), (this.blankLine = el("span", { class: "h-t16 h-2" })), (this.blankAct = el("button", { type: "button", class: "h-btn" })));
      this.append(this.bar, this.strip, this.grid, this.blank);
    }

    enter() {
      HL.fleet.begin();
      HL.camera.wall.begin();
      HL.camera.shown = this;
    }
    leave() {
      HL.camera.shown = null;
      HL.camera.wall.end();
      HL.fleet.end();
      this.follow(null);
      for (const tile of this.tiles.values()) tile.close();
      this.tiles.clear();
      this.grid.replaceChildren();
      this.order = [];
    }

    mode(key) {
      HL.camera.wall.choose({ mode: key });
      if (key === "mine" && !HL.camera.wall.choice.mine.length) HL.camera.wall.chooseMine();
    }
    // the whole document, so that STOP stays on the screen
    fullScreen() {
      if (document.fullscreenElement) document.exitFullscreen();
      else document.documentElement.requestFullscreen?.().catch(() => HL.toast("This browser does not allow full screen.", "fullscreen"));
    }

    current() {
      return this.tiles.get(HL.camera.wall.current) ?? null;
    }
    named(tile) {
      return `${tile.name.textContent} ${tile.label.textContent}`;
    }
    // who works in the dock means the picture that is chosen now: it is not exchanged any more
    hold() {
      this.isChosen ||= Boolean(this.current());
    }
    choose(tile) {
      HL.camera.wall.current = tile ? HL.camera.order.id(tile.one) : null;
      this.isChosen = true;
      this.follow(tile && tile.one.robot !== "field" ? tile.one.robot : null);
      HL.repaint();
    }
    step(by) {
      const at = this.order?.indexOf(HL.camera.wall.current) ?? -1;
      const key = this.order?.[Math.max(0, Math.min(this.order.length - 1, at < 0 ? 0 : at + by))];
      if (!key) return;
      this.choose(this.tiles.get(key));
      this.tiles.get(key).node.scrollIntoView({ block: "nearest" });
    }
    // one picture alone, and back
    enlarge(tile) {
      this.alone = this.alone || !tile ? null : HL.camera.order.id(tile.one);
      if (tile) this.choose(tile);
      HL.repaint();
    }

    // a picture that somebody looks at or points to does not move away
    isHeld() {
      return performance.now() - (this.touchedAt ?? -Infinity) < REST_MS || (matchMedia("(hover: hover)").matches && this.grid.matches(":hover"));
    }

    arrange() {
      const wanted = HL.camera.wall.arranged();
      const keys = wanted.map(HL.camera.order.id);
      if (this.alone && !keys.includes(this.alone)) this.alone = null;
      const isSame = keys.length === this.order?.length && keys.every((key) => this.tiles.has(key));
      if (isSame && this.isHeld() && this.arrangedFor === this.alone) return;
      this.arrangedFor = this.alone;
      const { size } = HL.camera.wall.choice;
      for (const [key, tile] of [...this.tiles]) if (!keys.includes(key)) this.remove(key, tile);
      wanted.forEach((one, i) => {
        const key = keys[i];
        if (!this.tiles.has(key)) this.add(key, one);
        const { node, viewer } = this.tiles.get(key);
        style(node, "order", String(i)); // moving the node itself would stop its video
        const isDirect = size === DIRECT_SIZE || key === this.alone;
        viewer.want({ hasDirect: isDirect, fps: isDirect ? 15 : SMALL_FPS[size] });
      });
      this.order = keys;
      if (!this.isChosen || (HL.camera.wall.current && !keys.includes(HL.camera.wall.current))) this.first(keys);
    }

    // what waits for a person is chosen by itself, until somebody chooses; never another robot where Skip is offered or
    // just was, for a finger may be on its way
    first(keys) {
      const items = HL.camera.wall.items();
      const { current } = HL.camera.wall;
      const isOffered = performance.now() - (this.offeredAt ?? -Infinity) < REST_MS;
      const waiting = () => keys.find((one) => items.get(this.tiles.get(one).one.robot)?.verdict.waits);
      const key = (isOffered ? keys.find((one) => one === current) : waiting()) ?? null;
      if (key === current) return;
      HL.camera.wall.current = key;
      this.follow(key ? this.tiles.get(key).one.robot : null);
    }
    // of the robot that is chosen also what it detects is heard, and drawn in its pictures
    follow(robot) {
      HL.looksInside = robot;
      HL.port.follow(robot, "wall");
    }

    add(key, one) {
      const tile = new HL.camera.Tile(one, { hasDirect: false, fps: SMALL_FPS[3], chosen: (chosen) => this.choose(chosen), opened: (opened) => this.enlarge(opened) });
      this.tiles.set(key, tile);
      this.grid.append(tile.node);
      queueMicrotask(() => tile.open()); // after it was told how
    }
    remove(key, tile) {
      tile.close();
      tile.node.remove();
      this.tiles.delete(key);
      if (this.alone === key) this.alone = null;
    }

    paint() {
      const { cameras, problem, choice } = HL.camera.wall;
      this.sizes.forEach((button, i) => attr(button, "aria-pressed", String(SIZES[i] === choice.size)));
      this.modes.forEach((button, i) => attr(button, "aria-pressed", String(MODES[i][0] === choice.mode)));
      text(this.full, document.fullscreenElement ? "fullscreen_exit" : "fullscreen");
      this.paintGroup(choice);
      attr(this.mine, "hidden", choice.mode !== "mine");
      if (cameras) this.arrange();
      attr(this.grid, "data-size", this.alone ? 1 : choice.size);
      const items = HL.camera.wall.items();
      for (const [key, tile] of this.tiles) {
        attr(tile.node, "hidden", Boolean(this.alone) && key !== this.alone);
        tile.choose(key === HL.camera.wall.current);
        tile.paint(items.get(tile.one.robot));
      }
      this.paintSum(cameras);
      this.paintBlank(cameras, problem);
    }

    paintGroup(choice) {
      attr(this.group, "hidden", choice.mode !== "group");
      if (choice.mode !== "group") return;
      const homes = HL.camera.order.homes(HL.camera.wall.cameras ?? [], HL.fleet.items, HL.fleet.groups);
      const key = homes.join("|");
      if (key !== this.homes) {
        this.homes = key;
        this.group.replaceChildren(...homes.map((home) => el("option", { value: home }, home)));
      }
      if (homes.length && !homes.includes(choice.group)) HL.camera.wall.choose({ group: homes[0] });
      if (this.group.value !== choice.group) this.group.value = choice.group;
    }

    paintSum(cameras) {
      const running = [...this.tiles.values()].filter((tile) => tile.viewer.isRunning());
      const mbit = running.reduce((sum, tile) => sum + (tile.viewer.info?.kbit_s ?? 0), 0) / 1000;
      const isPaused = this.tiles.size > running.length;
      text(this.sum, running.length ? `${running.length} ${running.length === 1 ? "stream" : "streams"}, ${mbit.toFixed(1)} Mbit/s.${isPaused ? " Off-screen streams pause." : ""}` : "");
      attr(this.sum, "data-streams", running.length);
      const more = (cameras?.length ?? 0) - this.tiles.size;
      attr(this.sum, "title", more > 0 ? `${more} more cameras are not on this wall` : null);
    }

    paintBlank(cameras, problem) {
      const said = this.said(cameras, problem);
      attr(this.strip, "hidden", !problem || !cameras?.length);
      text(this.strip, problem ? (HL.camera.wall.isStarting() ? "Cameras are starting. They come back by themselves." : `The list of cameras is old: ${problem.text}`) : "");
      attr(this.blank, "hidden", !said);
      attr(this.grid, "hidden", Boolean(said));
      if (!said) return;
      text(this.blankSign, said.sign);
      text(this.blankHead, said.head);
      text(this.blankLine, said.line);
      attr(this.blankAct, "hidden", !said.act);
      if (said.act) {
        text(this.blankAct, said.act[0]);
        this.blankAct.onclick = said.act[1];
      }
    }

    said(cameras, problem) {
      const { mode } = HL.camera.wall.choice;
      if (problem?.status === 403) return { sign: "lock", head: "Video of this site is not shared with you.", line: problem.text };
      if (!cameras && HL.camera.wall.isStarting()) return { sign: "hourglass_top", head: "Cameras are starting", line: "They appear here by themselves." };
      if (!cameras && problem) return { sign: "videocam_off", head: "Cameras do not answer", line: `${problem.text} The console keeps trying.`, act: ["Try again", () => HL.camera.wall.load()] };
      if (!cameras) return { sign: "hourglass_top", head: performance.now() - (HL.camera.wall.asked || performance.now()) > LATE_MS ? "The server does not answer" : "Loading cameras", line: "" };
      if (!cameras.length) return { sign: "videocam_off", head: "No camera yet", line: "Cameras of robots appear here by themselves. An admin adds others." };
      if (!this.tiles.size && mode === "mine") return { sign: "videocam", head: "Nothing on your wall", line: "Choose the pictures that you want to see.", act: ["Choose", () => HL.camera.wall.chooseMine()] };
      if (!this.tiles.size) return { sign: "videocam_off", head: "No camera in this group", line: "" };
      return null;
    }
  }

  HL.camera.Cameras = Cameras;
})();
