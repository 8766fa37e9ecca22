// A mission drawn small: parcel, rows, headland, ways, home, start and end. North is up.
(() => {
  "use strict";
  const NS = "http://www.w3.org/2000/svg";
  const METRES_PER_DEGREE = 111320;
  const MARGIN = 0.05;
  const LEAST_ROW_PX = 4;
  // these come with this script: the styles of every page have no room for them
  const DONE = { stroke: "var(--hl-m-done)", strokeWidth: "1.6" };
  const HERE = { fill: "var(--hl-sel)", stroke: "var(--hl-raised)", strokeWidth: "1.5" };
  const LAYERS = [["done", "done"], ["exit", "way"], ["approach", "way"], ["turn", "turn"], ["idle", "idle"], ["headland", "headland"], ["row", "row"]];

  function svg(tag, props, ...children) {
    const node = document.createElementNS(NS, tag);
    for (const [key, value] of Object.entries(props)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  }

  // metres around the field's first corner: a picture needs no better projection
  function projection(features) {
    const parcel = features.find((one) => one.properties.kind === "parcel");
    const [lon0, lat0] = parcel ? parcel.geometry.coordinates[0][0] : [0, 0];
    const scale = Math.cos((lat0 * Math.PI) / 180) * METRES_PER_DEGREE;
    return { flat: ([lon, lat]) => [(lon - lon0) * scale, (lat0 - lat) * METRES_PER_DEGREE], unflat: ([x, y]) => [lon0 + x / scale, lat0 - y / METRES_PER_DEGREE] };
  }

  // a piece of a row or lap that is driven with the tool off
  const lookOf = ({ kind, tool_on: isOn }) => (isOn === false && (kind === "row" || kind === "headland") ? "idle" : kind);

  const path = (points, isClosed) => `M${points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L")}${isClosed ? "Z" : ""}`;

  function box(points) {
    const xs = points.map((p) => p[0]);
    const ys = points.map((p) => p[1]);
    const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
    const most = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
    return [least(xs), least(ys), most(xs), most(ys)];
  }

  // what of a path is behind somebody who is so many metres along one of its segments: lines with those that are done as
  // such, and where that is and which way it looks, [x, y, degrees to the right of east]
  function behind(lines, { segment, segment_s_m: along }) {
    const tool = (one) => one.kind === "row" || one.kind === "headland";
    const here = lines.findIndex((one) => one.segment === segment);
    if (here < 0) return { lines, at: null };
    const { points } = lines[here];
    let left = along, k = 1;
    const long = () => Math.hypot(points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1]);
    for (; k < points.length - 1 && left > long(); k += 1) left -= long();
    const [a, b] = [points[k - 1], points[k]];
    const part = Math.min(1, left / (long() || 1));
    const place = [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])];
    const done = (one, to) => (tool(one) ? [{ ...one, kind: "done", points: to }] : []);
    const split = [
      ...lines.flatMap((one) => (one.segment < segment ? done(one, one.points) : [])),
      ...done(lines[here], [...points.slice(0, k), place]),
      { ...lines[here], points: [place, ...points.slice(k)] },
      ...lines.filter((one) => one.segment > segment),
    ];
    return { lines: split, at: [...place, (Math.atan2(b[1] - a[1], b[0] - a[0]) * 180) / Math.PI] };
  }

  // a dose in words of one line
  const doseWords = (dose) => (dose === 0 ? "Off" : dose === 0.5 ? "Half dose" : dose === 1 ? "Usual dose" : dose === 2 ? "Double dose" : `${dose} × dose`);

  // metres between neighbouring rows: the median, for a row may lie there in pieces
  function spacingOf(rows) {
    const middles = rows.map(({ points }) => points[0].map((_, axis) => (points[0][axis] + points.at(-1)[axis]) / 2));
    const gaps = rows.slice(1).map(({ points: [a, ...rest] }, i) => {
      const [b, [x, y]] = [rest.at(-1) ?? a, middles[i]];
      const long = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      return Math.abs((x - a[0]) * (b[1] - a[1]) - (y - a[1]) * (b[0] - a[0])) / long;
    }).filter((gap) => gap > 0.05).sort((p, q) => p - q);
    return gaps[gaps.length >> 1] ?? 0;
  }

  // rows that would stand too close to be told apart are drawn as worked ground with every so many rows on it: lines
  // nearer than a few pixels make bands that are not there
  function rowsIn(root, rows) {
    const spacing = spacingOf(rows);
    const ground = svg("path", { class: "swath", d: "" });
    Object.assign(ground.style, { stroke: "var(--hl-m-path)", vectorEffect: "none", strokeOpacity: "0.3", strokeWidth: String(spacing || 1) });
    const lines = svg("path", { class: "row", d: "" });
    let step = 0;
    const look = () => {
      const { width, height } = root.getBoundingClientRect();
      const [, , wide, high] = root.getAttribute("viewBox").split(" ").map(Number);
      const px = Math.min(width / wide, height / high) * spacing;
      const wanted = px > 0 ? 2 ** Math.max(0, Math.ceil(Math.log2(LEAST_ROW_PX / px))) : 1;
      if (wanted === step) return;
      step = wanted;
      lines.setAttribute("d", rows.filter(({ row }, i) => (row || i) % step === 0).map((one) => path(one.points, false)).join(""));
      ground.setAttribute("d", step > 1 ? rows.map((one) => path(one.points, false)).join("") : "");
    };
    look();
    new ResizeObserver(look).observe(root);
    new MutationObserver(look).observe(root, { attributeFilter: ["viewBox"] });
    return [ground, lines];
  }

  // fieldPicture(GeoJSON of a mission, title, how far it is) -> <svg>; its `frame` has flat, unflat and the box of everything
  function fieldPicture(collection, title, progress = null) {
    const { features } = collection;
    const { flat, unflat } = projection(features);
    const every = features.filter((one) => one.geometry.type === "LineString").map((one) => ({ kind: lookOf(one.properties), row: one.properties.row, segment: one.properties.segment, points: one.geometry.coordinates.map(flat) }));
    const { lines, at } = progress ? behind(every, progress) : { lines: every, at: null };
    const parcels = features.filter((one) => one.properties.kind === "parcel").map((one) => one.geometry.coordinates.map((ring) => ring.map(flat)));
    const homes = features.filter((one) => one.properties.kind === "home").map((one) => flat(one.geometry.coordinates));
    const [x0, y0, x1, y1] = box([...parcels.flat(2), ...lines.flatMap((one) => one.points), ...homes]);
    const size = Math.max(x1 - x0, y1 - y0, 1);
    const pad = size * MARGIN;
    const mark = size * 0.016;
    const root = svg("svg", { class: "h-picture", viewBox: `${x0 - pad} ${y0 - pad} ${x1 - x0 + 2 * pad} ${y1 - y0 + 2 * pad}`, role: "img", "aria-label": title, preserveAspectRatio: "xMidYMid meet" });
    for (const rings of parcels) root.append(svg("path", { class: "parcel", d: rings.map((ring) => path(ring, true)).join(""), "fill-rule": "evenodd" }));
    for (const { geometry, properties } of features.filter((one) => one.properties.kind === "dose")) {
      const polygons = geometry.type === "Polygon" ? [geometry.coordinates] : geometry.coordinates;
      const shape = svg("path", { class: properties.dose > 0 ? "dose" : "dose off", d: polygons.flat().map((ring) => path(ring.map(flat), true)).join(""), "fill-rule": "evenodd" });
      shape.append(svg("title", {}, doseWords(properties.dose)));
      root.append(shape);
    }
    const rows = lines.filter((one) => one.kind === "row");
    for (const [kind, look] of LAYERS) {
      if (kind === "row" && rows.length > 1) {
        root.append(...rowsIn(root, rows));
        continue;
      }
      const d = lines.filter((one) => one.kind === kind).map((one) => path(one.points, false)).join("");
      if (!d) continue;
      const drawn = svg("path", { class: look, d });
      if (look === "done") Object.assign(drawn.style, DONE);
      root.append(drawn);
    }
    if (rows.length) {
      const [sx, sy] = rows[0].points[0];
      const [ex, ey] = lines.filter((one) => one.kind === "row" || one.kind === "headland").at(-1).points.at(-1);
      if (!at) root.append(svg("circle", { class: "start", cx: sx, cy: sy, r: mark }));
      root.append(svg("rect", { class: "end", x: ex - mark, y: ey - mark, width: 2 * mark, height: 2 * mark }));
    }
    if (at) {
      const here = svg("path", { class: "here", "data-testid": "picture-here", d: `M${1.6 * mark} 0L${-1.2 * mark} ${1.2 * mark}L${-0.6 * mark} 0L${-1.2 * mark} ${-1.2 * mark}Z`, transform: `translate(${at[0].toFixed(2)} ${at[1].toFixed(2)}) rotate(${at[2].toFixed(1)})` });
      Object.assign(here.style, HERE);
      root.append(here);
    }
    for (const [x, y] of homes) root.append(svg("path", { class: "home", d: `M${x - mark * 1.4} ${y}L${x} ${y - mark * 1.6}L${x + mark * 1.4} ${y}V${y + mark * 1.4}H${x - mark * 1.4}Z` }));
    const [u0, v0, u1, v1] = parcels.length ? box(parcels.flat(2)) : [x0, y0, x1, y1];
    root.frame = { flat, unflat, field: [u0 - pad, v0 - pad, u1 + pad, v1 + pad], box: [x0 - pad, y0 - pad, x1 + pad, y1 + pad] };
    root.append(...(HL.areaShapes?.(drawnIn(features, flat)) ?? []));
    return root;
  }

  // ground drawn on the mission, as areaShapes wants it
  const drawnIn = (features, flat) => features.filter((one) => ["obstacle", "leave_out"].includes(one.properties.kind)).map((one) => ({ look: one.properties.kind, clearance_m: one.properties.clearance_m, ring: one.geometry.coordinates[0].map(flat) }));

  Object.assign(HL, { fieldPicture, doseWords });
})();
