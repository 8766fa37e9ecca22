// Where the robot has been, remembered by this page: bounded, in chunks, so that only the newest is uploaded again.

import { LineSet } from './drawlist.js';
import { mercPerMetre } from './geometry.js';

const STEP_M = 0.3;
const CHUNK_POINTS = 200;
const MOST_CHUNKS = 40; // 8,000 points, about 2.4 km
const GAP_M = 5; // a farther step was not seen: no line across it
const MOST_ROBOTS = 12;

/** Trail of one robot. */
export class Trail {
  constructor() {
    this.chunks = [];
    this.origin = null;
  }

  /** Remember a pose; true when the line grew. */
  add(pose, isBroken) {
    const last = this.last;
    const perMetre = mercPerMetre(pose.my);
    const step = last ? Math.hypot(pose.mx - last.mx, pose.my - last.my) / perMetre : Infinity;
    if (step < STEP_M) return false;
    if (isBroken || step > GAP_M) this.#begin(pose);
    else this.#extend(pose, perMetre);
    this.last = { mx: pose.mx, my: pose.my };
    return true;
  }

  #begin(pose) {
    this.chunks.push({ points: [pose.mx, pose.my], set: new LineSet(CHUNK_POINTS), drawn: 1 });
    if (this.chunks.length > MOST_CHUNKS) this.chunks.shift();
  }

  #extend(pose) {
    let chunk = this.chunks.at(-1);
    if (!chunk) return this.#begin(pose);
    if (chunk.points.length / 2 >= CHUNK_POINTS) {
      this.#begin(this.last);
      chunk = this.chunks.at(-1);
    }
    chunk.points.push(pose.mx, pose.my);
    return undefined;
  }

  /** Line sets around `origin`; only what is new since the last call is added. */
  sets(origin) {
    if (this.origin !== origin) {
      this.origin = origin;
      for (const chunk of this.chunks) {
        chunk.set.clear();
        chunk.drawn = 1;
      }
    }
    return this.chunks.map((chunk) => {
      const { points, set } = chunk;
      const perMetre = mercPerMetre(points[1]);
      for (; chunk.drawn < points.length / 2; chunk.drawn += 1) {
        const i = chunk.drawn * 2;
        set.addPiece(points[i - 2], points[i - 1], points[i], points[i + 1], origin, perMetre, 0);
      }
      return set;
    });
  }
}

const trails = new Map();

/** The trail of a robot, kept while the page lives so that changing screens does not lose it. */
export function trailOf(robotId) {
  let trail = trails.get(robotId);
  if (!trail) {
    trail = new Trail();
    if (trails.size >= MOST_ROBOTS) trails.delete(trails.keys().next().value);
  } else trails.delete(robotId);
  trails.set(robotId, trail); // newest last
  return trail;
}
