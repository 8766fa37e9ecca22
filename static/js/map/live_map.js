// The live map: farm, mission, robots, marks and controls on one element. See components/live_map.py for its options.

import { farmLabels, readableLabels, robotLabels } from './captions.js';
import { Controls } from './controls.js';
import { Geometry, LaneTopic, StopStates, ageOf, laneRevision } from './feed.js';
import { boxOf, latOf, lonOf, mercPerMetre, mercX, mercY } from './geometry.js';
import { LabelLayer } from './labels.js';
import { progress, readMission } from './mission.js';
import { RobotList } from './robot_list.js';
import { Robot, STALE_MS } from './robots.js';
import { Scene } from './scene.js';
import { readPalette, watchTheme } from './theme.js';
import { trailOf } from './trail.js';

const WATCH_MS = 250; // how often ages are looked at between updates
const GROW_MS = 500; // how often growing circles are drawn anew
const GLIDE_PX = 0.75; // smaller steps between poses cannot be seen
const FRAME_MS = 40; // 25 pictures a second while gliding
const TAP_PX = 28;
const ROBOT_ZOOM = 16.8; // 2.3 px per metre at 52 degrees north: a field of a hectare fills the screen
const FAR_ZOOM = 15.5;
const LOST_CONTEXT_MS = 3000;
const LAYERS = [['rows', 'Rows'], ['plan', 'Planned path'], ['trail', 'Trail'], ['labels', 'Names'], ['surroundings', 'Roads, trees, buildings']];
const EMPTY = { type: 'FeatureCollection', features: [] };
const LAYER_KEY = 'headland.map.layers';

export class LiveMap {
  /** options: {robotId, mode, hasButtons, featuresUrl, missionUrl, vendorUrl, engine, onSelect(id)}. */
  constructor(host, options) {
    this.host = host;
    this.options = { mode: 'robot', hasButtons: true, engine: 'auto', featuresUrl: '/api/v1/features', missionUrl: '/api/v1/robots/{id}/mission.geojson', ...options };
    this.robots = new Map();
    this.farm = EMPTY;
    this.labels = [];
    this.farmState = 'loading';
    this.missionState = 'none';
    this.view = { mx: mercX(10), my: mercY(50), zoom: 5, bearing: 0 };
    this.isFollowing = this.options.mode === 'robot';
    this.shown = readLayers();
    this.frameNumber = 0;
    this.updateMs = 0;
    this.palette = readPalette();
    this.scene = new Scene(this.palette);
    this.scene.shown = this.shown;
    this.surface = document.createElement('div');
    this.surface.className = 'hl-map-surface';
    host.classList.add('hl-map');
    host.append(this.surface);
    this.labelLayer = new LabelLayer(host);
    this.controls = this.#controls();
    this.list = new RobotList(host);
    this.#notice();
  }

  #controls() {
    return new Controls(this.host, {
      mode: this.options.mode,
      hasButtons: this.options.hasButtons,
      layers: LAYERS.map(([name, label]) => ({ name, label, isOn: this.shown[name] })),
      act: {
        follow: () => this.follow(!this.isFollowing),
        fit: () => this.fit(),
        zoom: (step) => this.engine?.ease({ zoom: this.engine.camera.zoom + step }),
        north: () => this.engine?.ease({ bearing: 0 }),
        layer: (name, isOn) => this.#layer(name, isOn),
        retry: () => this.#retry(),
      },
    });
  }

  /** Load the engine and the data; never rejects: what goes wrong is said on the map. */
  async start() {
    const { options } = this;
    this.stops = new StopStates(() => this.#update());
    this.features = new Geometry((state, data) => this.#farm(state, data));
    this.missionGeometry = new Geometry((state, data) => this.#mission(state, data));
    this.features.load(options.featuresUrl);
    this.unwatch = watchTheme((palette) => this.#theme(palette));
    await this.#engine(options.engine);
    if (this.isGone) return;
    const topic = options.mode === 'robot' ? `robot/${options.robotId}` : 'fleet';
    this.topics = [];
    if (options.mode === 'fleet') {
      this.topics.push(new LaneTopic(topic, (state) => this.#fleetState(state)));
      this.topics.push(new LaneTopic('poses', (state, ids) => this.#poses(state, ids)));
    } else if (options.robotId) this.topics.push(new LaneTopic(topic, (state) => this.#robotState(state)));
    this.watch = setInterval(() => this.#watch(), WATCH_MS);
    this.host.addEventListener('keydown', (this.keys = (event) => this.#key(event)));
  }

  async #engine(wanted) {
    const hooks = {
      moved: () => this.#moved(),
      panned: () => this.follow(false),
      framed: () => this.#framed(),
      tapped: (x, y) => this.#tapped(x, y),
      lost: () => { this.lostTimer = setTimeout(() => this.#fallBack(), LOST_CONTEXT_MS); },
      restored: () => clearTimeout(this.lostTimer),
    };
    const setup = { scene: this.scene, palette: this.palette, view: this.engine?.camera ?? this.view, vendor: this.options.vendorUrl, hooks };
    this.why = '';
    if (wanted !== 'canvas') {
      try {
        const { GlEngine, hasWebGl } = await import('./gl_engine.js');
        if (hasWebGl()) this.engine = await GlEngine.create(this.surface, setup);
        else this.why = 'Simple map: this device has no WebGL.';
      } catch (error) {
        console.warn('map: the GL engine did not start:', error);
        this.why = 'Simple map: the full one did not load.';
      }
    }
    if (wanted === 'canvas' || this.why) {
      this.surface.replaceChildren();
      const { CanvasEngine } = await import('./canvas_engine.js');
      this.engine = await CanvasEngine.create(this.surface, setup);
    }
    if (this.isGone) return this.engine.destroy();
    this.#engineReady();
    return undefined;
  }

  #engineReady() {
    const { engine } = this;
    this.scene.camera = engine.camera;
    this.host.dataset.engine = engine.kind;
    engine.setFarm(this.farm);
    engine.setMission(this.missionParcel ?? EMPTY);
    engine.showSurroundings(this.shown.surroundings);
    engine.setFollowing(this.isFollowing);
    this.#show();
    this.#moved();
    this.#update();
  }

  async #fallBack() {
    const { engine } = this;
    this.engine = null;
    engine?.destroy();
    this.surface.replaceChildren();
    if (!this.isGone) await this.#engine('canvas');
    this.why = 'Simple map: the graphics of this device failed.';
    this.#notice();
  }

  #farm(state, collection) {
    this.farmState = state;
    if (collection) {
      this.farm = collection;
      this.labels = farmLabels(collection.features);
      this.engine?.setFarm(collection);
      this.#show();
    }
    this.#notice();
    this.#repaint();
  }

  #mission(state, collection) {
    this.missionState = state;
    if (collection || state === 'missing') {
      const model = readMission(collection);
      this.model = model;
      this.missionParcel = { ...EMPTY, features: model.parcels };
      const first = model.pieces[0]?.line;
      if (first) this.scene.settle(first[0], first[1]);
      this.scene.setMission(model.pieces.length ? model : null);
      this.engine?.setMission(this.missionParcel);
      this.#show();
      this.#update();
    }
    this.#notice();
  }

  #robotState(state) {
    const { robotId } = this.options;
    const robot = this.#robot(robotId);
    Object.assign(robot, { body: state.body ?? robot.body, mode: state.mode?.mode ?? 'unknown', text: state.mode?.text ?? '' });
    Object.assign(robot, { name: state.id?.name ?? robot.name, family: state.id?.family ?? robot.family, safety: state.safety ?? null });
    const wasStale = robot.isStale;
    if (robot.setPose(state.pose, performance.now())) trailOf(robotId).add(robot.pose, wasStale);
    this.mission = state.mission ?? null;
    this.scene.trail = trailOf(robotId);
    if (this.mission?.sha256) {
      this.missionGeometry.load(this.options.missionUrl.replace('{id}', encodeURIComponent(robotId)), { key: this.mission.sha256, isMissingOk: true });
    } else if (this.model) this.#noMission();
    this.#update();
  }

  #noMission() {
    this.missionGeometry.stop();
    this.#mission('missing', null);
    this.model = null;
    this.missionState = 'none';
  }

  #fleetState(state) {
    const now = performance.now();
    const rows = state.robots ?? {};
    for (const id of this.robots.keys()) if (!(id in rows)) this.robots.delete(id);
    for (const [id, row] of Object.entries(rows)) {
      const robot = this.#robot(id);
      robot.name = row.name ?? id;
      robot.family = row.family ?? 'other';
      robot.mode = row.mode ?? 'unknown';
      robot.text = (typeof row.why === 'string' ? row.why : row.why?.text) ?? row.text ?? '';
      robot.level = row.level ?? null;
      robot.setPose(row, now);
    }
    this.#update();
  }

  /** Places alone, ten times a second; a robot without a fleet entry is not known yet. */
  #poses(state, ids) {
    const now = performance.now();
    for (const id of ids ?? Object.keys(state.robots ?? {})) this.robots.get(id)?.setPose(state.robots[id], now);
    this.#update();
  }

  #robot(id) {
    let robot = this.robots.get(id);
    if (!robot) this.robots.set(id, (robot = new Robot(id)));
    return robot;
  }

  #update() {
    if (!this.engine || this.isGone) return;
    const began = performance.now();
    const selected = this.robots.get(this.options.robotId);
    for (const robot of this.robots.values()) {
      robot.isStale = Boolean(robot.pose) && ageOf(robot.pose) >= STALE_MS;
      robot.stop = this.stops.of(robot.id, robot.safety);
    }
    if (selected?.pose) {
      this.scene.settle(selected.pose.mx, selected.pose.my);
      if (!this.isPlaced) this.#show();
    }
    if (this.model && this.scene.model) this.scene.setProgress(progress(this.model, this.mission, selected?.pose));
    this.controls.setStop(this.options.mode === 'robot' ? selected?.stop : null);
    this.#lay(began);
    this.list.update(this.robots, (robot) => ageOf(robot.pose));
    this.host.dataset.robots = String([...this.robots.values()].filter((robot) => robot.pose).length);
    this.#notice();
    this.updateMs = performance.now() - began;
  }

  /** Put robots where they are now and move the view along. */
  #lay(now) {
    this.look = this.#look(now);
    this.scene.setRobots(this.robots.values(), this.look);
    this.#followRobot(now);
    this.#repaint();
    this.#glide(now);
  }

  #look(now) {
    return {
      now,
      selected: this.options.robotId,
      isFleet: this.options.mode === 'fleet',
      isNear: this.engine.camera.zoom > FAR_ZOOM,
      palette: this.palette,
      metresPerPx: this.engine.camera.metresPerPx,
      ageOf: (robot) => ageOf(robot.pose),
      reachOf: (robot) => (robot.isStale ? robot.reachM(ageOf(robot.pose)) : 0),
    };
  }

  #glide(now) {
    if (this.gliding || this.robots.size > 50 || matchMedia('(prefers-reduced-motion: reduce)').matches) return;
    const { worldPx } = this.engine.camera;
    if (![...this.robots.values()].some((robot) => robot.pose && robot.glidePx(now, worldPx) > GLIDE_PX)) return;
    this.gliding = setTimeout(() => requestAnimationFrame(() => {
      this.gliding = null;
      if (this.engine && !this.isGone) this.#lay(performance.now());
    }), FRAME_MS);
  }

  #followRobot(now) {
    const robot = this.robots.get(this.options.robotId);
    if (!this.isFollowing || !robot?.pose || this.engine.isBusy) return;
    const { mx, my } = robot.drawn(now);
    const view = { mx, my };
    if (robot.stop === 'not-confirmed' && !this.isRingShown) view.zoom = this.#ringZoom(robot);
    this.isRingShown = robot.stop === 'not-confirmed';
    const { camera } = this.engine;
    const offPx = Math.hypot(camera.mx - mx, camera.my - my) * camera.worldPx;
    if (offPx > 0.25 || view.zoom) this.engine.jump(view);
  }

  /** Zoom at which the keep-out ring fills the map: it is what matters then. */
  #ringZoom(robot) {
    const reach = Math.max(robot.body?.keep_out_m ?? 15, robot.reachM(ageOf(robot.pose)) ?? 0) * 1.5;
    const size = reach * mercPerMetre(robot.pose.my);
    const { mx, my } = robot.pose;
    return this.engine.camera.zoomFor([mx - size, my - size, mx + size, my + size], 24);
  }

  follow(isFollowing) {
    if (this.isFollowing === isFollowing || this.options.mode !== 'robot') return;
    this.isFollowing = isFollowing;
    this.controls.setFollowing(isFollowing);
    this.engine?.setFollowing(isFollowing);
    if (isFollowing && this.engine) this.#lay(performance.now());
  }

  /** Show all robots and the farm. */
  fit() {
    this.isPlaced = false;
    this.#show();
  }

  /** First view, as soon as there is something to look at: the robot's parcel, else the farm, else the robot. */
  #show() {
    if (!this.engine) return;
    this.controls.setFollowing(this.isFollowing);
    const pose = this.robots.get(this.options.robotId)?.pose;
    if (this.options.mode === 'robot' && pose) {
      if (this.isPlaced) return;
      this.isPlaced = true;
      this.engine.jump({ mx: pose.mx, my: pose.my, zoom: ROBOT_ZOOM });
      return;
    }
    if (this.isPlaced) return;
    const box = this.#farmBox();
    if (!box) return;
    this.isPlaced = this.options.mode === 'fleet' && this.robots.size > 0;
    const zoom = Math.min(this.engine.camera.zoomFor(box, 48), ROBOT_ZOOM);
    this.engine.jump({ mx: (box[0] + box[2]) / 2, my: (box[1] + box[3]) / 2, zoom });
  }

  #farmBox() {
    const points = [...this.robots.values()].filter((robot) => robot.pose).map(({ pose }) => ({ geometry: { type: 'Point', coordinates: [pose.lon, pose.lat] } }));
    return boxOf([...this.farm.features, ...(this.missionParcel?.features ?? []), ...points]);
  }

  #moved() {
    if (!this.engine) return;
    this.controls.setCamera(this.engine.camera);
  }

  #framed() {
    if (!this.engine || this.isGone) return;
    const { camera } = this.engine;
    const labels = this.shown.labels ? readableLabels(this.labels, camera) : [];
    if (this.look) labels.push(...robotLabels(this.robots.values(), { ...this.look, metresPerPx: camera.metresPerPx, isNear: camera.zoom > FAR_ZOOM }));
    this.labelLayer.draw(camera, labels, this.palette);
    this.frameNumber += 1;
    this.host.dataset.frame = String(laneRevision() ?? this.frameNumber);
  }

  #repaint() {
    this.engine?.redraw();
  }

  #watch() {
    if (!this.engine) return;
    const now = performance.now();
    const changed = [...this.robots.values()].some((robot) => robot.pose && robot.isStale !== ageOf(robot.pose) >= STALE_MS);
    const grows = [...this.robots.values()].some((robot) => robot.isStale || robot.stop === 'not-confirmed');
    if (changed || (grows && now - (this.grown ?? 0) >= GROW_MS)) {
      this.grown = now;
      this.#update();
    } else this.#notice();
  }

  #theme(palette) {
    this.palette = palette;
    this.scene.setPalette(palette);
    this.engine?.setPalette(palette);
    this.#update();
  }

  #layer(name, isOn) {
    this.shown[name] = isOn;
    keepLayers(this.shown);
    if (name === 'surroundings') this.engine?.showSurroundings(isOn);
    this.#repaint();
  }

  #retry() {
    this.features.retry();
    this.missionGeometry.retry();
  }

  #tapped(x, y) {
    this.controls.closeMenu();
    let best = null;
    let off = TAP_PX;
    for (const robot of this.robots.values()) {
      if (!robot.pose) continue;
      const [rx, ry] = this.engine.camera.project(robot.pose.mx, robot.pose.my);
      if (Math.hypot(rx - x, ry - y) < off) [best, off] = [robot, Math.hypot(rx - x, ry - y)];
    }
    if (best) this.options.onSelect?.(best.id);
  }

  #key(event) {
    if (event.target.closest('.hl-map-menu, button') || !this.engine) return;
    const { camera } = this.engine;
    const step = { ArrowLeft: [-80, 0], ArrowRight: [80, 0], ArrowUp: [0, -80], ArrowDown: [0, 80] }[event.key];
    if (event.key === '+' || event.key === '=') this.engine.ease({ zoom: camera.zoom + 1 });
    else if (event.key === '-') this.engine.ease({ zoom: camera.zoom - 1 });
    else if (step && event.shiftKey) { // plain arrows drive the robot
      this.follow(false);
      const [mx, my] = camera.unproject(camera.width / 2 + step[0], camera.height / 2 + step[1]);
      this.engine.ease({ mx, my });
    } else return;
    event.preventDefault();
  }

  /** Never a blank map without a word. */
  #notice() {
    const [text, how] = this.#words();
    this.controls.setNotice(text, how);
  }

  #words() {
    const name = this.robots.get(this.options.robotId)?.name ?? this.options.robotId;
    if (!this.engine) return ['Loading map', {}];
    if (this.farmState === 'forbidden') return ['This map is not shared with you.', {}];
    if (this.farmState === 'failed') return ['Map did not load. It is asked for again.', { canRetry: true }];
    if (this.missionState === 'failed') return ['Mission lines did not load. They are asked for again.', { canRetry: true }];
    if (this.farmState === 'loading') return ['Loading map', {}];
    const hasRobot = [...this.robots.values()].some((robot) => robot.pose);
    if (this.options.mode === 'robot' && !this.options.robotId) return ['No robot chosen.', {}];
    if (!hasRobot && this.options.mode === 'robot') return [`No position from ${name} yet.`, {}];
    if (!this.farm.features.length && !hasRobot) return ['No fields and no robots on the map yet.', {}];
    return [this.why, { isSmall: true }];
  }

  /** Plain facts about what is drawn. */
  describe() {
    const { engine } = this;
    const camera = engine && { lon: lonOf(engine.camera.mx), lat: latOf(engine.camera.my), zoom: engine.camera.zoom, bearing: engine.camera.bearing, metresPerPx: engine.camera.metresPerPx };
    return {
      engine: engine?.kind ?? null,
      camera,
      isFollowing: this.isFollowing,
      frame: this.frameNumber,
      updateMs: this.updateMs,
      labels: this.labelLayer.drawn ?? 0,
      farm: this.farmState,
      mission: this.missionState,
      piece: this.scene.progress?.at ?? null,
      robots: [...this.robots.values()].filter((robot) => robot.pose).map((robot) => ({
        id: robot.id, lon: robot.pose.lon, lat: robot.pose.lat, isStale: robot.isStale, stop: robot.stop,
        reachM: this.look?.reachOf(robot) ?? null,
      })),
    };
  }

  destroy() {
    this.isGone = true;
    clearInterval(this.watch);
    clearTimeout(this.gliding);
    clearTimeout(this.lostTimer);
    this.topics?.forEach((lane) => lane.destroy());
    this.stops?.destroy();
    this.features?.stop();
    this.missionGeometry?.stop();
    this.unwatch?.();
    if (this.keys) this.host.removeEventListener('keydown', this.keys);
    this.engine?.destroy();
    this.labelLayer.destroy();
    this.controls.destroy();
    this.list.destroy();
    this.surface.remove();
  }
}

function readLayers() {
  const usual = Object.fromEntries(LAYERS.map(([name]) => [name, true]));
  try {
    return { ...usual, ...JSON.parse(localStorage.getItem(LAYER_KEY) ?? '{}') };
  } catch {
    return usual; // private mode, or a value of an older version
  }
}

function keepLayers(shown) {
  try {
    localStorage.setItem(LAYER_KEY, JSON.stringify(shown));
  } catch {
    // a full or forbidden storage only means that the choice is not remembered
  }
}

let shownMap = null;

/** Make `map` the one behind `window.headlandMap`; null gives the place up if `former` still holds it. */
export function publish(map, former = null) {
  if (map) shownMap = map;
  else if (shownMap === former) shownMap = null;
}

/** For tests and support: where things are drawn, and what the map believes. */
window.headlandMap = {
  /** lon/lat -> [x, y] in CSS px of the viewport, or null without a map. */
  project(lon, lat) {
    if (!shownMap?.engine) return null;
    const box = shownMap.host.getBoundingClientRect();
    const [x, y] = shownMap.engine.camera.project(mercX(lon), mercY(lat));
    return [box.left + x, box.top + y];
  },
  state() {
    return shownMap?.describe() ?? null;
  },
};
