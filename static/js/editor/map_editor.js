// The drawing surface of the map builder. It changes nothing but its own copy of the draft: every change leaves by
// `onChange`, one per gesture, also a new feature (`before` null; `onDrawn` names it then). Holes and cuts leave by
// `onDrawn({tool, coordinates, target})`, because the server cuts.

import { BodyDrag } from './body_drag.js';
import { CornerDrag } from './corner_drag.js';
import { CirclePen, CirclePress } from './circle_pen.js';
import { DialDrag, isOnKnob, turnText, withBearing } from './dial.js';
import { drawnOf } from './drawn.js';
import { handleAt } from './handles.js';
import { Keyboard } from './keyboard.js';
import { markAt } from './finding_marks.js';
import { nudgeOf } from './nudge.js';
import { PENS, Pen, PenPress } from './pen.js';
import { kept } from '../map/plane.js';
import { Pointer } from './pointer.js';
import { cornerName, isArea, moved, partsOf, rebuilt, removed } from './shape.js';
import { sitesOf } from './sites.js';
import { TurnDrag } from './trial.js';
import { kindWord } from './words.js';
import { Workbench } from './workbench.js';

const REACH_PX = 12; // beside a line or a point
const NO_WEBGL = 'Drawing needs WebGL. This device shows the map only.';
const HEARD = ['onSelect', 'onChange', 'onMeasure', 'onDrawn', 'onPoint', 'onNotice', 'onTurn'];

export class MapEditor {
  #tool = 'select';
  #held = null; // what arrow keys move until they are let go
  #isBodyFree = false;

  /** options: {vendorUrl, baseMapsUrl, readOnly, onSelect(ids), onChange({label, changes}), onMeasure(text), onDrawn(drawn), onPoint(lonLat), onNotice(text), onTurn(degrees)}. */
  constructor(host, options) {
    this.host = host;
    this.options = options;
    this.say = Object.fromEntries(HEARD.map((name) => [name, (value) => options[name]?.(value)]));
    this.bench = new Workbench(host, options, {
      fit: () => this.bench.surface.fitSite(this.bench.draft.features),
      lost: () => this.#lost(),
      tap: (at, event) => this.#tap(at, event),
      drawn: (tool, points) => this.#drawn(tool, points),
    }, this.say);
    host.tabIndex = 0;
    host.setAttribute('role', 'application');
    host.setAttribute('aria-label', 'Map drawing');
  }

  /** Load the engine; never rejects: without WebGL the map is shown and the notice says so. */
  async start() {
    const { bench, host } = this;
    const isEditable = await bench.start();
    if (this.isGone) {
      bench.destroy();
      return;
    }
    this.pointer = new Pointer(bench.surface.element, {
      grab: (at, event) => this.#grab(at, event),
      tap: (at, event) => this.#tap(at, event),
      hover: (at) => this.#hover(at),
      hold: () => bench.surface.hold(),
      share: () => bench.surface.share(),
      release: () => bench.surface.release(Boolean(bench.pen)),
    });
    this.keyboard = new Keyboard(host, {
      isDrawing: () => Boolean(bench.pen?.isDrawing),
      push: (east, north) => this.#push(east, north),
      settle: () => this.#settle(),
      finish: () => bench.pen?.finish(),
      escape: () => this.#escape(),
      undoPoint: () => this.undoPoint(),
      remove: () => this.removeVertex(),
      step: (by) => this.#step(by),
    });
    this.setTool(this.#tool);
    this.fit();
    bench.refresh();
    if (!isEditable) bench.notice(NO_WEBGL);
    host.dataset.state = 'ready';
  }

  #lost() {
    this.setTool('select');
    this.bench.notice(NO_WEBGL);
  }

  /** Why nothing can be drawn on this device; empty while that is not known or it can. */
  get drawingReason() {
    return this.bench.isReady && !this.bench.surface.isEditable ? NO_WEBGL : '';
  }

  /** Whether the features are in the picture. */
  get isDrawn() {
    return this.bench.isReady && this.bench.surface.engine.isFarmDrawn;
  }

  get #canEdit() {
    return this.bench.isReady && this.bench.surface.isEditable && !this.options.readOnly;
  }

  get #selection() {
    return this.bench.selection;
  }

  // --- what the screen around it calls

  /** Take the whole draft; selection and view stay. */
  setFeatures(features) {
    this.#endGesture();
    const isFirst = this.bench.draft.byId.size === 0;
    this.bench.setFeatures(features);
    if (isFirst) this.fit();
  }

  /** Apply [{id, before, after}] of the server. */
  patch(changes) {
    this.#endGesture();
    this.bench.apply(changes);
    this.bench.refresh();
  }

  /** What the next finger does; a device or a person that cannot draw may still select and measure. */
  setTool(tool) {
    if (tool !== 'select' && !(tool in PENS)) throw new Error(`No such tool: ${tool}`);
    const { bench } = this;
    this.#abandon();
    const isAllowed = !bench.isReady || this.#canEdit || (tool === 'measure' && bench.surface.isEditable);
    this.#tool = isAllowed ? tool : 'select';
    this.host.dataset.tool = this.#tool;
    bench.pen = bench.isReady && this.#tool in PENS ? penOf(bench, this.#tool) : null;
    bench.isHandled = this.#canEdit && this.#tool === 'select';
    if (bench.isReady) bench.surface.release(Boolean(bench.pen));
    bench.repaint();
  }

  get tool() {
    return this.#tool;
  }

  select(ids) {
    this.#endGesture();
    this.#selection.set(ids);
    this.bench.refresh();
  }

  get selected() {
    return [...this.#selection.ids];
  }

  /** While several may be selected, each tap adds or takes away; a function says which may be added. */
  set several(isSeveral) {
    this.#selection.isSeveral = isSeveral;
  }

  get several() {
    return this.#selection.isSeveral;
  }

  setSnap(isOn) {
    this.bench.isSnapping = isOn;
  }

  /** Whole shapes can be dragged while this is on. */
  unlockBody(isFree) {
    this.#isBodyFree = isFree;
  }

  setFindings(findings) {
    this.bench.setFindings(findings);
  }

  /** Give the circle that is being drawn its radius in metres; false while it has no middle. */
  setRadius(metres) {
    return this.bench.pen?.setRadius?.(metres) ?? false;
  }

  /** Show features as they would become; none: the preview is over. */
  setTrial(features) {
    this.bench.trial = features;
    this.bench.repaint();
  }

  /** Put a dial on the shape in hand, at so many degrees, that is heard by `onTurn`; null takes it away. */
  setTurning(degrees) {
    this.bench.turning = degrees;
    this.bench.repaint();
  }

  /** Set the row direction of a parcel, in degrees clockwise from north. */
  setDirection(id, degrees) {
    const before = this.bench.draft.get(id);
    const after = before && withBearing(before, degrees);
    if (!this.#canEdit || !before || after.properties.row_bearing_deg === before.properties.row_bearing_deg) return;
    this.bench.commit(turnText(before, after), [{ id, before, after }]);
  }

  /** Bring these, or all, into view: ids, or features that the draft need not have; of what lies far apart the main site. */
  fit(shown = null) {
    const { draft, isReady, surface } = this.bench;
    const features = shown ? shown.map((one) => one.geometry ? one : draft.get(one)).filter(Boolean) : draft.features;
    if (isReady) surface.fit(sitesOf(features)[0] ?? []);
  }

  /** Lay a base map with these bounds [west, south, east, north] under the map and bring it into view. */
  showBase(id, bounds) {
    if (this.bench.isReady) this.bench.surface.showBase(id, bounds);
  }

  /** Whether a drawing is in hand that could be finished as it is. */
  get canFinish() {
    return this.bench.pen?.isEnough ?? false;
  }

  /** Whether points are set that are not a shape yet. */
  get isDrawing() {
    return this.bench.pen?.isDrawing ?? false;
  }

  finish() {
    this.bench.pen?.finish();
  }

  /** Take the last point of the drawing back; false when nothing is being drawn. */
  undoPoint() {
    return this.bench.pen?.undo() ?? false;
  }

  /** Move the chosen corner, or unlocked shapes, by metres east and north. */
  nudge(east, north) {
    if (this.#push(east, north)) this.#settle();
  }

  /** The chosen corner as {id, name, position, part, ring, index}, or null. */
  get vertex() {
    return this.bench.vertex;
  }

  removeVertex() {
    const { corner, only, ids } = this.#selection;
    if (!this.#canEdit) return;
    if (!corner || !only) {
      this.bench.notice('Choose a corner to remove.');
      return;
    }
    const parts = removed(only, corner);
    if (parts) this.bench.commit(`${cornerName(only, corner)} removed`, [{ id: ids[0], before: only, after: rebuilt(only, parts) }], null);
    else if (corner.ring > 0) this.bench.notice('A hole needs three corners. Remove the hole instead.');
    else this.bench.notice(isArea(only) ? 'A shape needs three corners.' : 'A line needs two points.');
  }

  /** Put the chosen corner at [lon, lat]. */
  setVertex(lonLat) {
    const { corner, only, ids } = this.#selection;
    if (!this.#canEdit || !corner || !only) return;
    const after = rebuilt(only, moved(only, corner, lonLat));
    this.bench.commit(`${cornerName(only, corner)} set`, [{ id: ids[0], before: only, after }], { ...corner, position: kept(lonLat) });
  }

  /** Px of the map where a position is drawn. */
  project(lonLat) {
    return this.bench.surface.toPx(lonLat);
  }

  destroy() {
    this.isGone = true;
    if (!this.bench.isReady) return; // start() ends it
    this.#abandon();
    this.pointer.destroy();
    this.keyboard.destroy();
    this.bench.destroy();
  }

  // --- gestures

  #grab(at, event) {
    const { bench } = this;
    this.host.focus({ preventScroll: true, focusVisible: false });
    const isTouch = event.pointerType === 'touch';
    if (bench.pen instanceof CirclePen) return new CirclePress(bench.pen, at, event);
    if (bench.pen) return isTouch ? new PenPress(bench.pen) : null; // the mouse pans and clicks
    if (!this.#canEdit || event.shiftKey || this.several) return null;
    const { only, ids } = this.#selection;
    const { dial } = bench;
    if (only && bench.turning !== null) return isOnKnob(dial, at) ? new TurnDrag(bench, dial, (degrees) => this.say.onTurn(degrees)) : null;
    if (bench.trial.length) return null; // what is looked at is not what a finger would change
    if (only && isOnKnob(dial, at)) return new DialDrag(bench, ids[0], dial);
    const found = only && handleAt(bench.handles, at);
    if (found) {
      const mid = found.kind === 'mid' ? bench.surface.toLonLat([found.handle.x, found.handle.y]) : null;
      const { part, ring, index } = found.handle;
      return new CornerDrag(bench, ids[0], { part, ring, index }, at, { isTouch, mid });
    }
    const isOnBody = this.#isBodyFree && this.#under(at).some((id) => ids.includes(id));
    return isOnBody ? new BodyDrag(bench, ids, at, { isTouch }) : null;
  }

  #under(at) {
    const { draft, surface } = this.bench;
    return draft.under(surface.toLonLat(at), REACH_PX * surface.camera.metresPerPx);
  }

  #tap(at, event) {
    const { bench } = this;
    if (bench.pen) {
      bench.pen.place(at, event.timeStamp);
      return;
    }
    const id = markAt(bench.marks, (position) => this.project(position), at)?.finding.feature_id;
    this.#selection.tap(bench.draft.get(id) ? [id] : this.#under(at), at, event);
    bench.refresh();
    this.say.onSelect(this.selected);
  }

  #hover(at) {
    const { bench } = this;
    if (at) this.say.onPoint(bench.surface.toLonLat(at));
    if (bench.pen) {
      if (at) bench.pen.hover(at);
      else bench.pen.lift();
    } else if (at && this.#canEdit) this.host.dataset.over = this.#isOverHandle(at) ? 'handle' : '';
  }

  #isOverHandle(at) {
    const { bench } = this;
    return Boolean(this.#selection.only) && (isOnKnob(bench.dial, at) || Boolean(handleAt(bench.handles, at)));
  }

  #drawn(tool, points) {
    const { bench } = this;
    const { feature, operation, problem } = drawnOf(tool, points, this.#selection, bench.draft);
    if (problem) bench.notice(problem);
    else if (operation) this.say.onDrawn(operation);
    else {
      bench.apply([{ id: feature.id, after: feature }]);
      this.#selection.set([feature.id]);
      bench.commit(`${kindWord(feature.properties.kind)} drawn`, [{ id: feature.id, before: null, after: feature }]);
      this.say.onSelect(this.selected);
      this.say.onDrawn(feature);
    }
  }

  #push(east, north) {
    if (!this.#canEdit) return false;
    this.#held ??= nudgeOf(this.bench, this.#isBodyFree);
    this.#held?.push(east, north);
    return Boolean(this.#held);
  }

  #settle() {
    const held = this.#held;
    this.#held = null;
    held?.finish();
  }

  /** Give up whatever is under way. */
  #abandon() {
    this.pointer?.cancel();
    this.bench.pen?.clear();
    this.#endGesture();
  }

  /** Give up a drag or nudge: what it changes may not be what it was. A drawing goes on. */
  #endGesture() {
    if (!this.bench.pen) this.pointer?.cancel();
    this.#held = null;
    this.bench.revert();
  }

  #escape() {
    const { pen } = this.bench;
    if (this.pointer.gesture || this.#held || pen?.isDrawing || pen?.finished) {
      this.#abandon();
      this.say.onMeasure('');
    } else if (this.#selection.corner || this.#selection.isDial) this.bench.choose(null);
    else if (this.#selection.ids.length) {
      this.select([]);
      this.say.onSelect([]);
    } else return false;
    return true;
  }

  /** Choose the next or previous corner of the ring. */
  #step(by) {
    const { only, corner } = this.#selection;
    const { part, ring } = corner ?? { part: 0, ring: 0 };
    const corners = only && partsOf(only)[part]?.[ring];
    if (!corners || !this.#canEdit) return false;
    const index = corner ? corner.index + by : by > 0 ? 0 : -1;
    this.bench.choose({ part, ring, index: (index + corners.length) % corners.length });
    this.bench.said.textContent = this.vertex.name;
    return true;
  }
}

const penOf = (bench, tool) => (PENS[tool].shape === 'circle' ? new CirclePen(bench, tool) : new Pen(bench, tool));
