// Accepting a station, changing it, taking it away.
(() => {
  "use strict";
  const { el } = HL;
  const U = HL.sensorUnits;
  const MOST_NAME = 60;
  const of = (station) => `/sensors/${encodeURIComponent(station.id)}`;

  // fields it may stand for; without an answer the one it has stays choosable
  async function parcels(station) {
    const answer = await HL.port.api("GET", "/fields");
    const found = answer.ok ? (answer.data.fields ?? []).map((one) => [one.id, one.name || one.id]) : [];
    if (station.parcel && !found.some(([id]) => id === station.parcel)) found.unshift([station.parcel, station.parcel_name || station.parcel]);
    return [["", "No field"], ...found];
  }

  const about = (station) => el("p", { class: "h-2 h-t16" }, [HL.sensorRules.KINDS[station.kind] ?? "Station", station.model, `id ${station.id}`].filter(Boolean).join(", "));

  async function accept(station) {
    if (!station) return;
    const fields = await parcels(station);
    const form = new HL.SensorForm("sensor-accept");
    const rows = [form.input("name", "Name", station.name, { maxlength: MOST_NAME }), form.pick("parcel", "Field it stands for", fields, station.parcel)];
    form.open({
      title: `Accept ${station.name || station.id}?`,
      body: [about(station), el("p", { class: "h-t16" }, "From now on its values count: for limits, alarms and treatment."), ...rows.map((row) => row.label)],
      label: "Accept",
      save: () => {
        const name = form.of("name").value.trim();
        if (!name) return form.tell("Give it a name that people know.", "name");
        return { method: "POST", path: `${of(station)}/accept`, body: { name, parcel: form.of("parcel").value }, done: `${name} counts now.` };
      },
    });
  }

  async function edit(station) {
    const fields = await parcels(station);
    const form = new HL.SensorForm("sensor-edit");
    const name = form.input("name", "Name", station.name, { maxlength: MOST_NAME });
    const parcel = form.pick("parcel", "Field it stands for", fields, station.parcel);
    const lat = form.number("lat_deg", "Latitude, degrees", U.isNumber(station.lat_deg) ? station.lat_deg.toFixed(6) : "");
    const lon = form.number("lon_deg", "Longitude, degrees", U.isNumber(station.lon_deg) ? station.lon_deg.toFixed(6) : "");
    const remove = el("button", { type: "button", class: "h-btn", "data-testid": "sensor-remove", onclick: () => forget(station) }, "Remove this station");
    form.open({
      title: station.name,
      body: [about(station), el("div", { class: "sn-pairs" }, name.label, parcel.label, lat.label, lon.label), el("div", {}, remove)],
      label: "Save",
      save: () => {
        if (!name.node.value.trim()) return form.tell("Give it a name that people know.", "name");
        const where = form.numbers(["lat_deg", "lon_deg"]);
        if (!where) return null;
        if ((where.lat_deg === null) !== (where.lon_deg === null)) return form.tell("Latitude and longitude belong together.", where.lat_deg === null ? "lat_deg" : "lon_deg");
        if (where.lat_deg !== null && Math.abs(where.lat_deg) > 90) return form.tell("Latitude is between -90 and 90.", "lat_deg");
        if (where.lon_deg !== null && Math.abs(where.lon_deg) > 180) return form.tell("Longitude is between -180 and 180.", "lon_deg");
        return { method: "PUT", path: of(station), body: { name: name.node.value.trim(), parcel: parcel.node.value || null, revision: station.revision, ...(where.lat_deg === null ? {} : where) }, done: "Saved" };
      },
    });
  }

  function forget(station) {
    const form = new HL.SensorForm("sensor-forget");
    form.open({
      title: `Remove ${station.name}?`,
      body: [el("p", { class: "h-t16" }, "Its values no longer count for limits and treatment. While it still speaks to the broker it is shown as new and can be accepted again.")],
      label: "Remove",
      save: () => ({ method: "DELETE", path: of(station), body: null, done: `${station.name} was removed.` }),
    });
  }

  // a picture now; the answer is the station's own word, and nothing is said to be taken before it came
  const TRIGGER_MS = 20000;
  const OUTCOMES = { accepted: "Picture asked for and accepted.", rejected: "The station refused.", timed_out: "No answer from the station. It may be asleep or out of reach." };
  async function trigger(station) {
    const answer = await HL.port.api("POST", `${of(station)}/trigger`, {}, TRIGGER_MS);
    const outcome = answer.outcome ?? answer.data?.outcome ?? "unknown";
    const words = answer.text || answer.data?.text || OUTCOMES[outcome] || "No answer from the server. Look at Cameras before you ask again.";
    HL.sensors.load();
    return { outcome, words };
  }

  HL.sensorSheets = { accept, edit, trigger, path: of };
})();
