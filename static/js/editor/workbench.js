// What lies on the table: draft, selection, what is being changed, and the picture of it.

import { Bed } from './bed.js';
import { dialOf } from './dial.js';
import { Draft } from './draft.js';
import { Loupe } from './loupe.js';
import { marksOf } from './finding_marks.js';
import { handlesOf } from './handles.js';
import { Overlay } from './overlay.js';
import { Selection } from './selection.js';
import { cornerAt, cornerName } from './shape.js';
import { Strips } from './strips.js';
import { Surface } from './surface.js';
import { turnDialOf } from './trial.js';
import { kindWord } from './words.js';

export class Workbench {
  #live = new Map(); // id -> the feature as it looks during a gesture
  #findings = [];
  #drag = null;

  /** act: {fit(), lost(), tap(at, event), drawn(tool, points)}; say: what the screen around it hears. */
  constructor(host, { vendorUrl, baseMapsUrl }, act, say) {
    this.host = host;
    this.act = act;
    this.say = say;
    this.isSnapping = true;
    this.isHandled = false; // corners can be dragged: the select tool, and somebody who may
    this.pen = null;
    this.trial = []; // features as they would become
    this.turning = null; // degrees, while somebody turns a shape
    this.marks = [];
    this.draft = new Draft();
    this.selection = new Selection(this.draft);
    const hooks = { moved: () => this.#moved(), framed: () => this.#paint(), palette: () => this.repaint(), fit: act.fit, lost: act.lost };
    this.surface = new Surface(host, { vendorUrl, baseMapsUrl, hooks });
  }

  /** Start the map; false where it can only be looked at. */
  async start() {
    const isEditable = await this.surface.start();
    this.overlay = new Overlay(this.host);
    this.loupe = new Loupe(this.host);
    this.bed = new Bed(this.surface);
    this.strips = new Strips(this.surface, this.draft, () => this.selection.ids);
    this.host.append(this.surface.controls.root); // buttons over the drawing
    this.said = this.host.appendChild(document.createElement('div'));
    this.said.className = 'hl-edit-said';
    this.said.setAttribute('role', 'status');
    this.surface.setFeatures(this.draft.features);
    this.isReady = true;
    return isEditable;
  }

  #moved() {
    this.bed?.refresh();
    this.strips?.later();
  }

  // --- what drags, pens and nudges do

  /** Show a feature as it would become, or as it is again (`live` null). */
  show(id, live) {
    const wasLive = this.#live.has(id);
    if (live) this.#live.set(id, live);
    else this.#live.delete(id);
    const { features } = this.draft;
    if (live && !wasLive) this.surface.update({ features, removed: [id], isRelabelled: false });
    if (!live && wasLive && this.draft.get(id)) this.surface.update({ features, changed: [this.draft.get(id)], isRelabelled: false });
    this.bed?.show(this.inHand, { isHurried: Boolean(live) });
    this.repaint();
  }

  /** Say beside the finger what a drag does; null when it ends. */
  tell(drag) {
    this.#drag = drag;
    this.repaint();
  }

  choose(corner) {
    this.selection.corner = corner;
    this.selection.isDial = false;
    if (this.vertex) this.say.onPoint(this.vertex.position);
    this.repaint();
  }

  chooseDial() {
    this.selection.corner = null;
    this.selection.isDial = true;
    this.repaint();
  }

  /** A finished gesture: one change. `corner`: {part, ring, index, position} to hold on to. */
  commit(label, changes, corner = this.selection.corner) {
    this.#live.clear();
    this.#drag = null;
    this.apply(changes);
    this.selection.follow(corner);
    this.refresh();
    this.said.textContent = label;
    if (this.vertex) this.say.onPoint(this.vertex.position);
    this.say.onChange({ label, changes });
  }

  titleOf(changes) {
    const { name, kind } = changes[0].after.properties;
    return changes.length > 1 ? `${changes.length} shapes` : name || kindWord(kind);
  }

  tap(at, event) {
    this.act.tap(at, event);
  }

  drawn(tool, points) {
    this.act.drawn(tool, points);
  }

  measured(text) {
    this.say.onMeasure(text);
  }

  notice(text) {
    if (this.said) this.said.textContent = text;
    this.say.onNotice(text);
  }

  // --- state

  setFeatures(features) {
    this.draft.set(features);
    this.selection.prune();
    if (!this.isReady) return;
    this.surface.setFeatures(this.draft.features);
    this.refresh();
  }

  apply(changes) {
    this.draft.apply(changes);
    this.selection.prune();
    if (!this.isReady) return;
    const removed = changes.filter(({ after }) => !after).map(({ id }) => id);
    const changed = changes.filter(({ after }) => after).map(({ after }) => after);
    this.surface.update({ features: this.draft.features, removed, changed });
  }

  setFindings(findings) {
    this.#findings = findings;
    this.marks = marksOf(findings, this.draft);
    this.repaint();
  }

  /** Everything goes back to what the draft says. */
  revert() {
    for (const id of [...this.#live.keys()]) this.show(id, null);
    this.#drag = null;
  }

  refresh() {
    if (!this.isReady) return;
    this.host.dataset.selected = this.selection.ids.join(' ');
    this.marks = marksOf(this.#findings, this.draft);
    this.surface.setUnnamed(this.selection.ids);
    this.bed.show(this.inHand);
    this.strips.later();
    this.repaint();
  }

  /** The chosen corner as {id, name, position, part, ring, index}, or null. */
  get vertex() {
    const { corner, only, ids } = this.selection;
    const position = corner && only && cornerAt(only, corner);
    return position ? { id: ids[0], name: cornerName(only, corner), position, ...corner } : null;
  }

  /** Selected features as they look now. */
  get inHand() {
    return this.selection.ids.map((id) => this.#live.get(id) ?? this.draft.get(id)).filter(Boolean);
  }

  get handles() {
    return handlesOf(this.inHand[0], (position) => this.surface.toPx(position), this.surface.camera);
  }

  get dial() {
    if (this.trial.length && this.turning === null) return null;
    if (this.turning !== null) return turnDialOf(this.inHand[0], this.surface, this.turning);
    return dialOf(this.inHand[0], this.surface);
  }

  // --- picture

  repaint() {
    if (!this.isReady || this.frame) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = null;
      if (this.#underGlass && this.surface.isEditable) this.surface.redraw(); // the glass needs the map's picture of this frame
      else this.#paint();
    });
  }

  get #underGlass() {
    if (this.#drag?.finger) return this.#drag;
    const next = this.pen?.next;
    return next?.finger ? { at: next.position, finger: next.finger } : null;
  }

  #paint() {
    if (!this.isReady) return;
    const { surface, selection } = this;
    const hasHandles = this.isHandled && Boolean(selection.only);
    this.overlay.draw({
      camera: surface.camera,
      palette: surface.palette,
      toPx: (position) => surface.toPx(position),
      selected: this.inHand,
      live: this.#live,
      handles: hasHandles ? this.handles : null,
      chosen: selection.corner,
      drag: this.#drag,
      dial: hasHandles ? this.dial : null,
      isDialChosen: selection.isDial,
      pen: this.pen,
      trial: this.trial,
      marks: this.marks,
    });
    const glass = this.#underGlass;
    if (!glass || !surface.isEditable) this.loupe.hide();
    else this.loupe.show(surface.toPx(glass.at), glass.finger, [surface.engine.map.getCanvas(), this.overlay.canvas], surface.camera, surface.palette.ground);
  }

  destroy() {
    this.isReady = false;
    cancelAnimationFrame(this.frame);
    for (const part of [this.overlay, this.loupe, this.bed, this.strips, this.surface]) part?.destroy();
    this.said?.remove();
  }
}
