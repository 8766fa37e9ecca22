// Who is responsible for the robot of an alarm; asked for once and at each change that the lane tells.
(() => {
  "use strict";
  const NOBODY = "unassigned";
  let duty = null;
  let isUsed = false; // a farm where nobody takes robots is not told that nobody has them

  let asked = 0;
  let answered = 0;

  async function load() {
    const number = (asked += 1);
    const answer = await HL.port.api("GET", "/fleet/duty");
    if (!answer.ok || number < answered) return; // the names that are shown stay, also before an answer that a newer one overtook
    answered = number;
    duty = answer.duty;
    isUsed = Object.values(duty).some((one) => one.user);
    HL.repaint();
  }

  // a name, NOBODY, or "" for what is no robot; null before it is known
  function of(source) {
    if (!duty) return null;
    if (!isUsed || !(source in HL.port.fleet())) return "";
    return duty[source]?.name || NOBODY;
  }

  function begin() {
    load();
    const offs = [window.headland.on("event", (told) => told?.kind === "duty" && load()), window.headland.on("hello", load)]; // what changed while the line was down was told to nobody
    return () => offs.forEach((off) => off?.());
  }

  HL.alarmDuty = { NOBODY, begin, of };
})();
