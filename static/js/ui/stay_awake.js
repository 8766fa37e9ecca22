// Keeps the screen on while this page has control of a robot: a tablet that sleeps loses control and pauses the robot.
// While an edge is walked, too: one that sleeps hears no positions.
(() => {
  "use strict";
  const LOOK_MS = 1000;
  let lock = null;
  let isAsking = false;

  const isWanted = () => !document.hidden && Boolean(HL.isWalking || (HL.view.robot && HL.lease.isMine(HL.view.robot)));

  async function look() {
    if (!navigator.wakeLock || isAsking || isWanted() === Boolean(lock)) return;
    if (lock) return void lock.release();
    isAsking = true;
    try {
      lock = await navigator.wakeLock.request("screen");
      lock.addEventListener("release", () => (lock = null)); // the browser takes it back when the page is hidden
    } catch {
      // refused, for example when the battery is low: asked again with the next look
    }
    isAsking = false;
  }

  // one line for the person: does this screen stay on?
  function line() {
    if (navigator.wakeLock) return "This screen stays on while you have control.";
    if (window.isSecureContext) return "This browser cannot keep the screen on: set its time-out to the longest.";
    return "This screen may switch itself off: keeping it on needs HTTPS.";
  }

  setInterval(look, LOOK_MS);
  Object.assign(HL, { awake: { line, isHeld: () => Boolean(lock) } });
})();
