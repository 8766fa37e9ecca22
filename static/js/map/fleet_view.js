// What the map of the whole fleet adds: clusters, marks and words from the list beside it, paths and coverage.

import { clusterLabels } from './captions.js';
import { clustersOf, stepOf } from './clusters.js';
import { LabelLayer } from './labels.js';

const TAP_PX = 28;
const FEW = 150;
const EDGE_PX = 60;
const NEAR_ZOOM = 18;
const NEARER = 2; // zooms a tap on a cluster comes nearer

export class View {
  /** map: the LiveMap it belongs to; does nothing on the map of one robot. */
  constructor(map) {
    this.map = map;
    this.isOn = map.options.mode === 'fleet';
    this.said = null;
    this.clusters = [];
    this.layer = this.isOn ? new LabelLayer(map.host) : null; // apart: names move with robots, clusters do not
  }

  /** How many robots have a place; from then on the view is left alone. */
  get placed() {
    return this.map.intake.placed;
  }

  /**
   * Take what the list says: {verdicts: Map, chosen: Set, current, isSeen(id), layers: {names, paths, coverage}}.
   *
   * Returns what it needs: 'now' when a person chose something, 'soon' when marks are others, '' when the map looks the same.
   */
  set(said) {
    const before = this.said?.key;
    this.said = said;
    said.key = `${said.current}|${[...said.chosen]}|${JSON.stringify(said.layers)}`;
    let isMarked = false;
    for (const robot of this.map.intake.robots.values()) isMarked = this.#mark(robot, said) || isMarked;
    this.#layers(said.layers);
    return before !== said.key ? 'now' : isMarked ? 'soon' : '';
  }

  #mark(robot, { verdicts, isSeen }) {
    const verdict = verdicts.get(robot.id);
    if (!verdict) return false;
    const { level } = verdict;
    const isQuiet = Boolean(verdict.isOver); // a sign without words: what is over asks nobody to look there first
    const text = level ? verdict.head : '';
    const isOut = !isSeen(robot.id);
    const isAsking = verdict.look === 'unacknowledged';
    if (robot.level === level && robot.text === text && robot.isOut === isOut && robot.isAsking === isAsking && robot.isQuiet === isQuiet) return false;
    const isOnlyWords = robot.level === level && robot.isOut === isOut && robot.isAsking === isAsking;
    Object.assign(robot, { level, text, isOut, isAsking, isQuiet });
    return !isOnlyWords || this.map.intake.robots.size <= FEW; // in a crowd new words wait for the next picture
  }

  /** Missions load when somebody asks for their paths or their coverage. */
  async #layers(layers) {
    const isWanted = layers.paths || layers.coverage;
    if (!isWanted && !this.missions) return;
    const { FleetMissions } = await import('./fleet_missions.js');
    const { map } = this;
    if (map.isGone) return;
    this.missions ??= new FleetMissions(map.options.missionUrl, () => map.engine?.redraw());
    this.missions.show(layers, isWanted ? map.intake.robots : new Map());
    map.scene.fleetLines = (origin, ink) => this.missions.lines(origin, ink);
  }

  /** Keep positions near the origin of what is drawn. */
  settle() {
    if (!this.isOn) return;
    for (const { pose } of this.map.intake.robots.values()) {
      if (pose) return void this.map.scene.settle(pose.mx, pose.my);
    }
  }

  /** True when the view came so much nearer, or went so far, that the clusters are others now. */
  get isOutgrown() {
    return this.isOn && this.step !== undefined && this.step !== stepOf(this.map.engine.camera);
  }

  /** Work out clusters, and tell `look` who is in one, who is filtered out and who is chosen. */
  gather(look) {
    if (!this.isOn) return;
    const { intake, engine, palette } = this.map;
    this.step = stepOf(engine.camera);
    if (this.said) look.selected = this.said.current;
    const { of, list } = clustersOf(intake.robots.values(), engine.camera, { now: look.now, current: look.selected, scale: palette.scale });
    this.clusters = list;
    look.chosen = this.said?.chosen ?? null;
    look.isHidden = (robot) => robot.isOut || of.has(robot.id);
  }

  /** Draw the clusters; returns what keeps other texts off them. */
  drawClusters(camera, palette) {
    if (!this.layer) return [];
    this.layer.draw(camera, clusterLabels(this.clusters, palette), palette);
    return this.clusters.map(({ mx, my, px }) => ({ mx, my, lines: [], clearPx: px / 2, priority: 94 }));
  }

  /** Robots that are drawn as such: not filtered out, in no cluster. */
  single(robots, look) {
    return this.isOn ? [...robots].filter((robot) => !look.isHidden(robot)) : robots;
  }

  /** Bring a robot into sight, near if asked. */
  show(id, isNear = false) {
    const { engine, intake } = this.map;
    const pose = intake.robots.get(id)?.pose;
    if (!pose || !engine) return;
    const { camera } = engine;
    const [x, y] = camera.project(pose.mx, pose.my);
    const isInSight = x > EDGE_PX && y > EDGE_PX && x < camera.width - EDGE_PX && y < camera.height - EDGE_PX;
    if (isNear || !isInSight) engine.ease({ mx: pose.mx, my: pose.my, zoom: isNear ? Math.max(camera.zoom, NEAR_ZOOM) : camera.zoom });
  }

  tapped(x, y) {
    const { engine } = this.map;
    const hit = this.clusters.find((one) => {
      const [cx, cy] = engine.camera.project(one.mx, one.my);
      return Math.hypot(cx - x, cy - y) < TAP_PX;
    });
    if (hit) engine.ease({ mx: hit.mx, my: hit.my, zoom: engine.camera.zoom + NEARER });
  }

  destroy() {
    this.missions?.destroy();
    this.layer?.destroy();
  }
}
