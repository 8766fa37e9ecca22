// The row direction of a parcel as a dial: a knob to drag, half a degree a step.

import { DEG, areaM2, labelPoint } from '../map/geometry.js';
import { bearingDeg, lengthM } from '../map/plane.js';
import { edgesOf, isArea, partsOf } from './shape.js';
import { degreesText } from './words.js';
import { dashed, disc, haloText, line } from './ink.js';

export const STEP_DEG = 0.5;
const RADIUS_PX = [56, 131];
const SHARE = 0.3; // of the smaller side of the parcel on the screen
const LEAST_SIDE_PX = 150; // smaller parcels have no room for a dial
const HOME_PX = 84; // clear of the home's own handle
const KNOB_PX = 19;
const REACH_PX = 24;

export const inTurn = (degrees) => ((degrees % 360) + 360) % 360;
const stepped = (degrees) => inTurn(Math.round(degrees / STEP_DEG) * STEP_DEG);

/** Row direction of a parcel; without one, the direction of its longest edge as a proposal. */
export function rowBearing(feature) {
  const set = feature.properties?.row_bearing_deg;
  if (Number.isFinite(set)) return { bearing: set, isSet: true };
  let best = [0, 0];
  for (const [a, b] of edgesOf(partsOf(feature)[0][0], true)) {
    const length = lengthM(a, b);
    if (length > best[0]) best = [length, bearingDeg(a, b)];
  }
  return { bearing: stepped(best[1] % 180), isSet: false };
}

const isHome = (feature) => feature?.properties?.kind === 'home' && feature.geometry.type === 'Point';

/** What the dial of a feature shows, degrees clockwise from north: rows of a parcel, or which way a robot stands at home. */
export function bearingOf(feature) {
  if (!isHome(feature)) return rowBearing(feature);
  const heading = feature.properties.heading_deg; // kept counter-clockwise from east
  return Number.isFinite(heading) ? { bearing: inTurn(90 - heading), isSet: true } : { bearing: 0, isSet: false };
}

export const withBearing = (feature, degrees) => ({
  ...feature, properties: { ...feature.properties, ...(isHome(feature) ? { heading_deg: inTurn(90 - stepped(degrees)) } : { row_bearing_deg: stepped(degrees) }) },
});

/** Label of a change of direction. */
export function turnText(before, after) {
  const to = degreesText(bearingOf(after).bearing);
  const { bearing, isSet } = bearingOf(before);
  const word = isHome(after) ? 'Heading' : 'Row direction';
  return isSet ? `${word} ${degreesText(bearing)} to ${to}` : `${word} ${to}`;
}

const isSame = (a, b) => bearingOf(a).isSet === bearingOf(b).isSet && bearingOf(a).bearing === bearingOf(b).bearing;

/** {cx, cy, radius, kx, ky, bearing, isSet} in px, or null where there is nothing to turn or no room. */
export function dialOf(feature, surface) {
  if (isHome(feature)) return around(feature, surface, surface.toPx(partsOf(feature)[0][0][0]), HOME_PX, true);
  if (feature?.properties?.kind !== 'parcel' || !isArea(feature)) return null;
  const rings = partsOf(feature).reduce((a, b) => (areaM2(b) > areaM2(a) ? b : a)); // the largest part
  const places = rings[0].map((position) => surface.toPx(position));
  const side = (axis) => Math.max(...places.map((p) => p[axis])) - Math.min(...places.map((p) => p[axis]));
  const least = Math.min(side(0), side(1));
  if (least < LEAST_SIDE_PX) return null;
  const radius = Math.min(Math.max(least * SHARE, RADIUS_PX[0]), RADIUS_PX[1]);
  return around(feature, surface, surface.toPx(labelPoint(rings[0])), radius, false);
}

function around(feature, surface, [cx, cy], radius, isArrow) {
  const { bearing, isSet } = bearingOf(feature);
  const angle = (bearing - surface.camera.bearing) * DEG;
  return { cx, cy, radius, kx: cx + radius * Math.sin(angle), ky: cy - radius * Math.cos(angle), angle, bearing, isSet, isArrow };
}

export const isOnKnob = (dial, [x, y]) => Boolean(dial) && Math.hypot(dial.kx - x, dial.ky - y) <= REACH_PX;

export class DialDrag {
  constructor(core, id, dial) {
    this.core = core;
    this.id = id;
    this.dial = dial;
    this.before = core.draft.get(id);
    core.chooseDial();
  }

  move([x, y]) {
    const angle = Math.atan2(x - this.dial.cx, this.dial.cy - y) / DEG;
    this.live = withBearing(this.before, angle + this.core.surface.camera.bearing);
    this.core.show(this.id, this.live);
  }

  finish() {
    const { core, id, before, live } = this;
    if (isSame(live, before)) core.show(id, null);
    else core.commit(turnText(before, live), [{ id, before, after: live }]);
  }

  tap() {
    // the knob is chosen: arrow keys turn it
  }

  cancel() {
    this.core.show(this.id, null);
  }
}

/** Draw the dial as on the drawing board: circle, north line, bar through the middle, knob. */
export function paintDial(context, dial, palette, isChosen) {
  const { cx, cy, radius, kx, ky, angle, bearing, isSet, isArrow } = dial;
  dashed(context, [3.5, 8.5], () => {
    context.beginPath();
    context.arc(cx, cy, radius, 0, 2 * Math.PI);
    context.strokeStyle = palette.ink;
    context.lineWidth = 1.2;
    context.stroke();
  });
  dashed(context, [5, 5], () => line(context, [[cx, cy], [cx, cy - radius]], palette.ink2, 1.2));
  dashed(context, isSet ? [] : [8, 6], () => line(context, [isArrow ? [cx, cy] : [2 * cx - kx, 2 * cy - ky], [kx, ky]], palette.ink, 3));
  if (isChosen) disc(context, kx, ky, 26, { fill: palette.sel, alpha: 0.22 });
  disc(context, kx, ky, KNOB_PX, { fill: palette.raised, stroke: palette.ink, width: 2.6 });
  context.save();
  context.translate(kx, ky);
  context.rotate(angle);
  line(context, [[-7, 4], [0, -5], [7, 4]], palette.ink, 2.4);
  context.restore();
  disc(context, cx, cy, 5.5, { fill: palette.ink });
  // beside the bar, half way to the knob: at the rim and outside stand corners and lengths of the field
  const aside = 16 + 24 * Math.abs(Math.cos(angle));
  const [x, y] = [(cx + kx) / 2 + Math.cos(angle) * aside, (cy + ky) / 2 + Math.sin(angle) * aside];
  if (isSet) haloText(context, degreesText(bearing), x, y, { palette, size: 18, weight: 700, align: 'center' });
  else haloText(context, 'Row direction not set', cx, cy + radius * 0.55, { palette, size: 14, weight: 650, align: 'center' });
}
