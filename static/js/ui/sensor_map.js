// The map of stations: it is handed what the list shows, and a tap on it chooses the same station.
(() => {
  "use strict";
  const TRY_MS = 500; // until the map has loaded
  const SEEN_PX = 40;
  const map = () => document.querySelector(".sn-map .hl-map")?.hlMap ?? null;
  let told = {};
  let wait = null;
  let looked = null;

  function tell() {
    const now = map();
    if (!now || !HL.sensors.found || now.host.clientWidth < SEEN_PX) return; // not laid out yet: it could not place its view
    const { chosen } = HL.sensors;
    const stations = HL.sensors.stations().map((one) => ({ id: one.id, name: one.name || one.id, kind: one.kind, state: one.state, lat: one.lat_deg, lon: one.lon_deg, isOver: one.values.some((value) => value.is_over && HL.sensorRules.rank(value.state) < 2), isChosen: one.id === chosen }));
    const key = JSON.stringify(stations);
    if (now.fleet.said && key === told.key && now === told.map) return;
    told = { key, map: now };
    now.setFleet({ stations, pictures: HL.sensorGlyphs.PICTURES });
    if (chosen && chosen !== looked) now.fleet.show?.(chosen);
    looked = chosen;
  }

  const tapped = ({ detail }) => HL.sensors.choose(detail);

  function begin() {
    told = {};
    window.addEventListener("headland:map-station", tapped);
    HL.sensors.listeners.add(tell);
    wait = setInterval(tell, TRY_MS); // states grow old between two answers too
  }
  function end() {
    window.removeEventListener("headland:map-station", tapped);
    HL.sensors.listeners.delete(tell);
    clearInterval(wait);
  }

  HL.sensorMap = { begin, end };
})();
