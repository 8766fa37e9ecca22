// What stands on a farm map: kinds of features, what can be entered for each, and how a change of it reads.
(() => {
  "use strict";
  const KINDS = {
    parcel: "Parcel", farm: "Farm", obstacle: "Obstacle", "no-go": "No-go zone", slow: "Slow zone", treatment: "Treatment area", building: "Building", road: "Road",
    home: "Home", gate: "Gate", rows: "Rows", tree: "Tree", hedge: "Hedge", water: "Water",
  };
  const SHAPES = {
    Polygon: ["parcel", "farm", "obstacle", "no-go", "slow", "treatment", "building", "road", "tree", "hedge", "water"],
    LineString: ["road", "rows", "tree", "hedge", "water"],
    MultiLineString: ["rows"],
    Point: ["home", "gate", "obstacle", "tree"],
  };
  const LAYERS = [
    ["parcels", "Parcels", ["parcel", "farm"]], ["rows", "Rows", ["rows"]], ["obstacles", "Obstacles, zones, treatment", ["obstacle", "no-go", "slow", "treatment"]],
    ["roads", "Roads, homes, gates", ["road", "home", "gate"]], ["surroundings", "Buildings, trees, water", ["building", "tree", "hedge", "water"]],
  ];

  // unit is what the person reads, scale what SI is multiplied by to get there
  const number = (key, label, unit, least, most, digits, scale = 1) => ({ key, label, type: "number", unit, least, most, digits, scale });
  const text = (key, label, offers) => ({ key, label, type: "text", offers });
  const choice = (key, label, options) => ({ key, label, type: "choice", options });
  const CROPS = ["Sugar beet", "Maize", "Winter wheat", "Potatoes", "Onions", "Carrots", "Spinach", "Rapeseed", "Soy", "Grass"];
  const WIDTH = number("width_m", "Width", "m", 0.1, 200, 1);
  const RADIUS = number("radius_m", "Radius", "m", 0.05, 1000, 2);
  const HEIGHT = number("height_m", "Height above ground", "m", 0.01, 300, 2); // of what is flown over
  const NAME_CHARS = 80;
  const ASSUMED_RADIUS_M = 1; // as of an imported point
  const byName = (a, b) => a.localeCompare(b, undefined, { numeric: true });
  const named = (pairs) => pairs.toSorted(([, a], [, b]) => byName(a, b));
  const robots = () => named(Object.entries(HL.port.fleet()).map(([id, robot]) => [id, robot.name]));
  const fieldsBy = (features) => named([...features].filter(([, one]) => kindOf(one) === "parcel").map(([id, one]) => [id, nameOf(one)]));
  const FIELDS = {
    parcel: [
      text("crop", "Crop", CROPS), text("status", "Status", ["BBCH 10", "BBCH 12", "BBCH 14", "BBCH 16"]), { key: "seeded", label: "Seeding date", type: "date" },
      number("row_spacing_m", "Row spacing", "cm", 1, 1000, 1, 100), number("row_bearing_deg", "Row direction", "° from north", -360, 360, 1), number("headland_m", "Headland width", "m", 0, 100, 1),
    ],
    obstacle: { Point: [RADIUS, HEIGHT], Polygon: [HEIGHT] },
    road: { LineString: [WIDTH] },
    building: [text("category", "Use", ["Barn", "House", "Hall", "Silo"]), HEIGHT],
    home: [
      choice("type", "Type", [["home", "Home"], ["garage", "Garage"], ["charging", "Charging"]]), choice("robot", "Robot", () => [["", "Any robot"], ...robots()]),
      { ...number("heading_deg", "Heading", "° from north", -360, 360, 1), isCompass: true },
    ],
    gate: [WIDTH],
    treatment: [number("dose", "Dose, 0 is off", "× usual", 0, 2, 2)],
    slow: [number("speed_mps", "Speed limit", "m/s", 0.01, 10, 2)],
    rows: [choice("type", "Type", [["a-b", "Straight, A to B"], ["curve", "Curve"], ["recorded", "Recorded"]]), { ...choice("parcel_id", "Field", (features) => [["", "No field"], ...fieldsBy(features)]), gone: "A field not on this map" }],
    tree: { LineString: [WIDTH, HEIGHT], Point: [RADIUS, HEIGHT], Polygon: [HEIGHT] },
    hedge: { LineString: [WIDTH, HEIGHT], Polygon: [HEIGHT] },
    water: { LineString: [WIDTH] },
  };
  const SOILS = ["Clay", "Clay loam", "Loam", "Sandy loam", "Sand", "Silt", "Peat"];
  const MORE = { parcel: [text("species", "Variety"), text("soil_type", "Soil", SOILS), text("category", "Category"), text("type", "Type")] };

  const kindOf = (feature) => feature.properties?.kind ?? "";
  const label = (kind) => KINDS[kind] ?? kind;
  const nameOf = (feature) => feature.properties?.name || label(kindOf(feature));
  // of these, the areas of one kind, that of the first: what can be merged; a farm is the ground around
  const mergeable = (features) => {
    const areas = features.filter((one) => one?.geometry.type === "Polygon" && kindOf(one) !== "farm");
    return areas.filter((one) => kindOf(one) === kindOf(areas[0]));
  };
  const fieldsOf = (feature) => {
    const fields = FIELDS[kindOf(feature)] ?? [];
    return Array.isArray(fields) ? fields : fields[feature.geometry?.type] ?? [];
  };
  const moreOf = (feature) => MORE[kindOf(feature)] ?? [];
  const kindsFor = (feature) => SHAPES[feature.geometry?.type] ?? [kindOf(feature)];

  // degrees clockwise from north of those counter-clockwise from east, and back: the way a heading is kept
  const compass = (degrees) => (((90 - degrees) % 360) + 360) % 360;

  // what an input shows for a stored value, and back; undefined: not a value this field takes
  function shown(field, value) {
    if (value === null || value === undefined) return "";
    if (field.type !== "number") return String(value);
    const scaled = field.isCompass ? compass(value) : value * (field.scale ?? 1);
    return field.key === "row_bearing_deg" ? scaled.toFixed(1) : String(Number(scaled.toFixed(field.digits)));
  }

  // the same where it is told and not edited
  const told = (field, value) => (field.type === "date" && value ? HL.words.date(new Date(`${value}T00:00`)) : shown(field, value));

  function stored(field, input) {
    const string = input.trim();
    if (string === "") return null;
    if (field.type !== "number") return string.slice(0, 120);
    const value = Number(string.replace(",", "."));
    if (!Number.isFinite(value) || value < field.least || value > field.most) return undefined;
    return Number((field.isCompass ? compass(value) : value / (field.scale ?? 1)).toFixed(6));
  }

  const bounds = (field) => `${field.label}: ${field.least} to ${field.most} ${field.unit}`;

  // "Row direction 11.5 to 9.0", "Crop set to Maize", "Status removed"
  function changeLabel(field, before, after) {
    const [from, to] = [told(field, before), told(field, after)];
    const unit = field.type === "number" && field.unit.length < 4 && !field.unit.startsWith("°") ? ` ${field.unit}` : "";
    if (!to) return `${field.label} removed`;
    return from ? `${field.label} ${from} to ${to}${unit}` : `${field.label} set to ${to}${unit}`;
  }

  // a feature with one property changed; null takes it away
  function withProperty(feature, key, value) {
    const properties = { ...feature.properties, [key]: value };
    if (value === null) delete properties[key];
    return { ...feature, properties };
  }

  // a feature of another kind, with what that needs and without a type that it does not have
  function withKind(feature, kind) {
    const after = withProperty(feature, "kind", kind);
    const typeOf = (one) => fieldsOf(one).find((field) => field.key === "type" && field.type === "choice");
    const { type, radius_m: radius } = feature.properties;
    const isOff = type !== undefined && (typeOf(feature) || typeOf(after)) && !typeOf(after)?.options.some(([value]) => value === type);
    const fit = isOff ? withProperty(after, "type", null) : after;
    return kind === "obstacle" && feature.geometry.type === "Point" && !(radius > 0) ? withProperty(fit, "radius_m", ASSUMED_RADIUS_M) : fit;
  }

  const newId = (kind) => `${kind}-${window.headland.uuid().slice(0, 12)}`;

  HL.maps = { KINDS, LAYERS, kindOf, mergeable, label, nameOf, fieldsOf, moreOf, kindsFor, shown, told, stored, bounds, changeLabel, withProperty, withKind, newId, robots, byName, NAME_CHARS };
})();
