// What the Cameras screen knows: the cameras there are, how the wall is laid out, which picture is chosen.
(() => {
  "use strict";
  const { el } = HL;
  const LIST_MS = 10000; // cameras come and go with their robots
  const AGAIN_MS = 3000; // while the list cannot be had
  const STARTS_MS = 30000; // the camera process comes up, and comes back, within this
  const SOON_MS = 1000; // while it does
  const KEY = () => `headland.cameras.${HL.config.user?.id ?? "-"}`;
  const USUAL = { size: 3, mode: "attention", group: "", mine: [] };

  const wall = { cameras: null, problem: null, current: null, asked: 0, downSince: null, choice: { ...USUAL, ...HL.keep.read(KEY(), {}) } };

  function choose(change) {
    wall.choice = { ...wall.choice, ...change };
    HL.keep.write(KEY(), wall.choice);
    HL.repaint();
  }

  let timer = null;
  let isOpen = false;
  async function load() {
    clearTimeout(timer);
    wall.asked ||= performance.now();
    const answer = await HL.port.api("GET", "/cameras");
    if (answer.ok) Object.assign(wall, { cameras: answer.cameras ?? [], problem: null, downSince: null });
    else {
      wall.problem = { code: answer.code, status: answer.status, text: answer.text };
      wall.downSince = answer.code === "cameras_down" ? wall.downSince ?? performance.now() : null;
    }
    HL.repaint();
    if (isOpen && answer.status !== 403) timer = setTimeout(load, answer.ok ? LIST_MS : isStarting() ? SOON_MS : AGAIN_MS);
  }
  // the console is there and its camera process is not yet
  const isStarting = () => wall.downSince !== null && performance.now() - wall.downSince < STARTS_MS;
  function begin() {
    isOpen = true;
    Object.assign(wall, { asked: 0, downSince: null });
    load();
  }
  function end() {
    isOpen = false;
    clearTimeout(timer);
  }

  const items = () => new Map(HL.fleet.items.map((one) => [one.id, one]));
  const arranged = () => HL.camera.order.arrange(wall.cameras ?? [], HL.fleet.items, { ...wall.choice, groups: HL.fleet.groups });

  // a sheet to choose the cameras of one's own wall, in the order they are chosen
  function chooseMine() {
    let mine = [...wall.choice.mine];
    const name = (one) => `${HL.port.fleet()[one.robot]?.name ?? (one.robot === "field" ? "Field" : one.robot)}, ${one.label || one.camera}`;
    const rows = (wall.cameras ?? []).map((one) => {
      const key = HL.camera.order.id(one);
      const box = el("input", { type: "checkbox", checked: mine.includes(key), onchange: () => (mine = box.checked ? [...mine, key] : mine.filter((other) => other !== key)) });
      return el("label", { class: "h-row c-mine", "data-testid": `my-wall-${one.robot}-${one.camera}` }, box, name(one));
    });
    HL.sheet({ title: "My wall", hook: "my-wall", body: [el("p", { class: "h-2 h-t16" }, "These pictures, in the order you choose them. Kept on this device."), el("div", { class: "c-minelist" }, ...(rows.length ? rows : ["No camera yet."]))], buttons: [["Cancel", (close) => close()], ["Use these", (close) => (choose({ mine, mode: "mine" }), close()), true]] });
  }

  Object.assign(HL.camera, { wall: Object.assign(wall, { choose, load, begin, end, isStarting, items, arranged, chooseMine }) });
})();
