// Paths and coverage of all missions on the fleet map: loaded one after the other, only while somebody wants to see them.

import { LineSet } from './drawlist.js';
import { Geometry } from './feed.js';
import { mercPerMetre } from './geometry.js';
import { readMission } from './mission.js';

const MOST = 60; // missions held; each is some hundred kilobytes of geometry
const AT_ONCE = 2;

export class FleetMissions {
  constructor(url, changed) {
    this.url = url;
    this.changed = changed;
    this.held = new Map(); // robot id -> {sha, model, rows, path, rowFrom, pathFrom, loader, state}
  }

  /** layers: {paths, coverage}; robots: Map of those whose missions are wanted, each with `order` of its fleet entry. */
  show(layers, robots) {
    this.layers = layers;
    this.robots = robots;
    for (const [id, one] of this.held) {
      if (robots.get(id)?.order?.sha256 === one.sha) continue;
      one.loader?.stop();
      this.held.delete(id);
    }
    this.#next();
  }

  #next() {
    const isLoading = [...this.held.values()].filter((one) => one.state === 'loading').length;
    let free = AT_ONCE - isLoading;
    for (const [id, robot] of this.robots) {
      if (free <= 0 || this.held.size >= MOST) return;
      if (this.held.has(id) || !robot.order?.sha256) continue;
      free -= 1;
      this.#load(id, robot.order.sha256);
    }
  }

  #load(id, sha) {
    const one = { sha, model: null, state: 'loading', origin: null };
    this.held.set(id, one);
    one.loader = new Geometry((state, collection) => {
      if (state === 'loading' || this.held.get(id) !== one) return;
      one.state = state;
      if (collection) one.model = readMission(collection);
      this.#next();
      this.changed();
    });
    one.loader.load(this.url.replace('{id}', encodeURIComponent(id)), { key: sha, isMissingOk: true });
  }

  /** What to draw, bottom to top, around `origin`. */
  lines(origin, ink) {
    const lines = [];
    if (!this.layers) return lines;
    for (const [id, one] of this.held) {
      if (!one.model?.pieces.length) continue;
      if (one.origin !== origin) this.#lay(one, origin);
      lines.push(...this.#drawn(one, this.robots.get(id), ink));
    }
    return lines;
  }

  #drawn({ model, rows, path, rowFrom, pathFrom }, robot, ink) {
    const { status, segment } = robot?.order ?? {};
    const end = model.pieces.length;
    const at = status === 'done' ? end : ['running', 'paused', 'aborted', 'failed'].includes(status) ? Math.min(Math.max(segment ?? 0, 0), end) : 0;
    const lines = [];
    if (this.layers.coverage) {
      lines.push({ set: rows, from: rowFrom[at], count: rowFrom[end] - rowFrom[at], colour: ink.row, leastPx: 1, cap: 0 });
      lines.push({ set: rows, from: 0, count: rowFrom[at], colour: ink.done, widthM: model.rowWidthM * 0.83, leastPx: 1.2, cap: 0 });
    }
    if (this.layers.paths) lines.push({ set: path, from: pathFrom[at], count: pathFrom[end] - pathFrom[at], colour: ink.path, leastPx: 1.4, dash: [7, 5] });
    return lines.filter((line) => line.count > 0);
  }

  #lay(one, origin) {
    const perMetre = mercPerMetre(origin.my);
    Object.assign(one, { origin, rows: one.rows ?? new LineSet(), path: one.path ?? new LineSet(), rowFrom: [], pathFrom: [] });
    one.rows.clear();
    one.path.clear();
    let walked = 0;
    for (const piece of one.model.pieces) {
      one.rowFrom.push(one.rows.count);
      one.pathFrom.push(one.path.count);
      if (piece.isWorked) one.rows.add(piece.line, origin, perMetre);
      walked = one.path.add(piece.line, origin, perMetre, walked);
    }
    one.rowFrom.push(one.rows.count);
    one.pathFrom.push(one.path.count);
  }

  destroy() {
    for (const one of this.held.values()) one.loader?.stop();
    this.held.clear();
  }
}
