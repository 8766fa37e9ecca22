// The robot's own model: what is shown now, and for admins the upload of a URDF with its meshes.
(() => {
  "use strict";
  const { el, icon, text, attr } = HL;
  const KINDS = { upload: "Own model", loading: "Reading its own model", family: "Model of its family", plain: "Plain shape of its size" };

  class TwinModel {
    constructor(robot, mayChange) {
      this.robot = robot;
      this.kind = el("span", { class: "h-t13 h-2" });
      this.button = el("button", { type: "button", class: "h-btn", "data-testid": "twin-model", onclick: () => this.open() }, icon("upload_file", "m"), "Model");
      this.node = el("div", { class: "h-row t-model" }, this.kind, el("span", { class: "h-sp" }), mayChange ? this.button : "");
    }

    paint(status) {
      this.shown = status?.model;
      text(this.kind, KINDS[status?.model] ?? "");
    }

    async open() {
      const path = `/robots/${encodeURIComponent(this.robot)}/model`;
      const said = el("div", { class: "h-t14 h-2", role: "status", "data-testid": "twin-model-said" }, "Looking");
      const file = el("input", { type: "file", accept: ".zip", class: "h-vh", "data-testid": "twin-model-file" });
      const choose = el("button", { type: "button", class: "h-btn pri", onclick: () => file.click() }, icon("upload_file", "m"), "Choose a zip");
      const remove = el("button", { type: "button", class: "h-btn", hidden: "", "data-testid": "twin-model-remove" }, icon("delete", "m"), "Remove own model");
      const tell = (answer) => this.tell(answer, said, remove);
      file.onchange = async () => {
        if (!file.files[0]) return;
        text(said, "Reading the model. This takes up to a minute.");
        attr(choose, "disabled", true);
        tell(await send(path, file.files[0]));
        attr(choose, "disabled", null);
        file.value = "";
      };
      remove.onclick = async () => tell(await HL.port.api("DELETE", path));
      const names = (HL.port.inside(this.robot).joints?.joints ?? []).map((one) => one.name);
      const close = HL.sheet({
        title: `Model of ${HL.view.name()}`, hook: "twin-model-sheet",
        body: [
          el("p", { class: "h-t14" }, "One zip with one .urdf and its meshes: STL, OBJ, DAE or GLB without compression, at most 40 MB."),
          el("p", { class: "h-t14" }, names.length ? `Joints that move by name: ${names.join(", ")}.` : "This robot tells of no joints; the model stands as one piece."),
          said, file,
          el("div", { class: "foot" }, el("button", { type: "button", class: "h-btn", onclick: () => close() }, "Close"), remove, choose),
        ],
      });
      tell(await HL.port.api("GET", path));
    }

    tell(answer, said, remove) {
      if (!answer.ok) return said.replaceChildren(el("b", {}, "Not used. "), answer.text);
      const known = answer.data ?? {};
      attr(remove, "hidden", !known.kept);
      if (!known.kept) return text(said, `It has no model of its own. Shown now: ${(KINDS[this.shown] ?? "nothing yet").toLowerCase()}.`);
      const joints = known.joints.length ? `Joints: ${known.joints.join(", ")}.` : "It has no moving joint.";
      return said.replaceChildren(el("b", {}, `${known.name}: ${known.links} links, ${known.faces} triangles. `), joints, ...known.notices.map((notice) => el("p", { class: "t-notice" }, icon("warning", "m"), notice)));
    }
  }

  // a file goes as it is; REST of the lane speaks JSON only
  async function send(path, body) {
    try {
      const response = await fetch(HL.config.apiPath + path, { method: "POST", credentials: "same-origin", headers: { "X-Headland-CSRF": HL.config.csrf, "Content-Type": "application/zip" }, body });
      const data = await response.json().catch(() => null);
      return { ok: response.ok && data !== null, data, text: data?.text ?? `The server answered ${response.status}.` };
    } catch {
      return { ok: false, data: null, text: "The server cannot be reached." };
    }
  }

  HL.TwinModel = TwinModel;
})();
