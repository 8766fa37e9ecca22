// Keeping what a camera shows: the server keeps the picture with position and time, the screen says where it is.
(() => {
  "use strict";
  const { el, icon } = HL;
  const DRAWN_MS = 15000;

  const may = () => HL.config.rights.includes("keep_pictures");
  const why = () => (may() ? "" : "Keeping pictures needs the operator role.");
  const when = (utc) => (utc ? HL.records?.when?.(utc) ?? new Date(utc).toLocaleString("en-GB") : "time unknown");

  async function keep(robot, camera, label) {
    if (!may()) return HL.toast(why(), "lock");
    const answer = await HL.port.api("POST", `/cameras/${encodeURIComponent(robot)}/${encodeURIComponent(camera)}/snapshot`, { note: "" }, DRAWN_MS);
    HL.toast(answer.ok ? `Kept: ${label}, ${HL.words.wallSeconds(new Date())}. It is under Cameras, Pictures.` : `Not kept: ${answer.text}`, answer.ok ? "photo_camera" : "block");
    if (answer.ok) HL.emit("headland:picture", answer.data);
    return answer;
  }

  function button(current, hook = "camera-snapshot") {
    return el("button", { type: "button", class: "h-btn", "aria-label": "Snapshot", title: "Snapshot", "data-testid": hook, onclick: () => { const one = current(); return one ? keep(one.robot, one.camera, one.label) : HL.toast("Choose a picture first.", "info"); } }, icon("photo_camera"), el("span", { class: "c-word" }, "Snapshot"));
  }

  Object.assign(HL.camera, { snapshot: { keep, button, may, why, when } });
})();
