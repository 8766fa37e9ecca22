// Colours and type of the map, read from the design tokens, so that the map follows the theme.

const TOKENS = {
  ground: '--hl-m-ground', parcel: '--hl-m-parcel', parcelOn: '--hl-m-parcel-on', edge: '--hl-m-edge',
  headland: '--hl-m-headland', row: '--hl-m-row', done: '--hl-m-done', path: '--hl-m-path', plan: '--hl-m-plan',
  road: '--hl-m-road', roadEdge: '--hl-m-road-edge', tree: '--hl-m-tree', water: '--hl-m-water',
  building: '--hl-m-build', label: '--hl-m-label', halo: '--hl-m-halo', obstacle: '--hl-m-obst',
  ink: '--hl-ink', ink2: '--hl-ink-2', raised: '--hl-raised', sel: '--hl-sel', onSel: '--hl-on-sel',
  manual: '--hl-manual', onManual: '--hl-on-manual',
  p1: '--hl-p1', onP1: '--hl-on-p1', p2: '--hl-p2', onP2: '--hl-on-p2',
  p3: '--hl-p3', onP3: '--hl-on-p3', p4: '--hl-p4', onP4: '--hl-on-p4',
};

// A missing token must be seen as missing style, not as a broken map.
const UNKNOWN_COLOUR = 'gray';

/** Read the palette of the current theme: colour names to CSS colours, plus `font` and `scale`. */
export function readPalette(root = document.documentElement) {
  const style = getComputedStyle(root);
  const palette = {};
  for (const [name, token] of Object.entries(TOKENS)) {
    palette[name] = style.getPropertyValue(token).trim() || UNKNOWN_COLOUR;
  }
  palette.font = style.getPropertyValue('--hl-font').trim() || 'sans-serif';
  palette.scale = parseFloat(style.getPropertyValue('--hl-scale')) || 1;
  return palette;
}

/** Call `changed(palette)` whenever the theme changes; returns a function that stops watching. */
export function watchTheme(changed, root = document.documentElement) {
  const observer = new MutationObserver(() => changed(readPalette(root)));
  observer.observe(root, { attributes: true, attributeFilter: ['data-theme'] });
  return () => observer.disconnect();
}

const parsed = new Map();
let probe = null;

/** CSS colour -> [r, g, b, a], 0..255; cached, because it goes through a 2D context. */
export function rgba(css) {
  let value = parsed.get(css);
  if (value) return value;
  if (!probe) {
    const canvas = document.createElement('canvas');
    canvas.width = canvas.height = 1;
    probe = canvas.getContext('2d', { willReadFrequently: true });
  }
  probe.clearRect(0, 0, 1, 1);
  probe.fillStyle = css;
  probe.fillRect(0, 0, 1, 1);
  value = Array.from(probe.getImageData(0, 0, 1, 1).data);
  parsed.set(css, value);
  return value;
}

/** CSS colour and alpha (0..1) -> one little-endian RGBA word, as the GL layer uploads it. */
export function packed(css, alpha = 1) {
  const [r, g, b, a] = rgba(css);
  return ((Math.round(a * alpha) << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

/** The packed word back to a CSS colour, for the 2D canvas. */
export function unpacked(word) {
  return `rgba(${word & 255},${(word >> 8) & 255},${(word >> 16) & 255},${((word >>> 24) / 255).toFixed(3)})`;
}

/** `share` of `over` painted on `under`, as an opaque CSS colour: no dark dots where line pieces overlap. */
export function mixed(over, under, share) {
  const [a, b] = [rgba(over), rgba(under)];
  const part = (i) => Math.round(a[i] * share + b[i] * (1 - share));
  return `rgb(${part(0)},${part(1)},${part(2)})`;
}
