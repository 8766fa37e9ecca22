// The canvas over the map: what is selected, its handles and lengths, what is being dragged or drawn, what was found.

import { labelPoint } from '../map/geometry.js';
import { paintDial } from './dial.js';
import { paintCrossings, paintMarks } from './finding_marks.js';
import { isSame, LOOK_PX } from './handles.js';
import { dashed, disc, haloText, line, pill, square, tooltip } from './ink.js';
import { lengthM } from '../map/plane.js';
import { paintTrial } from './trial.js';
import { isArea, partsOf } from './shape.js';
import { lengthText, measureText, sizeText } from './words.js';

const BESIDE_PX = 27; // a length stands beside a short edge, where the mid-handle sits on it
const GUIDE_PX = 190; // guides reach this far past the corner

export class Overlay {
  constructor(host) {
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'hl-edit-canvas';
    this.canvas.setAttribute('aria-hidden', 'true');
    host.append(this.canvas);
    this.context = this.canvas.getContext('2d');
  }

  /** view: {camera, palette, toPx, selected, handles, chosen, drag, dial, isDialChosen, pen, marks}. */
  draw(view) {
    const { canvas, context } = this;
    const { camera, palette } = view;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    context.lineJoin = 'miter';
    context.lineCap = 'butt';
    for (const feature of view.selected) this.#outline(feature, view);
    paintCrossings(context, view.marks, view.toPx, palette);
    paintTrial(context, view.trial, view);
    if (view.drag) this.#guides(view.drag, view);
    if (view.dial && !view.drag) paintDial(context, view.dial, palette, view.isDialChosen);
    if (view.handles && !view.trial.length) this.#handles(view);
    paintMarks(context, view.marks, view.toPx, palette);
    if (view.drag) this.#drag(view.drag, view);
    if (view.pen) this.#pen(view.pen, view);
  }

  #outline(feature, { toPx, palette, camera, live, handles }) {
    const { context } = this;
    const { width_m: widthM, radius_m: radiusM } = feature.properties;
    const isClosed = isArea(feature);
    const lines = partsOf(feature).flat().map((ring) => ring.map(toPx));
    if (!isClosed && lines[0]?.length === 1) {
      const [[x, y]] = lines[0];
      const radius = Math.max((radiusM ?? 0) / camera.metresPerPx, 14);
      dashed(context, radiusM ? [4, 3] : [], () => disc(context, x, y, radius, { fill: live?.has(feature.id) ? palette.ground : null, stroke: palette.ink, width: 3 }));
      return;
    }
    if (!isClosed && live?.has(feature.id) && widthM) for (const points of lines) line(context, points, palette.road, widthM / camera.metresPerPx);
    if (!handles && isClosed) this.#tint(lines, palette);
    for (const points of lines) line(context, points, palette.ink, 3, isClosed);
  }

  /** Several selected shapes have no handles, so that their inside says it. */
  #tint(rings, palette) {
    const { context } = this;
    context.beginPath();
    for (const ring of rings) {
      ring.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.closePath();
    }
    context.globalAlpha = 0.16;
    context.fillStyle = palette.sel;
    context.fill('evenodd');
    context.globalAlpha = 1;
  }

  #handles({ handles, palette, chosen, drag }) {
    const { context } = this;
    const beside = (i) => chosen && [0, 1].some((back) => i.part === chosen.part && i.ring === chosen.ring && i.index === chosen.index - 1 + back);
    for (const edge of handles.edges) if (edge.isLabelled || (drag && beside(edge))) this.#length(edge, palette, edge.hasRoom ? 0 : BESIDE_PX);
    for (const { x, y } of handles.mids) disc(context, x, y, 5.7, { fill: palette.raised, stroke: palette.ink, width: 1.6 });
    for (const corner of handles.corners) {
      if (isSame(corner, chosen)) continue;
      square(context, corner.x, corner.y, corner.size === LOOK_PX ? 21 : 10, { fill: palette.raised, stroke: palette.ink, width: corner.size === LOOK_PX ? 2.6 : 1.6 });
    }
    const active = handles.corners.find((corner) => isSame(corner, chosen));
    if (active) this.#active(active.x, active.y, palette);
  }

  #active(x, y, palette) {
    disc(this.context, x, y, 24, { fill: palette.sel, alpha: 0.24 });
    square(this.context, x, y, LOOK_PX, { fill: palette.sel, stroke: palette.raised, width: 2.4 });
  }

  #length({ ax, ay, bx, by, a, b }, palette, aside) {
    const angle = Math.atan2(by - ay, bx - ax);
    const [dx, dy] = [Math.sin(angle) * aside, -Math.cos(angle) * aside]; // rings turn left: this side is outside
    pill(this.context, lengthText(lengthM(a, b)), (ax + bx) / 2 - dx, (ay + by) / 2 - dy, angle, palette);
  }

  #guides({ from, guides }, { toPx, palette }) {
    const { context } = this;
    for (const [start, foot] of guides) {
      const [a, b] = [toPx(start), toPx(foot)];
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      const past = [b[0] + ((b[0] - a[0]) / length) * GUIDE_PX, b[1] + ((b[1] - a[1]) / length) * GUIDE_PX];
      dashed(context, [5, 5], () => line(context, [a, past], palette.ink, 1.3));
    }
    if (!from) return;
    const [x, y] = toPx(from);
    dashed(context, [4, 3.4], () => disc(context, x, y, 7.5, { stroke: palette.ink2, width: 1.5 }));
  }

  #drag({ at, tip }, { toPx, palette, camera, selected }) {
    const [feature] = selected;
    const size = feature && sizeText(feature);
    if (size) {
      const [x, y] = toPx(labelPoint(partsOf(feature)[0][0]));
      haloText(this.context, size, x, y, { palette, size: 22, weight: 700 });
    }
    tooltip(this.context, tip, toPx(at), palette, camera);
  }

  #pen(pen, view) {
    const { context } = this;
    const { toPx, palette, camera } = view;
    const { points, next, shape } = pen;
    if (pen.finished) this.#measured(pen.finished, view);
    const places = points.map(toPx);
    if (shape === 'circle' && places.length) {
      this.#circle(places[0], next, view);
      return;
    }
    if (next) this.#guides({ guides: next.lines }, view);
    if (places.length) line(context, places, palette.ink, 3);
    if (next && places.length) dashed(context, [8, 6], () => line(context, [places.at(-1), toPx(next.position)], palette.ink, 2.4));
    const tail = next ? toPx(next.position) : places.at(-1);
    if (shape === 'area' && points.length > 1) dashed(context, [2, 6], () => line(context, [tail, places[0]], palette.ink2, 1.4));
    this.#lengths(points, toPx, palette);
    if (next && points.length && !next.isClosing) this.#lengths([points.at(-1), next.position], toPx, palette);
    const canClose = (shape === 'area' || pen.tool === 'measure') && points.length >= 3;
    places.forEach(([x, y], i) => {
      if (i === 0 && canClose) disc(context, x, y, 24, { fill: palette.sel, alpha: next?.isClosing ? 0.4 : 0.2 });
      square(context, x, y, 21, { fill: palette.raised, stroke: palette.ink, width: 2.6 });
    });
    if (!next) return;
    const [x, y] = toPx(next.position);
    if (!next.isClosing) this.#active(x, y, palette);
    if (next.tip.length) tooltip(context, next.tip, [x, y], palette, camera);
  }

  #circle([x, y], next, { toPx, palette, camera }) {
    const { context } = this;
    if (next) {
      const [ex, ey] = toPx(next.position);
      disc(context, x, y, Math.hypot(ex - x, ey - y), { fill: palette.sel, stroke: null, alpha: 0.16 });
      dashed(context, [8, 6], () => disc(context, x, y, Math.hypot(ex - x, ey - y), { stroke: palette.ink, width: 3 }));
      line(context, [[x, y], [ex, ey]], palette.ink, 1.6);
      tooltip(context, next.tip, [ex, ey], palette, camera);
    }
    square(context, x, y, 21, { fill: palette.raised, stroke: palette.ink, width: 2.6 });
  }

  #lengths(points, toPx, palette) {
    for (let i = 0; i + 1 < points.length; i += 1) {
      const [[ax, ay], [bx, by]] = [toPx(points[i]), toPx(points[i + 1])];
      if (Math.hypot(bx - ax, by - ay) > 96) this.#length({ ax, ay, bx, by, a: points[i], b: points[i + 1] }, palette, 0);
    }
  }

  #measured({ points, isClosed }, { toPx, palette, camera }) {
    const places = points.map(toPx);
    line(this.context, places, palette.ink, 3, isClosed);
    this.#lengths(isClosed ? [...points, points[0]] : points, toPx, palette);
    for (const [x, y] of places) disc(this.context, x, y, 6, { fill: palette.raised, stroke: palette.ink, width: 2 });
    const text = measureText(isClosed ? [...points, points[0]] : points, isClosed);
    tooltip(this.context, text.split(', '), places.at(-1), palette, camera);
  }

  destroy() {
    this.canvas.remove();
  }
}
