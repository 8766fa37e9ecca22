// What the map knows: robots from the live lane, farm and mission from REST, STOP states from the page.

import { Geometry, LaneTopic, StopStates, laneNow } from './feed.js';
import { Robot, STALE_MS } from './robots.js';
import { trailOf } from './trail.js';

const FEW = 60; // robots that are drawn again for each change of an entry
const EMPTY = { type: 'FeatureCollection', features: [] };

/** Gathers data and says what changed: `told('robots' | 'places' | 'farm' | 'mission' | 'state')`. */
export class Intake {
  constructor(options, told) {
    this.options = options;
    this.told = told;
    this.robots = new Map();
    this.farm = EMPTY;
    this.parcels = EMPTY;
    this.model = null;
    this.mission = null;
    this.farmState = 'loading';
    this.missionState = 'none';
    this.clock = { lane: NaN, page: 0 };
    this.placed = 0; // robots that have a place, as of the last look
  }

  start() {
    const { mode, robotId, featuresUrl } = this.options;
    this.stops = new StopStates(() => this.told('robots'));
    this.features = new Geometry((state, data) => this.#farm(state, data));
    this.lines = new Geometry((state, data) => this.#lines(state, data), async () => { this.reader = await import('./mission.js'); });
    this.features.load(featuresUrl);
    this.unsubscribe = window.headland?.on?.('event', (event) => {
      if (event?.kind === 'map' && event.what === 'published') this.features.load(featuresUrl, { key: `${featuresUrl} v${event.version}` });
    });
    this.topics = [new LaneTopic('hello', () => this.#newClock())];
    if (mode === 'fleet') {
      this.topics.push(new LaneTopic('fleet', (state, names) => this.#fleet(state, names)));
      this.topics.push(new LaneTopic('poses', (state, ids) => this.#poses(state, ids)));
    } else if (robotId) this.topics.push(new LaneTopic(`robot/${robotId}`, (state) => this.#one(state)));
  }

  get selected() {
    return this.robots.get(this.options.robotId) ?? null;
  }

  /** Bring ages and STOP states up to now; true when a robot became stale, fresh, stopped or free since the last call. */
  judge() {
    this.clock = { lane: laneNow(), page: performance.now() };
    let hasChanged = false;
    this.isGrowing = false;
    this.placed = 0;
    for (const robot of this.robots.values()) {
      if (!robot.pose) continue;
      this.placed += 1;
      const isStale = robot.ageMs(this.clock) >= STALE_MS;
      const stop = this.stops.of(robot.id, robot.safety);
      if (isStale !== robot.isStale || stop !== robot.stop) hasChanged = true;
      robot.isStale = isStale;
      robot.stop = stop;
      if (isStale || stop === 'not-confirmed') this.isGrowing = true;
    }
    return hasChanged;
  }

  /** Where the selected robot is on its mission. A stale one stays where it was seen. */
  progress() {
    return this.reader.progress(this.model, this.mission, this.selected?.pose);
  }

  retry() {
    this.features.retry();
    this.lines.retry();
  }

  /** Another run of the console counts time anew: what is held keeps its age but no longer compares. */
  #newClock() {
    for (const robot of this.robots.values()) robot.forgetClock();
  }

  #robot(id) {
    let robot = this.robots.get(id);
    if (!robot) this.robots.set(id, (robot = new Robot(id)));
    return robot;
  }

  #one(state) {
    const { robotId, missionUrl } = this.options;
    const robot = this.#robot(robotId);
    robot.body = state.body ?? robot.body;
    robot.mode = state.mode?.mode ?? 'unknown';
    robot.text = state.mode?.text ?? '';
    robot.name = state.id?.name ?? robot.name;
    robot.family = state.id?.family ?? robot.family;
    robot.safety = state.safety ?? null;
    const wasStale = robot.isStale;
    if (robot.setPose(state.pose, performance.now())) trailOf(robotId).add(robot.pose, wasStale);
    this.mission = state.mission ?? null;
    if (this.mission?.sha256) {
      this.lines.load(missionUrl.replace('{id}', encodeURIComponent(robotId)), { key: this.mission.sha256, isMissingOk: true });
    } else if (this.missionState !== 'none') this.#noMission();
    this.told('robots');
  }

  #noMission() {
    this.lines.stop();
    this.model = null;
    this.parcels = EMPTY;
    this.missionState = 'none';
    this.told('mission');
  }

  #fleet(state, names) {
    if (names && !names.length) return; // beats: nothing here changes with them
    const rows = state.robots ?? {};
    const places = window.headland?.state?.('poses')?.robots ?? {};
    const now = performance.now();
    const before = this.robots.size;
    for (const id of this.robots.keys()) if (!(id in rows)) this.robots.delete(id);
    for (const id of names ?? Object.keys(rows)) {
      const row = rows[id];
      if (!row) continue;
      const robot = this.#robot(id);
      robot.name = row.name ?? id;
      robot.family = row.family ?? 'other';
      robot.mode = row.mode ?? 'unknown';
      if (robot.isOut === undefined) { // until the list beside the map has spoken, see fleet_view.js
        robot.text = row.why || row.text || '';
        robot.level = row.level ?? null;
      }
      robot.order = row.mission ?? null;
      if (!robot.pose) robot.setPose(places[id], now);
    }
    if (!names || this.robots.size !== before || this.robots.size <= FEW) this.told('robots'); // else with the next places
  }

  /** Places alone, ten times a second; a robot without a fleet entry is not known yet. */
  #poses(state, ids) {
    const now = performance.now();
    const places = state.robots ?? {};
    const isGliding = this.robots.size <= FEW;
    for (const id of ids ?? Object.keys(places)) this.robots.get(id)?.setPose(places[id], now, isGliding);
    this.told('places');
  }

  #farm(state, collection) {
    this.farmState = state;
    if (collection) this.farm = collection;
    this.told(collection ? 'farm' : 'state');
  }

  #lines(state, collection) {
    this.missionState = state;
    if (!collection && state !== 'missing') return this.told('state');
    const model = collection && this.reader.readMission(collection);
    this.model = model?.pieces.length ? model : null;
    this.parcels = model ? { ...EMPTY, features: model.parcels } : EMPTY;
    return this.told('mission');
  }

  destroy() {
    this.topics?.forEach((topic) => topic.destroy());
    this.stops?.destroy();
    this.unsubscribe?.();
    this.features?.stop();
    this.lines?.stop();
  }
}
