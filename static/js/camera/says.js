// What a picture says about itself, in words. Pure.
(() => {
  "use strict";
  const { words } = HL;
  const DOWN_MS = 1000;

  // "118 ms", "1.4 s"; how late a camera is that tells no time of its own nobody knows, only that it is later than measured
  const measured = (ms) => (ms < DOWN_MS ? `${Math.round(ms)} ms` : words.age(ms));
  const delay = ({ delayMs, isDated }) => (delayMs === null || !isDated ? "delay unknown" : measured(delayMs));
  const least = ({ delayMs, isDated, isSlow }) => (isDated || isSlow || delayMs === null ? "" : `, over ${measured(delayMs)}`);

  const fps = (value) => (value === null ? "" : value < 1 ? `1 per ${words.age(1000 / value).replace(".0 ", " ")}` : `${value < 2 ? value.toFixed(1) : Math.round(value)} fps`);
  // between two pictures of a slow camera its delay says little: its age says what is shown
  const old = ({ isDated, ageMs }) => `${isDated ? "" : "over "}${words.since(ageMs)} old`;
  const rate = (judged) => [judged.isSlow && judged.ageMs !== null ? old(judged) : delay(judged), fps(judged.fps)].filter(Boolean).join(", ");

  const still = (judged) => (judged.isSlow && judged.ageMs !== null ? old(judged) : judged.delayMs === null || !judged.isDated ? "delay unknown" : words.age(judged.delayMs));

  // for how long there has been none: since the last one was taken, before the first one since it was asked for
  const goneMs = ({ ageMs, silentMs }) => ageMs ?? silentMs;

  // the corner of a tile: short, always with its unit
  function corner(judged, { way }) {
    if (judged.state === "connecting") return "starting";
    if (judged.state === "off") return `no picture ${words.since(goneMs(judged))}`;
    if (judged.state === "frozen") return `frozen ${words.since(judged.ageMs)}`;
    if (judged.state === "late") return `late, ${judged.isSlow ? old(judged) : `${words.age(judged.delayMs)} old`}`;
    if (way === "still") return `still pictures, ${still(judged)}`;
    return rate(judged);
  }

  // said beside the corner while pictures do not come the best way
  const note = (judged, { way, hasGivenUp }) => (judged.state === "live" && hasGivenUp && way !== "still" ? "Single pictures" : "");

  // one sentence for a big picture and for what reads aloud
  function sentence(label, judged, how) {
    if (judged.state === "frozen") return `${label}, frozen, ${words.since(judged.ageMs)} old`;
    if (judged.state === "late") return `${label}, late: ${judged.isSlow ? old(judged) : `${words.age(judged.delayMs)} old`}`;
    if (judged.state === "off") return `${label}: no picture for ${words.since(goneMs(judged))}`;
    if (judged.state === "connecting") return `${label}, starting`;
    const undated = judged.isDated ? "" : `. The camera tells no time${least(judged)}`;
    if (how.way === "still") return `${label}. Still pictures, ${still(judged)}${undated}`;
    return `${label}, ${rate(judged)}${undated}${how.hasGivenUp ? `. Single pictures: ${(how.why || "no direct way").replace(/\.$/, "")}` : ""}`;
  }

  // why there is none: the camera's own reason, then how often it was started again
  function reason(camera, problem) {
    if (problem) return problem;
    if (!camera) return "The server has not said anything about it yet.";
    const said = camera.reason || { off: "The robot is not connected.", failed: "The camera gives no pictures.", starting: "It is starting.", idle: "It is being asked." }[camera.state] || "The camera gives no pictures.";
    const times = camera.restarts === 1 ? "once" : camera.restarts ? `${camera.restarts} times` : "";
    return `${said[0].toUpperCase()}${said.slice(1).replace(/\.?$/, ".")}${times ? ` Restarted ${times}.` : ""}`;
  }

  // what the state is called outside: the names of the stable hooks
  const hook = (judged, { way, hasGivenUp }) => ({ late: "frozen" })[judged.state] ?? (judged.state === "live" && (hasGivenUp || way === "still") ? "stills" : judged.state);

  Object.assign(HL.camera, { says: { delay, goneMs, corner, note, sentence, reason, hook, rate } });
})();
