// Outlines of machines and marks in body units: x right, y forward, the machine's box is [-1, 1] x [-1, 1].
// Concave outlines start at their notch, so that a fan from the first point fills them.

const rect = (x0, y0, x1, y1) => [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
const scaled = (points, sx, sy) => points.map(([x, y]) => [x / sx, y / sy]);
const ARROW = [[0, -1.6], [5.4, -4.5], [0, 7.5], [-5.4, -4.5]];
const OCTAGON = Array.from({ length: 8 }, (_, i) => {
  const angle = ((i + 0.5) * Math.PI) / 4;
  return [Math.sin(angle), Math.cos(angle)];
});

/** nominal: half width and half length in px, in which pixel-wide outlines are worked out. */
export const MACHINES = {
  weeder: {
    nominal: [14, 12],
    outline: [rect(-14 / 14, -1, -9.6 / 14, 1), rect(9.6 / 14, -1, 1, 1), rect(-9 / 14, -1, 9 / 14, 1)],
    arrow: scaled(ARROW, 14, 12),
  },
  planter: {
    nominal: [16, 13],
    outline: [rect(-1, -12 / 13, -11.6 / 16, 12 / 13), rect(11.6 / 16, -12 / 13, 1, 12 / 13), rect(-11 / 16, -1, 11 / 16, 1)],
    arrow: scaled(ARROW, 16, 13),
  },
  uav: { nominal: [12, 14], outline: [[[0, -0.45], [1, -1], [0, 1], [-1, -1]]], arrow: null },
  other: { nominal: [11, 13], outline: [rect(-1, -1, 1, 1)], arrow: scaled(ARROW, 12, 13) },
};

/** Round and angular marks; widths in px. Dashed rings leave `gap` of every `of` pieces out. */
export const MARKS = {
  disc: { kind: 'fill', sides: 64 },
  ring: { kind: 'ring', sides: 72, width: 1.8 },
  'ring-heavy': { kind: 'ring', sides: 96, width: 3.5 },
  'ring-dash': { kind: 'ring', sides: 120, width: 3, of: 5, gap: 2 },
  'ring-thin-dash': { kind: 'ring', sides: 72, width: 2.2, of: 4, gap: 2 },
  octagon: { kind: 'fill', points: OCTAGON },
  'octagon-edge': { kind: 'edge', points: OCTAGON, width: 2.6 },
};

/** Outline of a machine in a crowd: one part, few corners. */
export const hullOf = ({ outline }) => (outline.length > 1 ? rect(-1, -1, 1, 1) : outline[0]);

export const familyShape = (family) => (family in MACHINES ? family : 'other');

/** Every shape name a stamp can have, in drawing order. */
export const SHAPE_ORDER = [
  'disc', 'octagon', 'octagon-edge', 'ring-thin-dash', 'ring-dash', 'ring-heavy', 'ring',
  ...Object.keys(MACHINES).flatMap((name) => [`${name}-small`, name, `${name}-ghost`]),
];
