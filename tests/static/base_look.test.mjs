// A photo below the map must leave its lines readable: in each theme, over the darkest and the brightest pixel.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { areaAlpha, strong, veil, wash } from '../../static/js/map/base_look.js';

const css = readFileSync(new URL('../../static/css/tokens.css', import.meta.url), 'utf8');
const root = { dataset: {} };
globalThis.document = { documentElement: root };

function token(theme, name) {
  const block = css.slice(css.indexOf(`[data-theme="${theme}"]`));
  const hex = new RegExp(`${name}:\\s*#([0-9a-f]{6})`).exec(block)[1];
  return [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

function luminance(rgb) {
  const [r, g, b] = rgb.map((value) => value / 255).map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

const contrast = (one, other) => {
  const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
};

const washed = (colour) => {
  const pixels = Uint8ClampedArray.from([...colour, 255]);
  wash(pixels, veil());
  return [...pixels.slice(0, 3)];
};

for (const theme of ['day', 'night', 'sunlight']) {
  test(`path, edges and plan stand out of any photo in the theme ${theme}`, () => {
    root.dataset.theme = theme;
    const ground = token(theme, '--hl-m-ground');
    const { opacity } = veil();
    const lines = strong({ path: token(theme, '--hl-m-path'), ink: token(theme, '--hl-ink'), ink2: token(theme, '--hl-ink-2'), plan: token(theme, '--hl-m-plan') });
    for (const pixel of [[0, 0, 0], [255, 255, 255], [70, 95, 48], [30, 60, 25]]) {
      const seen = washed(pixel).map((value, i) => value * opacity + ground[i] * (1 - opacity));
      for (const name of ['path', 'edge', 'plan']) assert.ok(contrast(lines[name], seen) >= 3, `${name} over ${pixel}: ${contrast(lines[name], seen).toFixed(2)}`);
    }
  });
}

test('washing takes colour out but leaves red redder than blue', () => {
  root.dataset.theme = 'day';
  const [r, g, b] = washed([220, 40, 40]);
  assert.ok(r > b + 40 && g === b);
});

test('fields stay a breath, what the photo shows itself is clear', () => {
  assert.ok(areaAlpha('parcel') > 0 && areaAlpha('parcel') < 0.3);
  assert.equal(areaAlpha('tree-area'), 0);
  assert.equal(areaAlpha('anything else'), 1);
});
