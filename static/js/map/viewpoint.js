// From where a map looks: first at what there is, then along with its robot, until somebody moves it by hand.

import { fieldZoom, robotView, wholeView } from './first_view.js';
import { mercPerMetre } from './geometry.js';

const RING_MARGIN = 1.5;
const RING_PX = 24; // left free around the keep-out ring
const LEAST_OFF_PX = 0.25;

const seenFrom = ({ mx, my, zoom }) => [mx.toFixed(9), my.toFixed(9), zoom.toFixed(4)].join();

export class Viewpoint {
  isZoomChosen = false; // by hand

  /** `map` has engine, intake, fleet and options; nothing of it is changed but where its engine looks from. */
  constructor(map) {
    this.map = map;
    this.isFollowing = map.options.mode === 'robot';
  }

  get isOfRobot() {
    return this.map.options.mode === 'robot';
  }

  /** True where this changes anything. */
  follow(isFollowing) {
    if (this.isFollowing === isFollowing || !this.isOfRobot) return false;
    this.isFollowing = isFollowing;
    return true;
  }

  fit() {
    this.isPlaced = false;
    this.place();
  }

  /** First view, as soon as there is something to look at: the robot, else the whole farm. */
  place() {
    const { engine, intake, fleet } = this.map;
    if (this.isPlaced || !engine) return;
    const robot = this.isOfRobot ? robotView(intake, engine.camera) : null;
    const view = robot ?? wholeView(intake, engine.camera, fleet, this.map.controls);
    if (!view) return;
    this.isPlaced = Boolean(robot) || (fleet.placed > 0 && intake.farmState !== 'loading');
    engine.jump(view);
    this.placedAt = seenFrom(engine.camera);
  }

  /** A tablet was turned: who has not moved the map sees as much as before. */
  resized() {
    const { engine } = this.map;
    if (engine && !this.isOfRobot && this.placedAt === seenFrom(engine.camera)) this.fit();
  }

  /** Come as near as the field of a new mission allows, unless a zoom was chosen by hand. */
  showField() {
    const { engine, intake } = this.map;
    if (!this.isPlaced || !this.isFollowing || this.isZoomChosen || !intake.model) return;
    engine?.jump({ zoom: fieldZoom(intake, engine.camera) });
  }

  /** Follow the robot; when a STOP is not confirmed, come close enough for the keep-out ring. */
  keepUp(now, look) {
    const { engine, intake } = this.map;
    const robot = intake.selected;
    if (!this.isFollowing || !robot?.pose || engine.isBusy) return;
    const view = this.#viewOf(robot, now, look);
    const { camera } = engine;
    const offPx = Math.hypot(camera.mx - view.mx, camera.my - view.my) * camera.worldPx;
    if (offPx > LEAST_OFF_PX || view.zoom) engine.jump(view);
  }

  #viewOf(robot, now, look) {
    const { mx, my } = robot.drawn(now);
    const isDanger = robot.stop === 'not-confirmed';
    const view = { mx, my };
    if (isDanger && !this.isRingShown) {
      const metres = Math.max(robot.body?.keep_out_m ?? 15, look.reachOf(robot) ?? 0) * RING_MARGIN;
      const size = metres * mercPerMetre(my);
      view.zoom = this.map.engine.camera.zoomFor([mx - size, my - size, mx + size, my + size], RING_PX);
    }
    this.isRingShown = isDanger;
    return view;
  }
}
