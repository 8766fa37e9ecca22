// A base map of pictures on the 2D canvas, for devices without WebGL.

import { DEG, viewBox } from './geometry.js';
import { areaAlpha, lineAlpha, veil, wash } from './base_look.js';

const KEPT = 60; // washed tiles; 1 MB each at 512 px
const MOST_AT_ONCE = 48;

export class CanvasBase {
  /** hear: {loaded(), failed(status)}. */
  constructor(engine, spec, hear) {
    this.engine = engine;
    this.spec = spec;
    this.hear = hear;
    this.tiles = new Map();
  }

  show() {
    this.engine.under = (context, camera, ratio) => this.#draw(context, camera, ratio);
    this.engine.redraw();
  }

  /** Whether the farm's areas make way for the picture. */
  cover(isCovered) {
    this.engine.alphas = isCovered ? { area: areaAlpha, line: lineAlpha } : null;
    this.engine.redraw();
  }

  repaint() {
    this.tiles.clear(); // washed for another theme
    this.engine.redraw();
  }

  retry() {
    const failed = [...this.tiles].filter(([, tile]) => tile.hasFailed);
    if (!failed.length) this.hear.loaded();
    for (const [key] of failed) this.tiles.delete(key);
    this.engine.redraw();
  }

  destroy() {
    this.isGone = true;
    this.engine.under = null;
    this.engine.alphas = null;
    this.engine.redraw();
  }

  #draw(context, camera, ratio) {
    const { tilePx, minZoom, maxZoom, box } = this.spec;
    const own = Math.round(camera.zoom + Math.log2(512 / tilePx));
    if (own < minZoom) return;
    const zoom = Math.min(own, maxZoom);
    const count = 2 ** zoom;
    const [x0, y0, x1, y1] = box ?? [0, 0, 1, 1];
    const [a, b, c, d] = viewBox(camera);
    const first = [Math.floor(Math.max(a, x0, 0) * count), Math.floor(Math.max(b, y0, 0) * count)];
    const last = [Math.ceil(Math.min(c, x1, 1) * count), Math.ceil(Math.min(d, y1, 1) * count)];
    if ((last[0] - first[0]) * (last[1] - first[1]) > MOST_AT_ONCE) return;
    context.globalAlpha = veil().opacity;
    for (let y = first[1]; y < last[1]; y += 1) {
      for (let x = first[0]; x < last[0]; x += 1) this.#tile(context, camera, ratio, zoom, x, y);
    }
    context.globalAlpha = 1;
  }

  #tile(context, camera, ratio, zoom, x, y) {
    const picture = this.#picture(zoom, x, y);
    if (!picture) return;
    const edge = camera.worldPx / 2 ** zoom;
    const [px, py] = camera.project(x / 2 ** zoom, y / 2 ** zoom);
    if (camera.bearing) {
      const [cos, sin] = [Math.cos(camera.bearing * DEG) * ratio, Math.sin(camera.bearing * DEG) * ratio];
      context.setTransform(cos, -sin, sin, cos, ratio * px, ratio * py);
      context.drawImage(picture, 0, 0, edge, edge);
      return;
    }
    // on whole pixels, so that clear tiles neither overlap nor leave a seam
    const at = [px, py, px + edge, py + edge].map((value) => Math.round(value * ratio));
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(picture, at[0], at[1], at[2] - at[0], at[3] - at[1]);
  }

  #picture(zoom, x, y) {
    const key = `${zoom}/${x}/${y}`;
    let tile = this.tiles.get(key);
    if (tile) this.tiles.delete(key); // the newest are last
    else tile = this.#load(zoom, x, y);
    this.tiles.set(key, tile);
    while (this.tiles.size > KEPT) this.tiles.delete(this.tiles.keys().next().value);
    return tile.picture;
  }

  #load(zoom, x, y) {
    const tile = { picture: null, hasFailed: false };
    const image = new Image();
    image.crossOrigin = 'anonymous';
    image.onload = () => {
      if (this.isGone) return;
      tile.picture = washed(image);
      this.hear.loaded();
      this.engine.redraw();
    };
    image.onerror = () => {
      tile.hasFailed = true;
      if (!this.isGone) this.hear.failed(0);
    };
    image.src = this.spec.url.replace('{z}', zoom).replace('{x}', x).replace('{y}', y);
    return tile;
  }
}

function washed(image) {
  const canvas = document.createElement('canvas');
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  const data = context.getImageData(0, 0, canvas.width, canvas.height);
  wash(data.data, veil());
  context.putImageData(data, 0, 0);
  return canvas;
}
