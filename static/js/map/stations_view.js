// What the map of field stations adds: a sign for each by kind and state, and its name. Same interface as FleetView.

import { mercX, mercY } from './geometry.js';

const WAYS = 12; // around a place that is taken
const TAP_PX = 34; // a gloved finger
const HALF_PX = 17;
const SIGN_BOX = 24; // units the pictures of the kinds are drawn in
const PICTURE_SHARE = 0.62; // of the sign's width
const EDGE_PX = 60;
const NARROW_PX = 520;
const BUTTONS_SHARE = 1.2; // of what the stations take up
const DASH = [4, 3];

export class View {
  /** map: the LiveMap it belongs to. */
  constructor(map) {
    this.map = map;
    this.isOn = true;
    this.isOutgrown = false;
    this.said = null;
    this.spots = [];
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'hl-map-labels';
    this.canvas.setAttribute('aria-hidden', 'true');
    map.labelLayer.canvas.before(this.canvas); // names stand over the signs
    this.context = this.canvas.getContext('2d');
  }

  /** How many stations have a place; from then on the view is left alone. */
  get placed() {
    return this.spots.length;
  }

  /** [lon, lat] of every station; on a narrow map also a place to the right of them, so that none lies under the buttons. */
  places() {
    const places = this.spots.map(({ lon, lat }) => [lon, lat]);
    if (!places.length || this.map.host.clientWidth >= NARROW_PX) return places;
    const lons = places.map(([lon]) => lon);
    const [west, east] = [Math.min(...lons), Math.max(...lons)];
    return [...places, [east + (east - west) * BUTTONS_SHARE, places[0][1]]];
  }

  /**
   * Take what the list says: {stations: [{id, name, kind, state, lat, lon, isOver, isChosen}], pictures: {kind: SVG path}}.
   *
   * Returns 'now' when the map looks different, else ''.
   */
  set(said) {
    const before = this.said?.key;
    said.key = JSON.stringify(said.stations);
    this.said = said;
    if (before === said.key) return '';
    this.pictures = Object.fromEntries(Object.entries(said.pictures).map(([kind, path]) => [kind, new Path2D(path)]));
    this.spots = said.stations.filter((one) => Number.isFinite(one.lat) && Number.isFinite(one.lon))
      .map((one) => ({ ...one, mx: mercX(one.lon), my: mercY(one.lat) }));
    return 'now';
  }

  settle() {}

  gather() {}

  single() {
    return [];
  }

  /** Draw the signs; returns the names, and what keeps other texts off the signs. */
  drawClusters(camera, palette) {
    const { canvas, context } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    const half = HALF_PX * palette.scale;
    const [top, right, bottom, left] = this.map.controls.freePx(half + 6);
    this.at = apart(this.spots.map((spot) => camera.project(spot.mx, spot.my)), half * 2 + 4, [left, top, camera.width - right, camera.height - bottom]);
    const order = this.spots.map((spot, i) => ({ spot, at: this.at[i] })).sort((a, b) => (a.spot.isChosen ? 1 : 0) - (b.spot.isChosen ? 1 : 0)); // the chosen one on top
    for (const { at } of order) if (at.dx || at.dy) this.#stalk(at, palette);
    for (const { spot, at } of order) this.#sign(spot, at.x, at.y, palette);
    return order.flatMap(({ spot, at }) => labelsOf(spot, at.dx || at.dy ? camera.unproject(at.x, at.y) : [spot.mx, spot.my], palette));
  }

  /** From a sign that had to make room to where its station stands. */
  #stalk({ x, y, dx, dy }, palette) {
    const { context } = this;
    context.beginPath();
    context.moveTo(x - dx, y - dy);
    context.lineTo(x, y);
    context.lineWidth = 3;
    context.strokeStyle = palette.ink;
    context.stroke();
  }

  #sign(spot, x, y, palette) {
    const { context } = this;
    const half = HALF_PX * palette.scale;
    if (spot.isChosen) {
      trace(context, 'never', x, y, half + 7);
      context.lineWidth = 4;
      context.strokeStyle = palette.sel;
      context.stroke();
    }
    const look = lookOf(spot, palette);
    trace(context, spot.state, x, y, half);
    context.lineJoin = 'round';
    context.setLineDash([]);
    context.strokeStyle = palette.halo;
    context.lineWidth = 6;
    context.stroke();
    context.fillStyle = look.fill;
    context.fill();
    context.strokeStyle = look.line;
    context.lineWidth = 2.5;
    context.setLineDash(spot.state === 'never' ? DASH : []);
    context.stroke();
    context.setLineDash([]);
    this.#picture(spot.kind, x, y, half * 2 * PICTURE_SHARE * (spot.state === 'silent' ? 0.86 : 1), look.ink);
    if (spot.state === 'late') clock(context, x + half * 0.8, y - half * 0.8, palette);
    if (spot.isOver) over(context, x - half * 0.85, y - half * 0.85, palette);
  }

  #picture(kind, x, y, size, ink) {
    const { context } = this;
    const path = this.pictures[kind];
    if (!path) return;
    context.save();
    context.translate(x - size / 2, y - size / 2);
    context.scale(size / SIGN_BOX, size / SIGN_BOX);
    context.fillStyle = ink;
    context.fill(path, 'evenodd');
    context.restore();
  }

  /** Bring a station into sight. */
  show(id) {
    const spot = this.spots.find((one) => one.id === id);
    const { engine } = this.map;
    if (!spot || !engine) return;
    const { camera } = engine;
    const [x, y] = camera.project(spot.mx, spot.my);
    const isInSight = x > EDGE_PX && y > EDGE_PX && x < camera.width - EDGE_PX && y < camera.height - EDGE_PX;
    if (!isInSight) engine.ease({ mx: spot.mx, my: spot.my });
  }

  tapped(x, y) {
    const far = this.at?.map((at) => Math.hypot(at.x - x, at.y - y)) ?? [];
    const nearest = far.indexOf(Math.min(...far));
    const hit = far[nearest] < TAP_PX * this.map.palette.scale ? this.spots[nearest].id : null;
    if (hit) window.dispatchEvent(new CustomEvent('headland:map-station', { detail: hit }));
  }

  destroy() {
    this.canvas.remove();
  }
}

/**
 * Where signs go so that none lies on another: {x, y, dx, dy}, moved from its place by so many px; as near as there is
 * room, and within [left, top, right, bottom] if the place itself is.
 */
export function apart(places, leastPx, [left, top, right, bottom]) {
  const put = [];
  const isWithin = (x, y) => x >= left && x <= right && y >= top && y <= bottom;
  for (const [x, y] of places) {
    const isHeld = isWithin(x, y);
    const isFree = (at) => (!isHeld || isWithin(at.x, at.y)) && put.every((one) => Math.hypot(one.x - at.x, one.y - at.y) >= leastPx);
    put.push(around(x, y, (leastPx * 1.001) / 2, places.length + 2).find(isFree) ?? { x, y, dx: 0, dy: 0 });
  }
  return put;
}

/** The place itself, then places on wider and wider rings around it. */
function around(x, y, stepPx, rings) {
  const found = [{ x, y, dx: 0, dy: 0 }];
  for (let ring = 1; ring <= rings; ring += 1) {
    for (let turn = 0; turn < WAYS; turn += 1) {
      const [dx, dy] = [Math.cos, Math.sin].map((of) => ring * stepPx * of((2 * Math.PI * turn) / WAYS));
      found.push({ x: x + dx, y: y + dy, dx, dy });
    }
  }
  return found;
}

/** Colours by state: only what does not report, or is over its limit, has one. */
function lookOf({ state }, palette) {
  if (state === 'silent') return { fill: palette.p3, line: palette.ink, ink: palette.onP3 };
  if (state === 'never') return { fill: palette.raised, line: palette.ink2, ink: palette.ink2 };
  if (state === 'late') return { fill: palette.raised, line: palette.ink, ink: palette.ink };
  return { fill: palette.sel, line: palette.sel, ink: palette.onSel };
}

/** The outline tells the state without its colour: disc, diamond when silent, square while never heard. */
function trace(context, state, x, y, half) {
  context.beginPath();
  if (state === 'silent') [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]].forEach(([sx, sy]) => context.lineTo(x + sx * half, y + sy * half));
  else if (state === 'never') context.roundRect(x - half * 0.95, y - half * 0.95, half * 1.9, half * 1.9, 4);
  else context.arc(x, y, half, 0, 7);
  context.closePath();
}

function clock(context, x, y, palette) {
  const radius = 8 * palette.scale;
  context.beginPath();
  context.arc(x, y, radius, 0, 7);
  context.fillStyle = palette.ink;
  context.fill();
  context.strokeStyle = palette.halo;
  context.lineWidth = 2;
  context.stroke();
  context.beginPath();
  context.moveTo(x, y - radius * 0.6);
  context.lineTo(x, y);
  context.lineTo(x + radius * 0.5, y);
  context.stroke();
}

function over(context, x, y, palette) {
  const half = 8 * palette.scale;
  context.beginPath();
  [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]].forEach(([sx, sy]) => context.lineTo(x + sx * half, y + sy * half));
  context.closePath();
  context.strokeStyle = palette.halo;
  context.lineWidth = 4;
  context.stroke();
  context.fillStyle = palette.p3;
  context.fill();
  context.fillStyle = palette.onP3;
  context.font = `800 ${10 * palette.scale}px ${palette.font}`;
  context.fillText('3', x - context.measureText('3').width / 2, y + 3.6 * palette.scale);
}

const SAID = { late: 'late', silent: 'silent', never: 'never heard' };

function labelsOf(spot, [mx, my], palette) {
  const at = { mx, my };
  const half = HALF_PX * palette.scale;
  const lines = [{ text: spot.name, size: 13, weight: 650 }];
  if (SAID[spot.state]) lines.push({ text: SAID[spot.state], size: 12, weight: 560 });
  return [
    { ...at, lines: [], clearPx: HALF_PX + 2, priority: 95 },
    { ...at, lines, dx: half + (spot.isChosen ? 18 : spot.state === 'silent' ? 16 : 11), align: 'left', pill: { fill: palette.halo, ink: palette.label }, priority: spot.isChosen ? 99 : spot.state === 'fresh' ? 60 : 80, isWhole: true },
  ];
}
