// The same map on a 2D canvas, for devices without WebGL.

import { Camera, lineParts, mercPerMetre, mercX, mercY, polygonParts, DEG } from './geometry.js';
import { FramePace } from './frame_pace.js';
import { FARM_LAYERS, SURROUNDINGS, isOf } from './farm_style.js';
import { LINE_FLOATS, STAMP_WORDS } from './drawlist.js';
import { Gestures } from './gestures.js';
import { MACHINES, MARKS, hullOf } from './shapes.js';
import { unpacked } from './theme.js';

const MAX_ZOOM = 23.5;
const MIN_ZOOM = 3;
const UNIT = 1e8; // path units per mercator unit: about 0.4 m, fine enough for the path's float32 corners

export class CanvasEngine {
  kind = 'canvas';
  isFarmDrawn = true; // shapes and names are one picture here
  #pace = new FramePace();

  static async create(host, { scene, palette, view, hooks }) {
    return new CanvasEngine(host, scene, palette, view, hooks);
  }

  constructor(host, scene, palette, view, hooks) {
    this.scene = scene;
    this.palette = palette;
    this.hooks = hooks;
    this.camera = Object.assign(new Camera(), view);
    this.farm = [];
    this.mission = [];
    this.rows = [];
    this.isSurroundingsShown = true;
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'hl-map-canvas';
    this.canvas.tabIndex = 0;
    host.append(this.canvas);
    this.context = this.canvas.getContext('2d', { alpha: false, willReadFrequently: true }); // drawn by the CPU: there is no GPU to help
    this.gestures = new Gestures(this.canvas, {
      start: () => {},
      end: () => this.redraw(),
      pan: (dx, dy) => { hooks.panned(); this.#shift(-dx, -dy); },
      zoomAround: (x, y, step) => this.#around(x, y, { zoom: this.camera.zoom + step }),
      turnAround: (x, y, step) => this.#around(x, y, { bearing: this.camera.bearing + step }),
      tap: (x, y) => hooks.tapped(x, y),
    });
    this.watch = new ResizeObserver(() => this.#resize());
    this.watch.observe(host);
    this.host = host;
    this.#resize();
  }

  #resize() {
    const ratio = window.devicePixelRatio || 1;
    this.camera.width = this.host.clientWidth || 1;
    this.camera.height = this.host.clientHeight || 1;
    this.canvas.width = Math.round(this.camera.width * ratio);
    this.canvas.height = Math.round(this.camera.height * ratio);
    this.hooks.moved(false);
    this.hooks.resized?.();
    this.redraw();
  }

  #shift(dx, dy) {
    const { camera } = this;
    [camera.mx, camera.my] = camera.unproject(camera.width / 2 + dx, camera.height / 2 + dy);
    this.hooks.moved(true);
    this.redraw();
  }

  #around(x, y, change) {
    const { camera } = this;
    const [px, py] = this.isFollowing ? [camera.width / 2, camera.height / 2] : [x, y];
    const [mx, my] = camera.unproject(px, py);
    Object.assign(camera, change);
    camera.zoom = Math.min(Math.max(camera.zoom, MIN_ZOOM), MAX_ZOOM);
    const [nx, ny] = camera.project(mx, my);
    this.#shift(nx - px, ny - py);
  }

  get isBusy() {
    return this.gestures.isActive;
  }

  jump(view) {
    Object.assign(this.camera, view);
    this.camera.zoom = Math.min(Math.max(this.camera.zoom, MIN_ZOOM), MAX_ZOOM);
    this.hooks.moved(false);
    this.redraw();
  }

  ease(view) {
    this.jump(view); // no animation: this engine serves slow devices
  }

  /** Here the farm and what moves on it are one picture. */
  repaint() {
    this.redraw();
  }

  setFollowing(isFollowing) {
    this.isFollowing = isFollowing;
  }

  setFarm(collection) {
    this.farm = this.#paths(collection, 'farm');
    this.redraw();
  }

  setRows(collection) {
    this.rows = this.#paths(collection, 'rows');
    this.redraw();
  }

  setMission(collection) {
    this.mission = this.#paths(collection, 'mission');
    this.redraw();
  }

  setPalette(palette) {
    this.palette = palette;
    this.redraw();
  }

  showSurroundings(isShown) {
    this.isSurroundingsShown = isShown;
    this.redraw();
  }

  /** One Path2D per feature and layer, in path units around a local origin. */
  #paths(collection, source) {
    const paths = [];
    for (const layer of FARM_LAYERS.filter((l) => l.source === source)) {
      for (const feature of collection.features) {
        if (!isOf(layer, feature)) continue;
        paths.push({ layer, feature, ...this.#path(layer, feature) });
      }
    }
    return paths;
  }

  #path(layer, feature) {
    const origin = this.#origin(feature);
    const path = new Path2D();
    const walk = (line, isClosed) => {
      line.forEach(([lon, lat], i) => {
        const x = (mercX(lon) - origin[0]) * UNIT;
        const y = (mercY(lat) - origin[1]) * UNIT;
        if (i === 0) path.moveTo(x, y);
        else path.lineTo(x, y);
      });
      if (isClosed) path.closePath();
    };
    if (layer.shape === 'polygon') polygonParts(feature.geometry).flat().forEach((ring) => walk(ring, true));
    else if (layer.shape === 'line') lineParts(feature.geometry).forEach((line) => walk(line, false));
    return { path, origin };
  }

  #origin(feature) {
    let node = feature.geometry.coordinates;
    while (typeof node[0] !== 'number') [node] = node;
    return [mercX(node[0]), mercY(node[1])];
  }

  redraw() {
    if (this.frame) return;
    this.#pace.asked();
    this.frame = requestAnimationFrame(() => {
      this.frame = null;
      this.#draw();
      this.hooks.framed();
      this.#pace.drawn();
    });
  }

  /** Ms until this device can take another picture without falling behind. */
  waitMs() {
    return this.#pace.waitMs();
  }

  #draw() {
    const { context, camera, palette } = this;
    this.ratio = this.canvas.width / camera.width;
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.fillStyle = palette.ground;
    context.fillRect(0, 0, camera.width, camera.height);
    this.under?.(context, camera, this.ratio);
    this.turn = [Math.cos(camera.bearing * DEG), Math.sin(camera.bearing * DEG)];
    const order = new Map(FARM_LAYERS.map((layer, i) => [layer, i]));
    const all = [...this.farm, ...this.rows, ...this.mission].sort((a, b) => order.get(a.layer) - order.get(b.layer));
    for (const item of all) {
      if (!this.isSurroundingsShown && SURROUNDINGS.has(item.layer.id)) continue;
      this.#feature(item);
    }
    const { lines, stamps } = this.scene.drawList();
    for (const line of lines) this.#line(line);
    for (const batch of stamps) this.#stamps(batch);
  }

  #place(x, y, scale) {
    const { context, ratio, turn: [cos, sin] } = this;
    context.setTransform(ratio * cos * scale, -ratio * sin * scale, ratio * sin * scale, ratio * cos * scale, ratio * x, ratio * y);
  }

  #feature({ layer, feature, path, origin }) {
    const { context, camera, palette } = this;
    const perM = camera.worldPx * mercPerMetre(origin[1]);
    const [x, y] = camera.project(...origin);
    if (layer.shape === 'point') {
      context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      context.beginPath();
      context.globalAlpha = this.alphas?.area(layer.id) ?? 1;
      context.arc(x, y, Math.max((feature.properties.radius_m ?? layer.radiusM) * perM, layer.leastPx), 0, 7);
      this.#paint(layer, 1.6);
      context.globalAlpha = 1;
      return;
    }
    const scale = camera.worldPx / UNIT;
    this.#place(x, y, scale);
    if (layer.fill) {
      context.fillStyle = palette[layer.fill];
      context.globalAlpha = this.alphas?.area(layer.id) ?? 1;
      context.fill(path, 'evenodd');
      context.globalAlpha = 1;
    }
    if (!layer.line) return;
    const metres = layer.widthM ? (feature.properties.width_m ?? layer.widthM) * perM : 0;
    context.lineWidth = (Math.max(metres, layer.leastPx) + (layer.plusPx ?? 0)) / scale;
    context.setLineDash((layer.dash ?? []).map((px) => px / scale));
    context.strokeStyle = palette[layer.line];
    context.lineJoin = context.lineCap = 'round';
    context.globalAlpha = this.alphas?.line(layer.id) ?? 1;
    context.stroke(path);
    context.globalAlpha = 1;
    context.setLineDash([]);
  }

  #paint(layer, width) {
    const { context, palette } = this;
    if (layer.fill) {
      context.fillStyle = palette[layer.fill];
      context.fill();
    }
    if (!layer.line) return;
    context.strokeStyle = palette[layer.line];
    context.lineWidth = width;
    context.stroke();
  }

  #line({ set, from, count, colour, widthM = 0, leastPx = 1, dash = null }) {
    if (!count) return;
    const { context, camera, scene, ratio } = this;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.strokeStyle = unpacked(colour);
    context.lineWidth = Math.max(widthM / camera.metresPerPx, leastPx);
    context.lineCap = 'butt';
    context.lineJoin = 'round';
    context.setLineDash(dash ?? []);
    context.beginPath();
    let [endX, endY] = [NaN, NaN];
    for (let at = from * LINE_FLOATS; at < (from + count) * LINE_FLOATS; at += LINE_FLOATS) {
      const [x0, y0, x1, y1] = set.data.subarray(at, at + 4);
      if (x0 !== endX || y0 !== endY) context.moveTo(...camera.project(x0 + scene.origin.mx, y0 + scene.origin.my));
      context.lineTo(...camera.project(x1 + scene.origin.mx, y1 + scene.origin.my));
      [endX, endY] = [x1, y1];
    }
    context.stroke();
    context.setLineDash([]);
  }

  #stamps(batch) {
    const { context, camera, scene, ratio } = this;
    const perM = 1 / camera.metresPerPx;
    for (let i = 0; i < batch.count; i += 1) {
      const at = i * STAMP_WORDS;
      const [mx, my, cos, sin, wide, long, least, shift] = batch.floats.subarray(at, at + 8);
      const [x, y] = camera.project(mx + scene.origin.mx, my + scene.origin.my);
      if (x < -2000 || y < -2000 || x > camera.width + 2000 || y > camera.height + 2000) continue;
      const scale = Math.max(perM, least / Math.max(long, 0.01));
      const half = [(wide * scale) / 2, (long * scale) / 2];
      context.setTransform(ratio, 0, 0, ratio, ratio * x, ratio * y);
      context.rotate(Math.atan2(sin, cos) - camera.bearing * DEG);
      const inks = Array.from(batch.words.subarray(at + 8, at + 11), unpacked);
      if (MARKS[batch.shape]) this.#mark(MARKS[batch.shape], half, inks[0]);
      else this.#machine(batch.shape, half, shift, inks);
    }
  }

  #mark(spec, half, ink) {
    const { context } = this;
    context.beginPath();
    if (spec.points) {
      spec.points.forEach(([x, y]) => context.lineTo(x * half[0], -y * half[1]));
      context.closePath();
    } else context.arc(0, 0, half[0], 0, 2 * Math.PI);
    if (spec.kind === 'fill') {
      context.fillStyle = ink;
      context.fill();
      return;
    }
    const dash = (2 * Math.PI * half[0] * (spec.of ?? 0)) / (spec.sides ?? 1);
    context.setLineDash(spec.of ? [(dash * (spec.of - spec.gap)) / spec.of, (dash * spec.gap) / spec.of] : []);
    context.strokeStyle = ink;
    context.lineWidth = spec.width;
    context.stroke();
    context.setLineDash([]);
  }

  #machine(shape, half, shift, [fill, accent, rim]) {
    const { context } = this;
    const isGhost = shape.endsWith('-ghost');
    const { outline, arrow } = MACHINES[shape.replace(/-(ghost|small)$/, '')];
    const trace = (points) => {
      context.beginPath();
      points.forEach(([x, y]) => context.lineTo(x * half[0], -(y + shift) * half[1]));
      context.closePath();
    };
    context.strokeStyle = rim;
    context.lineWidth = isGhost ? 2.2 : 3.2;
    context.fillStyle = fill;
    const parts = shape.endsWith('-small') ? [hullOf({ outline })] : outline;
    for (const part of parts) {
      trace(part);
      if (!isGhost) context.stroke();
    }
    for (const part of parts) {
      trace(part);
      context.fill();
      if (isGhost) {
        context.setLineDash([4, 3]);
        context.stroke();
        context.setLineDash([]);
      }
    }
    if (!arrow) return;
    trace(arrow);
    context.fillStyle = accent;
    context.fill();
  }

  destroy() {
    cancelAnimationFrame(this.frame);
    this.watch.disconnect();
    this.gestures.destroy();
    this.canvas.remove();
  }
}
