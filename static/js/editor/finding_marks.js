// What the checks found, at its place: the priority's shape and number, crossing edges in orange.

import { areaM2, labelPoint, polygonParts } from '../map/geometry.js';
import { nearestOnEdge } from './draft.js';
import { lengthM } from '../map/plane.js';
import { edgesOf, isArea, partsOf } from './shape.js';
import { haloText, line } from './ink.js';

const SHAPES = { 2: 'M12 1.5 23.5 22H.5z', 3: 'M12 .5 23.5 12 12 23.5.5 12z' };
const SIZE_PX = 34;
const TAP_PX = 24;
const NAME_PX = 40; // the middle of a feature carries its name
const AT_EDGE_M = 0.05; // the place of a crossing is rounded
const MOST_EDGES = 1500; // pairs beyond are the server's work

/** Marks of findings: [{finding, at, level, crossing: [[a, b], ...]}]; those without a place sit on their feature. */
export function marksOf(findings, draft) {
  const marks = [];
  for (const finding of findings) {
    const feature = draft.get(finding.feature_id);
    const crossing = feature && /cross/.test(finding.code) ? crossingEdges(feature, finding.at) : [];
    const place = finding.at ?? meetingOf(crossing);
    const at = place ?? (feature && placeOf(feature));
    if (!at) continue;
    marks.push({ finding, at, level: finding.level, crossing, rise: place ? 0 : NAME_PX });
  }
  return marks;
}

function placeOf(feature) {
  const parts = polygonParts(feature.geometry);
  if (parts.length) return labelPoint(parts.reduce((a, b) => (areaM2(b) > areaM2(a) ? b : a))[0]);
  const line = partsOf(feature)[0]?.[0] ?? [];
  return line[Math.floor(line.length / 2)] ?? null;
}

/** Edges that meet at the place of the finding, else every two edges of a ring that cut each other. */
function crossingEdges(feature, at) {
  const edges = partsOf(feature).flat().flatMap((ring) => [...edgesOf(ring, isArea(feature))]);
  if (at) {
    const near = edges.filter(([a, b]) => lengthM(nearestOnEdge(a, b, at), at) < AT_EDGE_M);
    if (near.length > 1) return near;
  }
  if (edges.length > MOST_EDGES) return [];
  return edges.filter(([a, b], i) => edges.some(([c, d], k) => k !== i && cuts(a, b, c, d)));
}

/** Where the first two of the edges cut each other. */
function meetingOf([first, ...others]) {
  const other = first && others.find(([c, d]) => cuts(first[0], first[1], c, d));
  if (!other) return null;
  const [[a, b], [c, d]] = [first, other];
  const [dx, dy, ex, ey] = [b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]];
  const t = ((c[0] - a[0]) * ey - (c[1] - a[1]) * ex) / (dx * ey - dy * ex);
  return [a[0] + t * dx, a[1] + t * dy];
}

function cuts(a, b, c, d) {
  const side = (p, q, r) => Math.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]));
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

/** The finding under a finger, or null. */
export function markAt(marks, toPx, [x, y]) {
  return marks.find((mark) => {
    const [mx, my] = toPx(mark.at);
    return Math.hypot(mx - x, my - mark.rise - y) <= TAP_PX;
  }) ?? null;
}

const paths = {};

export function paintCrossings(context, marks, toPx, palette) {
  context.lineCap = 'round';
  for (const { crossing } of marks) {
    for (const [a, b] of crossing) line(context, [toPx(a), toPx(b)], palette.p2, 4.5);
  }
}

export function paintMarks(context, marks, toPx, palette) {
  for (const { at, level, crossing, rise } of marks) {
    const [x, below] = toPx(at);
    const y = below - rise;
    const scale = (SIZE_PX * palette.scale) / 24;
    context.save();
    context.translate(x, y);
    context.scale(scale, scale);
    context.translate(-12, -12);
    context.fillStyle = palette[`p${level}`];
    context.strokeStyle = palette.ink;
    context.lineWidth = 1.3;
    context.lineJoin = 'miter';
    const path = (paths[level] ??= new Path2D(SHAPES[level] ?? SHAPES[3]));
    context.fill(path);
    context.stroke(path);
    context.fillStyle = palette[`onP${level}`];
    context.font = `800 13px ${palette.font}`;
    context.textAlign = 'center';
    context.textBaseline = 'alphabetic';
    context.fillText(String(level), 12, level === 2 ? 20 : 16.8);
    context.restore();
    if (crossing.length) haloText(context, 'crosses itself', x - 26 * palette.scale, y + 4, { palette, size: 15, align: 'right' });
  }
}
