// How a picture lies under the map: washed out, so that lines, robots and alarms stay what is seen first.

/** opacity over the ground; saturation as MapLibre takes it; brightness that black and white become. */
const VEILS = {
  day: { opacity: 0.72, saturation: -0.4, low: 0.47, high: 1 },
  night: { opacity: 0.8, saturation: -0.5, low: 0, high: 0.4 },
  sunlight: { opacity: 0.7, saturation: -0.55, low: 0.5, high: 1 },
};

/** What the picture shows by itself needs no area over it; fields keep a breath of theirs. */
const FILLS = {
  'water-area': 0, 'tree-area': 0, 'tree-point': 0.35, 'road-area': 0.25, building: 0.2, parcel: 0.14,
  'mission-parcel': 0.2, 'no-go': 0.35, obstacle: 0.35, 'edit-headland': 0.3, 'edit-plain': 0.2,
};
const LINES = { 'tree-line': 0.35, 'water-line': 0.35, 'road-line': 0.5, 'road-casing': 0.6, rows: 0, 'edit-bed': 0.25 };

const theme = () => document.documentElement.dataset.theme || 'day';

export const veil = () => VEILS[theme()] ?? VEILS.day;
export const areaAlpha = (id) => FILLS[id] ?? 1;
export const lineAlpha = (id) => LINES[id] ?? 1;

/** The palette with the fine lines strong enough for a picture below them. */
export const strong = (palette) => ({ ...palette, edge: palette.ink, plan: palette.ink2, row: palette.plan });

/** Wash the pixels [r, g, b, a, ...] of a tile as MapLibre's raster layer does. */
export function wash(pixels, { saturation, low, high }) {
  const span = high - low;
  for (let i = 0; i < pixels.length; i += 4) {
    const mean = (pixels[i] + pixels[i + 1] + pixels[i + 2]) / 3;
    for (let c = i; c < i + 3; c += 1) pixels[c] = (pixels[c] - (mean - pixels[c]) * saturation) * span + low * 255;
  }
}
