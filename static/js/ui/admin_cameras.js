// Where each camera's pictures come from: set, test, take back. A password goes in and never comes back; an upload's token is shown once.
(() => {
  "use strict";
  const { el, text, attr } = HL;
  const { table, empty, load, list } = HL.records;
  const KINDS = { rtsp: "RTSP stream", mjpeg: "MJPEG stream", snapshot: "Still picture, by address", whep: "WHEP stream", upload: "The camera sends them, by HTTP" };
  const EXAMPLES = { rtsp: "rtsp://192.168.7.20/stream1", mjpeg: "http://192.168.7.20/video.mjpg", snapshot: "http://192.168.7.20/still.jpg", whep: "http://192.168.7.20:8889/barn/whep" };
  const FIELD = "field";
  const WIDE = new Set(["kind", "url"]); // an address is read whole
  const ID = "[a-z0-9][a-z0-9_\\-]{0,63}";
  const TEST_MS = 12000; // the camera process is asked twice, for 4 s each
  const of = (one) => `/cameras/${encodeURIComponent(one.robot)}/${encodeURIComponent(one.camera)}`;
  const button = (label, run, hook) => el("button", { type: "button", class: "h-btn", "data-testid": hook, onclick: run }, label);

  const comesFrom = (one) => {
    if (!KINDS[one.kind]) return "its robot";
    if (one.kind === "upload") return `sent by HTTP, about every ${one.period_s} s`;
    return `${KINDS[one.kind].split(",")[0]}, ${one.url}`;
  };
  const where = ({ networks, hosts, this_machine }) => {
    const places = [...hosts, ...networks, ...(this_machine ? ["this machine"] : [])];
    return places.length ? `Cameras may be at: ${places.join(", ")}. The setting camera_networks allows more.` : "No network of cameras is set yet: the setting camera_networks allows one.";
  };

  class SourceSheet {
    constructor(source, names, done) {
      Object.assign(this, { source, done, wrong: {} });
      this.kind = this.pick("kind", "Pictures come from", source.robot === FIELD ? Object.keys(KINDS) : Object.keys(KINDS).filter((one) => one !== "upload"), KINDS);
      this.kind.node.value = KINDS[source.kind] ? source.kind : source.robot === FIELD ? "upload" : "rtsp";
      this.kind.node.addEventListener("change", () => ((this.period.node.value = this.kind.node.value === source.kind ? source.period_s : this.kind.node.value === "snapshot" ? 0.5 : 5), this.fit()));
      this.url = this.input("url", "Address", { inputmode: "url", maxlength: "300", spellcheck: "false" }, source.url);
      this.user = this.input("user", "User", { maxlength: "80" }, source.user);
      this.password = this.input("password", "Password", { type: "password", autocomplete: "new-password", maxlength: "200", placeholder: source.is_password_lost ? "lost: enter it again" : source.has_password ? "set; leave empty to keep it" : "none" });
      this.label = this.input("label", "Name", { maxlength: "80" }, source.label);
      this.period = this.input("period_s", "Seconds between pictures", { type: "number", min: "0.5", max: "86400", step: "any" }, source.period_s ?? 5);
      this.keep = this.input("keep_every_s", "Keep one each … seconds, 0 keeps none", { type: "number", min: "0", max: "86400", step: "any" }, source.keep_every_s ?? 900);
      this.fresh = el("input", { type: "checkbox", "data-testid": "source-new-token" });
      this.freshRow = el("label", { class: "h-check" }, this.fresh, "Make a new token; the old one ends");
      this.may = el("p", { class: "h-t13 h-2" }, source.allowed ? where(source.allowed) : "");
      this.told = el("div", { class: "h-t16", role: "status", "data-testid": "source-told" });
      this.problem = el("div", { class: "h-error", role: "alert", hidden: true, "data-testid": "source-error" });
      this.rows = [this.kind, this.url, this.user, this.password, this.label, this.period, this.keep];
      const form = el("form", { class: "h-col", novalidate: true, onsubmit: (event) => (event.preventDefault(), this.save()) }, el("div", { class: "h-restgrid" }, ...this.rows.map((row) => row.label)), this.freshRow, this.may, this.told, this.problem);
      this.close = HL.sheet({ title: `Pictures of ${names(source)}`, hook: "source", body: [form], buttons: [["Close", (close) => close()], ["Save and test", () => this.save(), true]] });
      this.button = document.querySelector("[data-testid=source] .foot .pri");
      attr(this.button, "data-testid", "source-save");
      this.fit();
    }

    row(key, label, node) {
      attr(node, "data-testid", `source-${key.replaceAll("_", "-")}`);
      this.wrong[key] = el("span", { class: "h-error", hidden: true });
      const row = { key, node, label: el("label", { class: "h-field" }, label, node, this.wrong[key]) };
      if (WIDE.has(key)) row.label.style.gridColumn = "1 / -1";
      return row;
    }

    input(key, label, options, value = "") {
      const node = el("input", { class: "h-input", autocomplete: "off", ...options });
      node.value = String(value ?? "");
      return this.row(key, label, node);
    }

    pick(key, label, values, words) {
      return this.row(key, label, el("select", { class: "h-select" }, ...values.map((one) => el("option", { value: one }, words[one]))));
    }

    // only what this kind needs is shown
    fit() {
      const isUpload = this.kind.node.value === "upload";
      for (const row of [this.url, this.user, this.password]) row.label.hidden = isUpload;
      this.keep.label.hidden = !isUpload;
      this.period.label.hidden = !isUpload && this.kind.node.value !== "snapshot";
      this.label.label.hidden = this.source.robot !== FIELD;
      this.freshRow.hidden = !isUpload || !this.source.has_token;
      this.may.hidden = isUpload;
      text(this.button, isUpload ? "Save" : "Save and test");
      attr(this.url.node, "placeholder", EXAMPLES[this.kind.node.value] ?? null);
    }

    body() {
      const kind = this.kind.node.value;
      const label = this.source.robot === FIELD && this.label.node.value.trim() ? { label: this.label.node.value.trim() } : {};
      if (kind === "upload") return { kind, ...label, period_s: Number(this.period.node.value), keep_every_s: Number(this.keep.node.value), new_token: this.fresh.checked };
      const password = this.password.node.value ? { password: this.password.node.value } : {};
      const period = kind === "snapshot" ? { period_s: Number(this.period.node.value) } : {};
      return { kind, ...label, ...period, url: this.url.node.value.trim(), user: this.user.node.value.trim(), ...password };
    }

    async save() {
      this.tell("", "");
      text(this.told, "");
      this.button.disabled = true;
      const answer = await HL.port.api("PUT", `${of(this.source)}/source`, this.body());
      this.button.disabled = false;
      if (!answer.ok) return this.tell(`Not saved: ${answer.text || "no answer. Look before you save again."}`, answer.field);
      this.password.node.value = "";
      this.source = answer.data;
      attr(this.password.node, "placeholder", this.source.has_password ? "set; leave empty to keep it" : "none");
      this.fresh.checked = false;
      this.fit();
      this.done();
      if (this.source.kind === "upload") return this.showToken(answer.data);
      return this.test();
    }

    showToken({ token, upload }) {
      if (!token) return text(this.told, "Saved. The camera goes on with its token.");
      const line = el("code", { class: "h-mono", "data-testid": "source-token" }, token);
      this.told.replaceChildren(el("p", {}, "Saved. This token is shown once: put it into the camera now."), line, el("p", { class: "h-t13 h-2" }, `The camera sends each JPEG or PNG with POST to ${location.origin}${upload}, with the header "Authorization: Bearer <token>".`));
      return undefined;
    }

    async test() {
      text(this.told, "Saved. Asking for a picture …");
      const answer = await HL.port.api("POST", `${of(this.source)}/source/test`, null, TEST_MS);
      const words = answer.ok ? answer.data.text : answer.text || "No answer.";
      text(this.told, answer.ok && answer.data.ok ? `Saved. ${words}` : `Saved, but: ${words}`);
    }

    tell(words, field) {
      for (const { key, node } of this.rows) {
        const isIt = Boolean(words) && key === field;
        text(this.wrong[key], isIt ? words : "");
        this.wrong[key].hidden = !isIt;
        attr(node, "aria-invalid", isIt ? "true" : null);
        if (isIt) node.focus();
      }
      text(this.problem, this.wrong[field] ? "" : words);
      this.problem.hidden = !words || Boolean(this.wrong[field]);
    }
  }

  class Cameras {
    constructor(place) {
      this.known = el("div");
      this.robots = new Map([[FIELD, "Field"]]);
      this.robot = el("select", { class: "h-select", "data-testid": "camera-add-robot" }, el("option", { value: FIELD }, "Field, no robot")); // there before the robots are known
      this.camera = el("input", { class: "h-input", autocomplete: "off", maxlength: "64", pattern: ID, required: true, placeholder: "station-2", "data-testid": "camera-add-name" });
      this.problem = el("div", { class: "h-error", role: "alert", hidden: true });
      const add = el("form", { class: "h-card h-sec", novalidate: true, onsubmit: (event) => (event.preventDefault(), this.add()) },
        el("div", { class: "h-form" }, el("label", { class: "h-field" }, "Robot", this.robot), el("label", { class: "h-field" }, "Camera's id", this.camera), el("button", { class: "h-btn pri", type: "submit", "data-testid": "camera-add" }, "Set where it is")), this.problem);
      place.append(el("h2", {}, "Cameras"), this.known, el("h2", {}, "Another camera, or another place"), el("p", { class: "h-2" }, "A robot's cameras are known from its factsheet and need nothing here. A field camera belongs to no robot."), add);
      this.again();
    }

    names(one) {
      return `${this.robots.get(one.robot) ?? one.robot}, ${one.label || one.camera}`;
    }

    // a console whose camera process is away still shows what is set
    async again() {
      const [robots, live] = await Promise.all([HL.port.api("GET", "/robots"), HL.port.api("GET", "/cameras")]);
      for (const robot of list(robots, "robots")) if (robot.is_registered !== false) this.robots.set(robot.id, robot.name);
      for (const [id, name] of [...this.robots].slice(this.robot.children.length)) this.robot.append(el("option", { value: id }, name));
      load(this.known, "Cameras", "/cameras/sources", (answer) => this.draw(list(answer, "sources"), live.ok ? list(live, "cameras") : []));
    }

    draw(sources, live) {
      const key = (one) => `${one.robot}/${one.camera}`;
      const all = new Map(live.map((one) => [key(one), { robot: one.robot, camera: one.camera, label: one.label, kind: "robot", state: one.state, reason: one.reason }]));
      for (const one of sources) all.set(key(one), { ...all.get(key(one)), ...one, label: one.label || all.get(key(one))?.label });
      if (!all.size) return empty("No camera is known", "Cameras of robots appear when a robot is heard; others are set below.");
      return table(["Camera", "Pictures come from", "State", ""], [...all.values()].map((one) => ({ hook: `camera-row-${one.robot}-${one.camera}`, cells: [this.names(one), comesFrom(one), [one.state, one.reason].filter(Boolean).join(": ") || "–", this.acts(one)] })));
    }

    acts(one) {
      const buttons = [button("Change", () => this.change(one), `camera-change-${one.robot}-${one.camera}`)];
      if (KINDS[one.kind]) buttons.push(button(one.robot === FIELD ? "Remove" : "Back to the robot", () => this.remove(one), `camera-remove-${one.robot}-${one.camera}`));
      return el("div", { class: "acts" }, ...buttons);
    }

    async change(one) {
      const answer = await HL.port.api("GET", `${of(one)}/source`);
      const isNew = !answer.ok && answer.code === "unknown_camera";
      if (!answer.ok && !isNew) return HL.toast(answer.text || "No answer. Try again.", "block");
      return new SourceSheet({ ...one, ...(isNew ? {} : answer.data) }, (it) => this.names(it), () => this.again());
    }

    remove(one) {
      const words = one.robot === FIELD ? "Its pictures that were kept stay. Its token ends at once." : "Its pictures come from the robot again, if the robot has such a camera.";
      HL.sheet({ title: `${this.names(one)}: forget this source?`, body: [el("p", { class: "h-2 h-t16" }, words)], buttons: [["Keep it", (close) => close()], ["Forget it", async (close) => {
        close();
        const answer = await HL.port.api("DELETE", `${of(one)}/source`);
        HL.toast(answer.ok ? "Saved" : `Not saved: ${answer.text || "no answer"}`, answer.ok ? "check" : "block");
        this.again();
      }, true]] });
    }

    add() {
      const camera = this.camera.value.trim();
      const isGood = new RegExp(`^${ID}$`).test(camera);
      this.problem.hidden = isGood;
      text(this.problem, isGood ? "" : "Lower-case letters, digits, - and _; as in station-2.");
      attr(this.camera, "aria-invalid", isGood ? null : "true");
      if (!isGood) return this.camera.focus();
      return this.change({ robot: this.robot.value, camera });
    }
  }

  HL.AdminCameras = Cameras;
})();
