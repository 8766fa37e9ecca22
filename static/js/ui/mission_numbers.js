// What a plan costs, in words and in the person's units; machine-readable values stay SI.
(() => {
  "use strict";
  const { el, words } = HL;
  const STATUS = {
    draft: "Draft", validated: "Ready to send", queued: "Queued", waiting: "Waiting", sent: "Sent", accepted: "On the robot", running: "Running",
    paused: "Paused", resuming: "Resuming", done: "Done", aborted: "Aborted", failed: "Failed",
  };

  const share = (part, whole) => (whole > 0 ? (100 * part) / whole : 0);
  const km = (m) => (m >= 1000 ? [(m / 1000).toFixed(2), "km"] : [m.toFixed(0), "m"]);
  const kwh = (j) => (j / 3.6e6).toFixed(1);

  // how the turns of a plan stop on their way
  function stops(s) {
    const parts = [[s.pivots, "on the spot"], [Math.round((s.reversals ?? 0) / 2), "backing up"]].filter(([count]) => count);
    return parts.length ? parts.map(([count, how]) => `${count} ${how}`).join(", ") : "none on the spot";
  }

  function card(hook, label, [number, unit], line, value) {
    return el("div", { class: "h-card h-stat", "data-testid": `plan-stat-${hook}`, "data-value": value }, el("div", { class: "h-h" }, label), el("div", { class: "h-t22 h-b" }, number, " ", el("small", { class: "h-t14 h-2" }, unit)), el("div", { class: "h-t12 h-2" }, line));
  }

  // whose battery a figure is of
  function ofWhom(s) {
    const store = s.is_tank ? "tank" : "battery";
    const name = HL.port?.fleet()[s.machine?.robot_id]?.name;
    return name ? `the full ${store} of ${name}` : `a full ${store}`;
  }

  // cards of a plan's statistics
  function cards(s) {
    const area = HL.units.area(s.covered_m2);
    const turning = Math.max(0, s.duration_s - s.working_s);
    return el("div", { class: "h-stats" },
      card("length", "Path", km(s.length_m), `${s.rows} rows, ${s.headland_passes} ${s.headland_passes === 1 ? "lap" : "laps"}`, s.length_m),
      card("time", "Time", [words.left(s.duration_s), ""], `${words.left(s.working_s)} work, ${words.left(turning)} turns and ways`, s.duration_s),
      card("turns", "Turns", [String(s.turns), ""], stops(s), s.turns),
      card("coverage", "Covered", [share(s.covered_m2, s.area_m2).toFixed(1), "%"], `${area.text} ${area.unit} of the field`, share(s.covered_m2, s.area_m2) / 100),
      card("overlap", "Overlap", [share(s.overlap_m2, s.area_m2).toFixed(1), "%"], "worked twice", share(s.overlap_m2, s.area_m2) / 100),
      card("energy", "Energy", [kwh(s.energy_j), "kWh"], s.battery_share <= 0.85 ? `${Math.round(100 * s.battery_share)} % of ${ofWhom(s)}` : `${Math.ceil(s.battery_share / 0.85)} ${s.is_tank ? "tanks" : "battery charges"}`, s.energy_j),
    );
  }

  HL.plan = { cards, stops, status: (name) => STATUS[name] ?? name };
})();
