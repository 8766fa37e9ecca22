// A change that is only looked at: the shapes as they would become, and a dial to turn them by.

import { DEG, labelPoint } from '../map/geometry.js';
import { dashed, disc, line } from './ink.js';
import { isArea, partsOf } from './shape.js';

const RADIUS_PX = 96;
const POINT_PX = 12;

/** Shapes of a preview, over everything: dashed, in the colour of what is chosen. */
export function paintTrial(context, features, { toPx, palette }) {
  for (const feature of features) {
    const rings = partsOf(feature).flat().map((ring) => ring.map(toPx));
    const isClosed = isArea(feature);
    if (isClosed) tint(context, rings, palette.sel);
    for (const points of rings) {
      if (points.length === 1) dashed(context, [4, 3], () => disc(context, ...points[0], POINT_PX, { fill: palette.raised, stroke: palette.sel, width: 3 }));
      line(context, points, palette.raised, 5, isClosed);
      dashed(context, [10, 6], () => line(context, points, palette.sel, 3, isClosed));
    }
  }
}

function tint(context, rings, colour) {
  context.beginPath();
  for (const ring of rings) {
    ring.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
  }
  context.globalAlpha = 0.14;
  context.fillStyle = colour;
  context.fill('evenodd');
  context.globalAlpha = 1;
}

/** The dial of a turn by `angle` degrees clockwise, as `dialOf` gives it; its knob points north at 0. */
export function turnDialOf(feature, surface, angle) {
  const [ring] = partsOf(feature)[0] ?? [];
  if (!ring || feature.geometry.type === 'Point') return null;
  const [cx, cy] = surface.toPx(isArea(feature) ? labelPoint(ring) : ring[Math.floor(ring.length / 2)]);
  const turned = (angle - surface.camera.bearing) * DEG;
  return { cx, cy, radius: RADIUS_PX, kx: cx + RADIUS_PX * Math.sin(turned), ky: cy - RADIUS_PX * Math.cos(turned), angle: turned, bearing: angle, isSet: true, isArrow: true };
}

/** Dragging that knob; `told(degrees)` hears each half degree, -180 to 180. */
export class TurnDrag {
  constructor(core, dial, told) {
    Object.assign(this, { core, dial, told });
    this.from = dial.bearing;
  }

  move([x, y]) {
    const angle = Math.atan2(x - this.dial.cx, this.dial.cy - y) / DEG + this.core.surface.camera.bearing;
    this.#tell(Math.round(angle * 2) / 2);
  }

  #tell(angle) {
    const within = ((((angle + 180) % 360) + 360) % 360) - 180;
    this.core.turning = within;
    this.core.repaint();
    this.told(within);
  }

  finish() {
    // the angle stays until it is applied or given up
  }

  tap() {
    // the knob alone says nothing
  }

  cancel() {
    this.#tell(this.from);
  }
}
