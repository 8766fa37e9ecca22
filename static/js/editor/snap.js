// Where a corner goes when it comes near a neighbour's corner or edge, or in line with or square to an own edge.

import { Plane } from '../map/plane.js';
import { boxAround, idOf, nearestOnEdge } from './draft.js';
import { edgesOf, isArea, partsOf } from './shape.js';

export const SNAP_PX = 12;
const SAME_M = 0.005;
const LEAST_SINE = 0.2; // flatter crossings of two guides lie too far from the finger's intent

/**
 * Directions that a corner may keep: through the neighbouring corners, along and square to the edges beside them.
 * ring: corners before the drag; returns [{at, along, text}], positions in degrees.
 */
export function ownGuides(ring, index, isClosed) {
  const count = ring.length;
  const has = (i) => isClosed || (i >= 0 && i < count);
  const corner = (i) => ring[(i + count) % count];
  const edge = (i) => ((i + count) % count) + 1;
  const guides = [];
  if (count < 2) return guides;
  for (const [near, far, own, beyond] of [[index - 1, index - 2, index - 1, index - 2], [index + 1, index + 2, index, index + 1]]) {
    if (!has(near)) continue;
    guides.push({ at: corner(near), along: [corner(near), corner(index)], text: `in line with edge ${edge(own)}` });
    if (!has(far) || count < 3) continue;
    const sides = [corner(far), corner(near)];
    guides.push({ at: corner(near), along: sides, text: `in line with edge ${edge(beyond)}` });
    guides.push({ at: corner(near), along: sides, isSquare: true, text: `at a right angle to edge ${edge(beyond)}` });
  }
  return guides;
}

/** Directions for the next corner of a line that is being drawn. */
export function penGuides(points) {
  const guides = [];
  const count = points.length;
  if (count >= 2) {
    const along = [points[count - 2], points[count - 1]];
    guides.push({ at: points[count - 1], along, text: `in line with edge ${count - 1}` });
    guides.push({ at: points[count - 1], along, isSquare: true, text: `at a right angle to edge ${count - 1}` });
  }
  if (count >= 3) guides.push({ at: points[0], along: [points[0], points[1]], isSquare: true, text: 'at a right angle to edge 1' });
  return guides;
}

/** {position, text, lines} of the best snap within `reachM`, or the position itself; lines are dashed guides. */
export function snapped(position, { draft, skip, guides, reachM, from = null }) {
  const plane = new Plane(position);
  const corner = nearestCorner(position, draft, skip, reachM, plane);
  if (corner) return corner;
  const rays = guides.map((guide) => rayOf(guide, plane)).filter((ray) => ray && ray.off <= reachM).sort((a, b) => a.off - b.off);
  const edge = nearestEdge(position, draft, skip, reachM, plane);
  const crossing = crossingOf(edge ? [edge.ray, ...rays] : rays, reachM, from && plane.toM(from));
  if (crossing) return { position: plane.toLonLat(crossing.at), text: crossing.text, lines: crossing.rays.map((ray) => lineOf(ray, crossing.at, plane)) };
  if (edge && edge.ray.off <= (rays[0]?.off ?? Infinity) + reachM / 2) return { position: plane.toLonLat(edge.ray.foot), text: edge.ray.text, lines: [] };
  const [ray] = rays;
  return ray ? { position: plane.toLonLat(ray.foot), text: ray.text, lines: [lineOf(ray, ray.foot, plane)] } : { position, text: '', lines: [] };
}

const nameOf = (feature) => feature.properties?.name || feature.properties?.kind || 'a neighbour';

function nearestCorner(position, draft, skip, reachM, plane) {
  let best = null;
  let off = reachM;
  const box = boxAround(position, reachM);
  for (const feature of draft.within(box)) {
    if (skip.has(idOf(feature))) continue;
    for (const point of partsOf(feature).flat(2)) {
      if (point[0] < box[0] || point[0] > box[2] || point[1] < box[1] || point[1] > box[3]) continue;
      const far = Math.hypot(...plane.toM(point));
      if (far <= off) [best, off] = [{ position: point, text: `on a corner of ${nameOf(feature)}`, lines: [], isCorner: true }, far];
    }
  }
  return best;
}

function nearestEdge(position, draft, skip, reachM, plane) {
  let best = null;
  const box = boxAround(position, reachM);
  for (const feature of draft.within(box)) {
    if (skip.has(idOf(feature)) || feature.geometry.type === 'Point') continue;
    for (const [a, b] of partsOf(feature).flat().flatMap((ring) => [...edgesOf(ring, isArea(feature))])) {
      if (Math.min(a[0], b[0]) > box[2] || Math.max(a[0], b[0]) < box[0] || Math.min(a[1], b[1]) > box[3] || Math.max(a[1], b[1]) < box[1]) continue;
      const foot = plane.toM(nearestOnEdge(a, b, position));
      const off = Math.hypot(...foot);
      if (off > (best?.ray.off ?? reachM)) continue;
      const [start, end] = [plane.toM(a), plane.toM(b)];
      best = { ray: { start, along: unit(start, end), foot, off, text: `on an edge of ${nameOf(feature)}`, isEdge: true } };
    }
  }
  return best;
}

function unit(a, b) {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
  return [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
}

/** A guide as a line in metres around the finger, with the nearest place on it; null for an edge without length. */
function rayOf({ at, along, isSquare, text }, plane) {
  const [start, p, q] = [plane.toM(at), plane.toM(along[0]), plane.toM(along[1])];
  if (Math.hypot(q[0] - p[0], q[1] - p[1]) < SAME_M) return null;
  const [x, y] = unit(p, q);
  const direction = isSquare ? [-y, x] : [x, y];
  const t = -(start[0] * direction[0] + start[1] * direction[1]);
  const foot = [start[0] + t * direction[0], start[1] + t * direction[1]];
  return { start, along: direction, foot, off: Math.hypot(...foot), text };
}

/** Where two guides cross near the finger; never the place the drag began at, which would hold the corner fast. */
function crossingOf(rays, reachM, from) {
  for (let i = 0; i < rays.length; i += 1) {
    for (let k = i + 1; k < rays.length; k += 1) {
      const [a, b] = [rays[i], rays[k]];
      const sine = a.along[0] * b.along[1] - a.along[1] * b.along[0];
      if (Math.abs(sine) < LEAST_SINE) continue;
      const [dx, dy] = [b.start[0] - a.start[0], b.start[1] - a.start[1]];
      const t = (dx * b.along[1] - dy * b.along[0]) / sine;
      const at = [a.start[0] + t * a.along[0], a.start[1] + t * a.along[1]];
      const isStart = from && Math.hypot(at[0] - from[0], at[1] - from[1]) < SAME_M;
      if (Math.hypot(...at) <= reachM && !isStart) return { at, rays: [a, b].filter((ray) => !ray.isEdge), text: `${a.text}, ${b.text}` };
    }
  }
  return null;
}

const lineOf = (ray, foot, plane) => [plane.toLonLat(ray.start), plane.toLonLat(foot)];
