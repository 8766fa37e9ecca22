// Triangles of every shape. A vertex is (ux, uy, ox, oy, slot, alpha): a place in body units, an offset in px
// (outlines keep their width at every zoom) and one of three colours. Edges fade over one px: no multisampling needed.

import { MACHINES, MARKS, hullOf } from './shapes.js';

export const VERTEX_FLOATS = 6;
const [FILL, ACCENT, RIM] = [0, 1, 2];
const RIM_PX = 1.6;
const GHOST_PX = 2.2;
const DASH = [5, 3.5];

class Mesh {
  constructor() {
    this.vertices = [];
    this.indices = [];
  }

  vertex(u, o, slot, alpha) {
    this.vertices.push(u[0], u[1], o[0], o[1], slot, alpha);
    return this.vertices.length / VERTEX_FLOATS - 1;
  }

  quad(a, b, c, d) {
    this.indices.push(a, b, c, a, c, d);
  }
}

/** Outward px directions at the corners of an outline, long enough that edges move by one px. */
function corners(points, [hw, hl]) {
  const px = points.map(([x, y]) => [x * hw, y * hl]);
  let sum = 0;
  px.forEach(([x, y], i) => {
    const [nx, ny] = px[(i + 1) % px.length];
    sum += x * ny - nx * y;
  });
  const out = sum > 0 ? 1 : -1;
  const normal = (a, b) => {
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    return [((b[1] - a[1]) / length) * out, (-(b[0] - a[0]) / length) * out];
  };
  return px.map((point, i) => {
    const n = normal(px[(i + px.length - 1) % px.length], point);
    const m = normal(point, px[(i + 1) % px.length]);
    const dot = 1 + n[0] * m[0] + n[1] * m[1];
    const stretch = Math.min(1 / Math.max(dot, 0.2), 2.5); // spikes of sharp corners are cut
    return [(n[0] + m[0]) * stretch, (n[1] + m[1]) * stretch];
  });
}

const times = (v, f) => [v[0] * f, v[1] * f];

/** Filled outline, grown by `grow` px, with a one px fading rim. */
function fill(mesh, points, nominal, slot, grow = 0) {
  const dirs = corners(points, nominal);
  const inner = points.map((p, i) => mesh.vertex(p, times(dirs[i], grow - 0.5), slot, 1));
  const outer = points.map((p, i) => mesh.vertex(p, times(dirs[i], grow + 0.5), slot, 0));
  for (let i = 1; i + 1 < points.length; i += 1) mesh.indices.push(inner[0], inner[i], inner[i + 1]);
  points.forEach((_, i) => {
    const next = (i + 1) % points.length;
    mesh.quad(inner[i], inner[next], outer[next], outer[i]);
  });
}

/** A band of `width` px along places with px directions; `closed` joins the ends. */
function band(mesh, places, dirs, width, slot, closed) {
  const steps = [[-width / 2 - 0.5, 0], [-width / 2 + 0.5, 1], [width / 2 - 0.5, 1], [width / 2 + 0.5, 0]];
  const rows = places.map((p, i) => steps.map(([o, a]) => mesh.vertex(p, times(dirs[i], o), slot, a)));
  const last = closed ? rows.length : rows.length - 1;
  for (let i = 0; i < last; i += 1) {
    const [a, b] = [rows[i], rows[(i + 1) % rows.length]];
    for (let j = 0; j < 3; j += 1) mesh.quad(a[j], b[j], b[j + 1], a[j + 1]);
  }
}

/** Dashes along an outline, in nominal px. */
function dashes(mesh, points, nominal, width, slot) {
  points.forEach((p, i) => {
    const q = points[(i + 1) % points.length];
    const d = [(q[0] - p[0]) * nominal[0], (q[1] - p[1]) * nominal[1]];
    const length = Math.hypot(d[0], d[1]);
    const normal = [d[1] / length, -d[0] / length];
    const count = Math.max(1, Math.round((length + DASH[1]) / (DASH[0] + DASH[1])));
    const gap = count > 1 ? (length - count * DASH[0]) / (count - 1) : 0;
    for (let k = 0; k < count; k += 1) {
      const from = (k * (DASH[0] + gap)) / length;
      const to = Math.min(1, from + DASH[0] / length);
      const at = (t) => [p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t];
      band(mesh, [at(from), at(to)], [normal, normal], width, slot, false);
    }
  });
}

function machine({ nominal, outline, arrow }) {
  const mesh = new Mesh();
  outline.forEach((part) => fill(mesh, part, nominal, RIM, RIM_PX));
  outline.forEach((part) => fill(mesh, part, nominal, FILL));
  if (arrow) fill(mesh, arrow, nominal, ACCENT);
  return mesh;
}

function ghost({ nominal, outline, arrow }) {
  const mesh = new Mesh();
  outline.forEach((part) => fill(mesh, part, nominal, FILL));
  outline.forEach((part) => dashes(mesh, part, nominal, GHOST_PX, RIM));
  if (arrow) fill(mesh, arrow, nominal, ACCENT);
  return mesh;
}

/** For crowds: a tenth of the triangles, no soft edges. */
function small({ nominal, outline, arrow }) {
  const mesh = new Mesh();
  const flat = (points, slot, grow) => {
    const dirs = corners(points, nominal);
    const first = points.map((p, i) => mesh.vertex(p, times(dirs[i], grow), slot, 1));
    for (let i = 1; i + 1 < points.length; i += 1) mesh.indices.push(first[0], first[i], first[i + 1]);
  };
  const hull = hullOf({ outline });
  flat(hull, RIM, RIM_PX);
  flat(hull, FILL, 0);
  if (arrow) flat(arrow, ACCENT, 0);
  return mesh;
}

const circle = (sides) => Array.from({ length: sides }, (_, i) => {
  const angle = (i / sides) * 2 * Math.PI;
  return [Math.sin(angle), Math.cos(angle)];
});

function mark(spec) {
  const mesh = new Mesh();
  const points = spec.points ?? circle(spec.sides);
  if (spec.kind === 'fill') fill(mesh, points, [20, 20], FILL);
  else if (!spec.of) band(mesh, points, points, spec.width, FILL, true);
  else {
    const solid = spec.of - spec.gap;
    for (let i = 0; i < points.length; i += spec.of) {
      const run = Array.from({ length: solid + 1 }, (_, k) => points[(i + k) % points.length]);
      band(mesh, run, run, spec.width, FILL, false);
    }
  }
  return mesh;
}

/** Shape name -> {vertices: Float32Array, indices: Uint16Array}. */
export function buildMeshes() {
  const meshes = {};
  const keep = (name, mesh) => {
    meshes[name] = { vertices: new Float32Array(mesh.vertices), indices: new Uint16Array(mesh.indices) };
  };
  for (const [name, spec] of Object.entries(MARKS)) keep(name, mark(spec));
  for (const [name, spec] of Object.entries(MACHINES)) {
    keep(name, machine(spec));
    keep(`${name}-ghost`, ghost(spec));
    keep(`${name}-small`, small(spec));
  }
  return meshes;
}
