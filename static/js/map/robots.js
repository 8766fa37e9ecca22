// Robots as the map knows them: newest pose, how it is drawn between poses, and what it may do next.

import { mercPerMetre, mercX, mercY } from './geometry.js';

const GLIDE_LEAST_MS = 40;
const GLIDE_MOST_MS = 250; // longer gaps are not smoothed over
const JUMP_M = 5; // a farther step is a correction, not a movement
const SEEN_PX = 0.75; // in a crowd smaller steps and turns cannot be seen
const SEEN_TURN = 0.15;
export const STALE_MS = 2000;
const TURN = 2 * Math.PI;

/** One robot on the map. Headings are radians clockwise from north. */
export class Robot {
  constructor(id) {
    this.id = id;
    this.name = id;
    this.family = 'other';
    this.mode = 'unknown';
    this.text = '';
    this.level = null;
    this.pose = null;
    this.body = null;
    this.stop = null; // null | 'stopped' | 'not-confirmed'
    this.isStale = false;
    this.isNew = true;
  }

  /** Take a pose {t, lat, lon, heading_deg, speed_mps} unless it is older than the one held; true when it moved. `isGliding`: it is drawn on its way there. */
  setPose(pose, now, isGliding = true) {
    if (!pose || !Number.isFinite(pose.lat) || !Number.isFinite(pose.lon)) return false;
    if (this.pose && pose.t <= this.pose.t) return false; // false too when the held time no longer compares
    const target = {
      t: pose.t,
      lat: pose.lat,
      lon: pose.lon,
      mx: mercX(pose.lon),
      my: mercY(pose.lat),
      heading: ((pose.heading_deg ?? 0) * Math.PI) / 180,
      headingDeg: pose.heading_deg ?? null,
      speed: pose.speed_mps ?? null,
    };
    const far = !isGliding || !this.pose || this.isStale
      || Math.hypot(target.mx - this.pose.mx, target.my - this.pose.my) > JUMP_M * mercPerMetre(target.my);
    this.from = far ? target : this.drawn(now);
    this.span = Math.min(Math.max(now - (this.arrived ?? 0), GLIDE_LEAST_MS), GLIDE_MOST_MS);
    this.arrived = now;
    this.pose = target;
    return true;
  }

  /** Where to draw it: between the last two poses while it is fresh, at the newest one otherwise; never beyond. */
  drawn(now) {
    const { pose, from } = this;
    if (!from || from === pose || this.isStale) return pose;
    const share = (now - this.arrived) / this.span;
    if (share >= 1) return pose;
    const turn = ((pose.heading - from.heading + 3 * Math.PI) % TURN) - Math.PI;
    return {
      mx: from.mx + (pose.mx - from.mx) * share,
      my: from.my + (pose.my - from.my) * share,
      heading: from.heading + turn * share,
    };
  }

  /** True when it is not, as far as a person can see, where it was when `lay` noted it. */
  hasMoved(worldPx) {
    const { pose, laid } = this;
    if (!laid) return true;
    return Math.hypot(pose.mx - laid.mx, pose.my - laid.my) * worldPx > SEEN_PX || Math.abs(pose.heading - laid.heading) > SEEN_TURN;
  }

  /** Note that it is drawn where it is now. */
  lay() {
    this.laid = this.pose;
  }

  /** Px it still has to glide; 0 when it is where it is drawn. */
  glidePx(now, worldPx) {
    if (!this.from || this.from === this.pose || this.isStale || now - this.arrived >= this.span) return 0;
    return Math.hypot(this.pose.mx - this.from.mx, this.pose.my - this.from.my) * worldPx;
  }

  get lengthM() {
    return this.body?.length_m || DEFAULT_SIZE[this.family]?.[1] || 2.4;
  }

  get widthM() {
    return this.body?.width_m || DEFAULT_SIZE[this.family]?.[0] || 2;
  }

  /** Forward shift of the outline against the reported point, in half lengths. */
  get shift() {
    const front = this.body?.base_to_front_m;
    return Number.isFinite(front) && this.body?.length_m ? (2 * front) / this.body.length_m - 1 : 0;
  }

  /** Age of the pose in ms at `clock` ({lane: console ms or NaN, page: performance.now()}). */
  ageMs(clock) {
    const age = clock.lane - this.pose.t;
    if (Number.isNaN(age)) return clock.page - (this.seen ?? -Infinity);
    this.seen = clock.page - age;
    return Math.max(0, age);
  }

  /** The console's clock started anew: times held no longer compare, ages go on by this page's own clock. */
  forgetClock() {
    if (this.pose) this.pose.t = NaN;
  }

  /** Metres it can have gone since `ageMs` ago, had it kept its speed; null when nothing is known about its speed. */
  reachM(ageMs) {
    const speed = this.pose?.speed ?? this.body?.max_speed_mps ?? null;
    return speed === null || !Number.isFinite(ageMs) ? null : (Math.abs(speed) * ageMs) / 1000;
  }
}

const DEFAULT_SIZE = { weeder: [2.8, 2.4], planter: [3.2, 2.6], uav: [1, 1.2] };

/** "3.4 m", always rounded up: a person must not read less than it may be. */
export function upTo(metres) {
  if (metres >= 10) return `${Math.ceil(metres)} m`;
  return `${(Math.ceil(metres * 10 - 1e-6) / 10).toFixed(1).replace(/\.0$/, '')} m`;
}

/** Wall-clock time "14:36:20" of something `ageMs` ago, on this device's clock. */
export function clockTime(ageMs) {
  const time = new Date(Date.now() - ageMs);
  return [time.getHours(), time.getMinutes(), time.getSeconds()].map((part) => String(part).padStart(2, '0')).join(':');
}

const TAP_PX = 28;

/** The robot under a finger, or null; `isHidden` ones are not drawn. */
export function robotAt(robots, camera, x, y, isHidden = () => false) {
  let best = null;
  let off = TAP_PX;
  for (const robot of robots) {
    if (!robot.pose || isHidden(robot)) continue;
    const [rx, ry] = camera.project(robot.pose.mx, robot.pose.my);
    if (Math.hypot(rx - x, ry - y) < off) [best, off] = [robot, Math.hypot(rx - x, ry - y)];
  }
  return best;
}
