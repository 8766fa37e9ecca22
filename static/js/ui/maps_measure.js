// Areas, lengths and rows of map features, in metres on a plane that touches the earth at the feature.
(() => {
  "use strict";
  const METRES_PER_DEGREE = 111319.49; // equator of WGS84, divided by 360
  const E2 = 0.00669438; // flattening of WGS84: north-south and east-west degrees differ by up to 0.7 %

  function plane([lon0, lat0]) {
    const sin = Math.sin((lat0 * Math.PI) / 180);
    const bend = 1 - E2 * sin * sin;
    const east = (METRES_PER_DEGREE * Math.cos((lat0 * Math.PI) / 180)) / Math.sqrt(bend);
    const north = (METRES_PER_DEGREE * (1 - E2)) / bend ** 1.5;
    return { flat: ([lon, lat]) => [(lon - lon0) * east, (lat - lat0) * north], round: ([x, y]) => [lon0 + x / east, lat0 + y / north] };
  }

  const flatten = (coordinates) => (typeof coordinates?.[0] === "number" ? [coordinates] : (coordinates ?? []).flatMap(flatten));
  const first = (feature) => flatten(feature.geometry?.coordinates)[0] ?? [0, 0];

  function ringArea(points) {
    let twice = 0;
    for (let i = 0; i < points.length - 1; i += 1) twice += points[i][0] * points[i + 1][1] - points[i + 1][0] * points[i][1];
    return Math.abs(twice) / 2;
  }

  function lineLength(points) {
    let sum = 0;
    for (let i = 1; i < points.length; i += 1) sum += Math.hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]);
    return sum;
  }

  // polygon: outer ring without its holes
  function areaM2(feature) {
    if (feature.geometry?.type !== "Polygon") return null;
    const { flat } = plane(first(feature));
    return feature.geometry.coordinates.reduce((sum, ring, i) => sum + (i ? -1 : 1) * ringArea(ring.map(flat)), 0);
  }

  // edge of a polygon's outer ring, length of lines
  function lengthM(feature) {
    const { type, coordinates } = feature.geometry ?? {};
    const { flat } = plane(first(feature));
    const lines = { Polygon: () => [coordinates[0]], LineString: () => [coordinates], MultiLineString: () => coordinates }[type]?.() ?? [];
    return lines.length ? lines.reduce((sum, line) => sum + lineLength(line.map(flat)), 0) : null;
  }

  // rows that fit beside each other: width across the rows, without the headland on both sides
  function rowsThatFit(feature) {
    const { row_spacing_m: spacing, row_bearing_deg: bearing, headland_m: headland = 0 } = feature.properties;
    if (feature.geometry?.type !== "Polygon" || !(spacing > 0) || !Number.isFinite(bearing)) return null;
    const { flat } = plane(first(feature));
    const angle = (bearing * Math.PI) / 180;
    const across = feature.geometry.coordinates[0].map(flat).map(([x, y]) => x * Math.cos(angle) - y * Math.sin(angle));
    const width = across.reduce((a, b) => Math.max(a, b), -Infinity) - across.reduce((a, b) => Math.min(a, b), Infinity);
    return Math.max(0, Math.floor((width - 2 * headland) / spacing));
  }

  function corners(feature) {
    const { type, coordinates } = feature.geometry ?? {};
    if (type === "Polygon") return Math.max(0, (coordinates[0]?.length ?? 0) - 1);
    return type === "Point" ? 1 : flatten(coordinates).length;
  }

  const holes = (feature) => (feature.geometry?.type === "Polygon" ? feature.geometry.coordinates.length - 1 : 0);
  const count = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;

  // moves a whole feature by metres
  function moved(feature, eastM, northM) {
    const { flat, round } = plane(first(feature));
    const move = (part) => (typeof part[0] === "number" ? round([flat(part)[0] + eastM, flat(part)[1] + northM]).map((n) => Number(n.toFixed(9))) : part.map(move));
    return { ...feature, geometry: { ...feature.geometry, coordinates: move(feature.geometry.coordinates) } };
  }

  // whether a place lies in a ring, by counting the edges to its east
  function isInRing([x, y], ring) {
    let isIn = false;
    for (let i = 1; i < ring.length; i += 1) {
      const [[x1, y1], [x2, y2]] = [ring[i - 1], ring[i]];
      if (y1 > y !== y2 > y && x < ((x2 - x1) * (y - y1)) / (y2 - y1) + x1) isIn = !isIn;
    }
    return isIn;
  }

  // ground around robots: where a farm that has no map begins to be drawn
  const AROUND_M = 150;
  const MOST_LOOKED_AT = 100;
  function groundAround(robots) {
    const places = robots.filter(({ lon, lat }) => Number.isFinite(lon) && Number.isFinite(lat)).slice(0, MOST_LOOKED_AT).map(({ lon, lat }) => [lon, lat]);
    return places.map((one) => { const { round } = plane(one); return { properties: {}, geometry: { type: "LineString", coordinates: [round([-AROUND_M, -AROUND_M]), round([AROUND_M, AROUND_M])] } }; });
  }

  const words = ({ text, unit }) => `${text} ${unit}`;
  const area = (m2) => (m2 < 1000 && HL.units.area(0).unit === "ha" ? { text: m2.toFixed(0), unit: "m²" } : HL.units.area(m2));
  const length = (m) => (m >= 100 && HL.units.length(0).unit === "m" ? { text: m.toFixed(0), unit: "m" } : HL.units.length(m));
  const place = ([lon, lat]) => `${Math.abs(lat).toFixed(5)}° ${lat < 0 ? "S" : "N"}, ${Math.abs(lon).toFixed(5)}° ${lon < 0 ? "W" : "E"}`;

  Object.assign(HL.maps, { areaM2, lengthM, rowsThatFit, corners, holes, count, moved, area, length, words, place, plane, groundAround, isInRing });
})();
