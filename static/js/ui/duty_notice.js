// Said on every screen: robots whose person is gone, to who sees to that; and what changed for this person.
(() => {
  "use strict";
  const MOST_NAMES = 3;

  function named(names) {
    const rest = names.length - MOST_NAMES;
    return rest > 1 ? `${names.slice(0, MOST_NAMES).join(", ")} and ${rest} more` : names.join(", ");
  }

  // what this person is told of a change, or ""
  function words({ what, names = [], by, by_id: byId, to_user: to, from_users: from = [] }, { me, isInCharge, isFleet }) {
    const which = named(names);
    if (!which || byId === me) return "";
    if (what === "offered") return to === me && !isFleet ? `${by} hands over ${which} to you. Take over on Fleet.` : "";
    if (what === "declined") return to === me ? `${by} does not take over ${which}. It stays as it was.` : "";
    if (what === "released" && isInCharge) return `Nobody is responsible for ${which} any more.`;
    if (!from.includes(me)) return "";
    return what === "released" ? `You are no longer responsible for ${which}.` : `${by} is responsible for ${which} now, no longer you.`;
  }

  window.headland.on("event", (told) => {
    if (told?.kind !== "duty") return;
    const said = words(told, { me: HL.config.user?.id, isInCharge: HL.config.rights.includes("take_lease"), isFleet: HL.view.screen === "fleet" });
    if (said) HL.toast(said, "badge");
  });

  HL.dutyNotice = { words };
})();
