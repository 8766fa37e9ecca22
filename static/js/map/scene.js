// Everything drawn over the farm: mission lines by progress, trail, robots and their marks.

import { AreaLines } from './areas.js';
import { LineSet, StampBatch } from './drawlist.js';
import { mercPerMetre } from './geometry.js';
import { SHAPE_ORDER, familyShape } from './shapes.js';
import { mixed, packed } from './theme.js';

const FAR = 2e-4; // mercator units (about 5 km): float32 gets too coarse beyond, so the origin moves
const LEAST_PX = { selected: 26, plain: 20 };
const RING_PX = 52;
const OCTAGON_PX = 84;
const DONE_SHARE = 0.83; // of the working width, so that single rows stay readable
const KEEP_OUT_M = 15;
const CROWD = 150; // robots beyond which they are drawn with fewer corners

export class Scene {
  constructor(palette) {
    this.origin = { mx: 0.5, my: 0.5 };
    this.camera = null;
    this.model = null;
    this.trail = null;
    this.shown = { rows: true, plan: true, trail: true };
    this.sets = { rows: new LineSet(), path: new LineSet(), behind: new LineSet(8), ahead: new LineSet(8) };
    this.areas = new AreaLines();
    this.stamps = Object.fromEntries(SHAPE_ORDER.map((shape) => [shape, new StampBatch(shape)]));
    this.setPalette(palette);
  }

  setPalette(palette) {
    this.palette = palette;
    const p = (name, alpha) => packed(palette[name], alpha);
    this.ink = {
      bed: p('parcelOn'), row: p('row'), done: p('done'), path: p('path'),
      trail: packed(mixed(palette.path, palette.done, 0.6)),
      obstacle: p('obstacle'), halo: p('halo'), ghostFill: p('raised'), ghostLine: p('ink2'), none: 0,
      body: { selected: [p('sel'), p('onSel')], plain: [p('ink2'), p('raised')], manual: [p('manual'), p('onManual')],
        stopped: [p('ink'), p('raised')], 1: [p('p1'), p('onP1')], 2: [p('p2'), p('onP2')], 3: [p('p3'), p('onP3')], 4: [p('p4'), p('onP4')] },
      ring: p('sel', 0.6), manualRing: p('manual', 0.6), reach: p('ink'),
      danger: p('p1'), dangerSoft: p('p1', 0.18), stopped: p('p3', 0.45), stoppedEdge: p('ink'),
    };
  }

  /** Keep positions near the origin; true when the origin moved and everything was laid again. */
  settle(mx, my) {
    if (Math.hypot(mx - this.origin.mx, my - this.origin.my) < FAR) return false;
    this.origin = { mx, my };
    this.#layMission();
    return true;
  }

  setMission(model) {
    this.model = model;
    this.progress = null;
    this.#layMission();
  }

  #layMission() {
    const { rows, path } = this.sets;
    rows.clear();
    path.clear();
    this.rowFrom = [];
    this.pathFrom = [];
    this.areas.lay(this.model, this.origin);
    if (!this.model) return;
    const perMetre = mercPerMetre(this.origin.my);
    let walked = 0;
    for (const piece of this.model.pieces) {
      this.rowFrom.push(rows.count);
      this.pathFrom.push(path.count);
      if (piece.isWorked) rows.add(piece.line, this.origin, perMetre);
      walked = path.add(piece.line, this.origin, perMetre, walked);
    }
    this.rowFrom.push(rows.count);
    this.pathFrom.push(path.count);
    if (this.progress) this.setProgress(this.progress);
  }

  setProgress(progress) {
    this.progress = progress;
    const perMetre = mercPerMetre(this.origin.my);
    for (const name of ['behind', 'ahead']) {
      this.sets[name].clear();
      this.sets[name].add(progress[name], this.origin, perMetre);
    }
  }

  /** Lay marks and machines of all robots. `look`: {now, count, selected, reachOf(robot) -> metres or null}. */
  setRobots(robots, look) {
    for (const shape of SHAPE_ORDER) this.stamps[shape].clear();
    let chosen = null;
    this.isCrowd = look.count > CROWD;
    const urgent = [];
    for (const robot of robots) {
      if (!robot.pose || look.isHidden?.(robot)) continue;
      if (robot.id === look.selected) chosen = robot;
      else if (robot.level || robot.stop) urgent.push(robot);
      else this.#robot(robot, look, false);
    }
    for (const robot of urgent) this.#robot(robot, look, false); // over those that need nobody
    if (chosen) this.#robot(chosen, look, true); // drawn last: on top of its neighbours
  }

  #robot(robot, look, isSelected) {
    const pose = robot.drawn(look.now);
    const x = pose.mx - this.origin.mx;
    const y = pose.my - this.origin.my;
    const scale = this.palette.scale;
    const least = (isSelected ? LEAST_PX.selected : LEAST_PX.plain) * scale;
    const shape = familyShape(robot.family);
    const { ink } = this;
    const isSmall = this.isCrowd && !isSelected && !robot.stop;
    this.#marks(robot, look, x, y, isSelected, scale);
    if (robot.isStale) {
      this.stamps[`${shape}-${isSmall ? 'small' : 'ghost'}`].push(x, y, pose.heading, robot.widthM, robot.lengthM, least, robot.shift, ink.ghostFill, ink.ghostLine, ink.ghostLine);
      return;
    }
    const [fill, accent] = this.#bodyInk(robot, isSelected);
    this.stamps[isSmall ? `${shape}-small` : shape].push(x, y, pose.heading, robot.widthM, robot.lengthM, least, robot.shift, fill, accent, ink.halo);
  }

  #bodyInk(robot, isSelected) {
    const { body } = this.ink;
    if (robot.stop === 'not-confirmed') return body[1];
    if (robot.stop === 'stopped') return body.stopped;
    if (robot.level && body[robot.level]) return body[robot.level];
    if (robot.mode === 'manual') return body.manual;
    return isSelected ? body.selected : body.plain;
  }

  #marks(robot, look, x, y, isSelected, scale) {
    const { ink, stamps } = this;
    const circle = (shape, radiusM, leastPx, colour) =>
      stamps[shape].push(x, y, 0, 2 * radiusM, 2 * radiusM, leastPx * scale, 0, colour, colour, colour);
    const reach = look.reachOf(robot);
    if (robot.stop === 'not-confirmed') {
      if (reach !== null) {
        circle('disc', reach, 46, ink.dangerSoft);
        circle('ring-heavy', reach, 46, ink.danger);
      }
      circle('ring-dash', robot.body?.keep_out_m || KEEP_OUT_M, 64, ink.danger);
    } else if (robot.stop === 'stopped' && !robot.isStale) {
      const size = robot.lengthM * 1.3;
      circle('octagon', size, OCTAGON_PX, ink.stopped);
      circle('octagon-edge', size, OCTAGON_PX, ink.stoppedEdge);
      circle('ring', robot.lengthM * 0.9, RING_PX, ink.ring);
    } else if (robot.isStale) {
      if (reach !== null && (isSelected || reach > 0)) circle('ring-thin-dash', reach, isSelected ? 46 : 34, ink.reach);
    } else if (isSelected || look.chosen?.has(robot.id)) {
      circle('ring', robot.lengthM * 0.95, RING_PX, robot.mode === 'manual' ? ink.manualRing : ink.ring);
    }
  }

  /** What to draw, bottom to top: {lines, stamps}. */
  drawList() {
    const stamps = SHAPE_ORDER.map((shape) => this.stamps[shape]).filter((batch) => batch.count);
    return { lines: [...(this.fleetLines?.(this.origin, this.ink) ?? []), ...this.#missionLines(), ...this.#areaLines(), ...this.#trailLines(), ...this.#planLines()], stamps };
  }

  #missionLines() {
    const { model, shown, sets, ink, camera } = this;
    if (!model || !shown.rows || !sets.rows.count) return [];
    const { rowWidthM } = model;
    const spacingPx = rowWidthM / camera.metresPerPx;
    const { at } = this.progress ?? { at: -1 };
    const end = model.pieces.length;
    const doneTo = this.rowFrom[Math.max(0, Math.min(at, end))];
    const drawnAhead = shown.plan && this.progress ? this.progress.nextEnd : at + 1;
    const restFrom = this.rowFrom[Math.min(Math.max(drawnAhead, 0), end)];
    const all = { set: sets.rows, from: 0, count: sets.rows.count };
    const restAlpha = Math.min(1, Math.max(0.25, spacingPx / 4)); // dense rows become a tint, not a block
    const lines = [
      { ...all, colour: ink.bed, widthM: rowWidthM * 1.02, leastPx: 1, cap: 0 },
      { ...all, from: restFrom, count: sets.rows.count - restFrom, colour: faded(ink.row, restAlpha), leastPx: 1, cap: 0 },
      { ...all, count: doneTo, colour: ink.done, widthM: rowWidthM * DONE_SHARE, leastPx: 0.8, cap: 0 },
    ];
    if (at >= 0 && at < end && model.pieces[at].isWorked) {
      lines.push({ set: sets.behind, from: 0, count: sets.behind.count, colour: ink.done, widthM: rowWidthM * DONE_SHARE, leastPx: 0.8, cap: 0 });
      if (!shown.plan) lines.push({ set: sets.ahead, from: 0, count: sets.ahead.count, colour: ink.row, leastPx: 1, cap: 0 });
    }
    return lines;
  }

  #areaLines() {
    return this.model ? this.areas.lines(this.model.rowWidthM, this.ink, this.shown.rows) : [];
  }

  #trailLines() {
    if (!this.trail || !this.shown.trail) return [];
    return this.trail.sets(this.origin).filter((set) => set.count)
      .map((set) => ({ set, from: 0, count: set.count, colour: this.ink.trail, leastPx: 2.2 }));
  }

  #planLines() {
    const { model, shown, sets, ink, progress } = this;
    if (!model || !shown.plan || !sets.path.count) return [];
    const at = progress?.at ?? -1;
    if (at >= model.pieces.length) return [];
    const from = this.pathFrom[at + 1];
    const to = this.pathFrom[progress ? progress.nextEnd : Math.min(1, model.pieces.length)];
    return [
      { set: sets.path, from, count: Math.max(0, to - from), colour: ink.path, leastPx: 2.6, dash: [9, 5] },
      { set: sets.ahead, from: 0, count: sets.ahead.count, colour: ink.path, leastPx: 4 },
    ];
  }
}

const faded = (word, share) => ((Math.round((word >>> 24) * share) << 24) | (word & 0xffffff)) >>> 0;
