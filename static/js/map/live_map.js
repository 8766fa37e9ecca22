// The live map: farm, mission, robots, marks and controls on one element. See components/live_map.py for its options.

import { farmLabels, readableLabels, robotLabels } from './captions.js';
import { loadBase } from './base_loader.js';
import { Controls } from './controls.js';
import { Covered } from './covered.js';
import { startEngine } from './engine_choice.js';
import { laneRevision } from './feed.js';
import { NO_FLEET, loadFleet } from './fleet_none.js';
import { FieldRows } from './field_rows.js';
import { mercX, mercY } from './geometry.js';
import { Intake } from './intake.js';
import { areaLabels } from './areas.js';
import { LabelLayer } from './labels.js';
import { keyedWay } from './keyed_way.js';
import { LAYERS, baseChoice, keepLayers, readLayers } from './layers.js';
import { noticeOf } from './notice.js';
import { robotAt } from './robots.js';
import { RobotList } from './robot_list.js';
import { Scene } from './scene.js';
import { LOST_CONTEXT_MS, USUAL } from './options.js';
import { readPalette, watchTheme } from './theme.js';
import { trailOf } from './trail.js';
import { Viewpoint } from './viewpoint.js';

export { publish } from './published.js';

const WATCH_MS = 250; // how often ages are looked at between updates
const GROW_MS = 500; // how often growing circles are drawn anew
const GLIDE_PX = 0.75; // smaller steps between poses cannot be seen
const FRAME_MS = 40; // 25 pictures a second while gliding
const MOST_GLIDING = 50;
const CROWD = 150; // robots beyond which places are brought onto the map together, as often as one of them reports
const CROWD_MS = 500;
const NAMES_ZOOM = 15.5;
const NO_ROWS = [];

export class LiveMap {
  /** options: {robotId, mode, hasButtons, featuresUrl, missionUrl, vendorUrl, engine, onSelect(id)}. */
  constructor(host, options) {
    this.host = host;
    host.hlMap = this; // what else is on the screen speaks to the map by its element
    this.options = { ...USUAL, ...options };
    this.viewpoint = new Viewpoint(this);
    this.shown = readLayers();
    this.frameNumber = 0;
    this.covered = new Covered(host);
    this.engineNote = '';
    this.palette = readPalette();
    this.scene = new Scene(this.palette);
    this.scene.shown = this.shown;
    this.intake = new Intake(this.options, (what) => this.#told(what));
    host.classList.add('hl-map');
    this.surface = document.createElement('div');
    this.surface.className = 'hl-map-surface';
    host.append(this.surface);
    this.fleet = NO_FLEET;
    this.labelLayer = new LabelLayer(host);
    this.controls = this.#controls();
    this.controls.setFollowing(this.viewpoint.isFollowing);
    this.list = new RobotList(host);
    this.rows = new FieldRows(this);
    this.#notice();
  }

  #controls() {
    return new Controls(this.host, {
      mode: this.options.mode,
      hasButtons: this.options.hasButtons,
      layers: LAYERS.map(([name, label]) => ({ name, label, isOn: this.shown[name] })),
      act: {
        follow: () => this.follow(!this.viewpoint.isFollowing),
        fit: () => this.viewpoint.fit(),
        zoom: (step) => this.#zoom(step),
        north: () => this.engine?.ease({ bearing: 0 }),
        layer: (name, isOn) => this.#layer(name, isOn),
        retry: () => this.intake.retry(),
        menu: (menu) => this.#under(menu),
      },
    });
  }

  /** Load the engine and the data; never rejects: what goes wrong is said on the map. */
  async start() {
    this.intake.start();
    this.unwatch = watchTheme((palette) => this.#theme(palette));
    this.watch = setInterval(() => this.#watch(), WATCH_MS);
    this.host.addEventListener('keydown', (this.keys = (event) => this.#key(event)));
    if (this.options.mode !== 'robot') await loadFleet(this);
    await this.#start(this.options.engine);
  }

  async #start(wanted) {
    const hooks = {
      moved: (isByHand) => { this.viewpoint.isZoomChosen ||= isByHand; this.#moved(); },
      resized: () => this.viewpoint.resized(),
      panned: () => this.follow(false),
      framed: () => this.#framed(),
      tapped: (x, y) => this.#tapped(x, y),
      lost: () => { this.lostTimer = setTimeout(() => this.#fallBack(), LOST_CONTEXT_MS); },
      restored: () => clearTimeout(this.lostTimer),
    };
    const view = this.lastView ?? { mx: mercX(10), my: mercY(50), zoom: 5, bearing: 0 };
    const setup = { scene: this.scene, palette: this.palette, view, vendor: this.options.vendorUrl, hooks };
    const { engine, note } = await startEngine(wanted, this.surface, setup);
    this.engineNote = note || this.engineNote;
    if (this.isGone) engine.destroy();
    else this.#ready(engine);
  }

  #ready(engine) {
    this.engine = engine;
    this.scene.camera = engine.camera;
    this.host.dataset.engine = engine.kind;
    engine.setPalette(this.palette); // the theme may have changed while the engine was loading
    engine.showSurroundings(this.shown.surroundings);
    engine.setFollowing(this.viewpoint.isFollowing);
    this.#told('farm');
    this.#told('mission');
    this.base?.attach(engine, this.palette);
    if (baseChoice()) this.#under();
    this.#moved();
  }

  #under(menu) {
    return loadBase(this, menu, (isLook) => (isLook ? this.#theme(readPalette()) : this.#notice()));
  }

  /** The graphics context is gone for good: go on without it. */
  async #fallBack() {
    const { engine } = this;
    this.lastView = { ...engine.camera };
    this.engine = null;
    engine.destroy();
    this.surface.replaceChildren();
    this.engineNote = 'Simple map: the graphics of this device failed.';
    if (!this.isGone) await this.#start('canvas');
  }

  #told(what) {
    if (this.isGone) return;
    if (what === 'farm') {
      this.labels = farmLabels(this.intake.farm.features);
      this.engine?.setFarm(this.intake.farm);
      this.#rows();
    } else if (what === 'mission') {
      const first = this.intake.model?.pieces[0].line;
      if (first) this.scene.settle(first[0], first[1]);
      this.scene.setMission(this.intake.model);
      this.#doses();
      this.engine?.setMission(this.intake.parcels);
      this.viewpoint.showField();
    }
    if (what === 'state') this.#notice();
    else if (what === 'places' && this.intake.robots.size > CROWD) this.#soon();
    else this.#update();
  }

  /** A thousand robots report at a thousand moments: one picture takes in all that came since the last one. */
  #soon() {
    this.gathering ??= setTimeout(() => this.#update(), Math.max(0, CROWD_MS - (performance.now() - (this.updated ?? -Infinity))));
  }

  #update(isUrgent = false) {
    const { engine, intake, scene } = this;
    clearTimeout(this.gathering);
    this.gathering = null;
    if (!engine || this.isGone) return;
    this.updated = performance.now();
    const hasChanged = intake.judge() || isUrgent;
    const { selected } = intake;
    if (selected?.pose) {
      scene.settle(selected.pose.mx, selected.pose.my);
      scene.trail = trailOf(selected.id);
    }
    else this.fleet.settle();
    this.viewpoint.place();
    if (intake.model) scene.setProgress(intake.progress());
    if (hasChanged || this.#isSeenToMove()) this.#draw(hasChanged);
    else this.#said(); // the picture is still true
    this.list.update(intake.robots, intake.clock);
    this.host.dataset.robots = String(intake.placed);
    this.#notice();
  }

  /** In a crowd, seen from afar, most reports move nothing by as much as a pixel. */
  #isSeenToMove() {
    const { robots } = this.intake;
    if (robots.size <= CROWD || this.laidCount !== robots.size || this.laidView !== this.#viewKey()) return true;
    const { worldPx } = this.engine.camera;
    for (const robot of robots.values()) if (robot.pose && robot.hasMoved(worldPx)) return true;
    return false;
  }

  #viewKey() {
    const { zoom, bearing, width, height } = this.engine.camera;
    return `${zoom}|${bearing}|${width}|${height}`;
  }

  /** Draw now, or as soon as the graphics have caught up: on weak ones pictures must not pile up. */
  #draw(isUrgent = false) {
    const wait = isUrgent ? 0 : this.engine.waitMs();
    if (wait > 0) {
      this.later ??= setTimeout(() => {
        this.later = null;
        if (this.engine && !this.isGone) this.#lay(performance.now());
      }, wait);
      return;
    }
    clearTimeout(this.later);
    this.later = null;
    this.#lay(performance.now());
  }

  /** Put robots where they are now and move the view along. */
  #lay(now) {
    const { clock } = this.intake;
    this.look = {
      now,
      count: this.intake.robots.size,
      selected: this.options.robotId,
      isFleet: this.options.mode === 'fleet',
      ageOf: (robot) => robot.ageMs(clock),
      reachOf: (robot) => (robot.isStale ? robot.reachM(robot.ageMs(clock)) : 0),
    };
    this.fleet.gather(this.look);
    this.scene.setRobots(this.intake.robots.values(), this.look);
    this.viewpoint.keepUp(now, this.look);
    this.laidCount = this.intake.robots.size;
    this.laidView = this.#viewKey();
    if (this.laidCount > CROWD) for (const robot of this.intake.robots.values()) if (robot.pose) robot.lay();
    this.engine.redraw();
    this.#glide(now);
  }

  #glide(now) {
    if (this.gliding || this.intake.robots.size > MOST_GLIDING) return;
    const { worldPx } = this.engine.camera;
    const moves = [...this.intake.robots.values()].some((robot) => robot.pose && robot.glidePx(now, worldPx) > GLIDE_PX);
    if (!moves || matchMedia('(prefers-reduced-motion: reduce)').matches) return;
    this.gliding = setTimeout(() => requestAnimationFrame(() => {
      this.gliding = null;
      if (this.engine && !this.isGone) this.#draw();
    }), FRAME_MS);
  }

  /** Keep the robot in the middle, or stop doing so. */
  follow(isFollowing) {
    if (!this.viewpoint.follow(isFollowing)) return;
    this.controls.setFollowing(isFollowing);
    this.engine?.setFollowing(isFollowing);
    if (isFollowing && this.engine) this.#lay(performance.now());
  }

  #zoom(step) {
    this.viewpoint.isZoomChosen = true;
    this.engine?.ease({ zoom: this.engine.camera.zoom + step });
  }

  #moved() {
    if (!this.engine) return;
    this.controls.setCamera(this.engine.camera);
    this.base?.moved();
    this.#rows();
    if (this.fleet.isOutgrown) this.#draw();
  }

  #framed() {
    if (!this.engine || this.isGone) return;
    const { camera } = this.engine;
    const wasDrawn = this.isDrawn;
    this.isDrawn = this.engine.isFarmDrawn; // no names without their fields
    const labels = this.shown.labels && this.isDrawn ? [...readableLabels(this.labels, camera), ...areaLabels(this.intake.model?.areas ?? [], camera)] : [];
    const look = { ...this.look, palette: this.palette, metresPerPx: camera.metresPerPx, isNear: this.fleet.said?.layers?.names ?? camera.zoom > NAMES_ZOOM };
    if (this.look) {
      labels.push(...robotLabels(this.fleet.single(this.intake.robots.values(), look), look), ...this.fleet.drawClusters(camera, this.palette));
    }
    this.labelLayer.block(this.covered.boxes());
    this.labelLayer.draw(camera, labels, this.palette);
    this.frameNumber += 1;
    if (this.isDrawn && !wasDrawn) this.#notice(); // until now the map said that it is loading
    this.#said();
  }

  /** Up to which revision of the lane the picture is true. */
  #said() {
    this.host.dataset.frame = String(laneRevision() ?? this.frameNumber);
  }

  #watch() {
    if (!this.engine) return;
    const now = performance.now();
    if (this.intake.robots.size > CROWD && now - (this.updated ?? 0) < CROWD_MS) return; // its reports bring ages up to date
    const hasChanged = this.intake.judge();
    if (hasChanged || (this.intake.isGrowing && now - (this.grown ?? 0) >= GROW_MS)) {
      this.grown = now;
      this.#update(hasChanged);
    }
  }

  #theme(plain) {
    const palette = this.base?.palette(plain) ?? plain;
    this.palette = palette;
    this.scene.setPalette(palette);
    this.engine?.setPalette(palette);
    this.#update();
  }

  async #doses() {
    const { model } = this.intake;
    if (!this.doses && !model?.areas.length && !model?.pieces.some((one) => one.dose !== 1)) return;
    try {
      const { DoseLegend } = await import('./dose_legend.js');
      this.doses ??= new DoseLegend(this.host);
      this.doses.show(this.intake.model); // the one of now: another may have come meanwhile
    } catch (error) {
      console.warn('map: the legend of doses did not load:', error);
    }
  }

  #rows() {
    if (this.engine) this.rows.later(this.shown.rows ? this.intake.farm.features : NO_ROWS);
  }

  #layer(name, isOn) {
    this.shown[name] = isOn;
    keepLayers(this.shown);
    if (name === 'rows') this.#rows();
    if (name === 'surroundings') this.engine?.showSurroundings(isOn);
    this.engine?.redraw();
  }

  #tapped(x, y) {
    this.controls.closeMenu();
    const best = robotAt(this.intake.robots.values(), this.engine.camera, x, y, this.look?.isHidden);
    if (!best) return void this.fleet.tapped(x, y);
    this.options.onSelect?.(best.id);
    if (this.fleet.said) window.dispatchEvent(new CustomEvent('headland:map-robot', { detail: best.id }));
    return undefined;
  }

  /** What the list beside the map says, see FleetView. */
  setFleet(fleet) {
    const need = this.fleet.set(fleet);
    if (!need || !this.engine) return;
    if (need === 'now' || this.intake.robots.size <= CROWD) return void (this.viewpoint.place(), this.#draw(true));
    this.laidCount = 0; // the next picture has it
    this.#soon();
  }

  #key(event) {
    if (event.target.closest('.hl-map-menu, button') || !this.engine) return;
    const way = keyedWay(event, this.engine.camera);
    if (!way) return;
    if (way.zoom) this.#zoom(way.zoom);
    else {
      this.follow(false);
      this.engine.ease(way);
    }
    event.preventDefault();
  }

  #notice() {
    const [text, how] = noticeOf(this.intake, { isReady: Boolean(this.engine) && this.isDrawn, engineNote: [this.engineNote, this.engine && this.base?.note].filter(Boolean).join(' ') });
    this.controls.setNotice(text, how);
  }

  destroy() {
    this.isGone = true;
    clearInterval(this.watch);
    for (const timer of [this.gliding, this.later, this.gathering, this.lostTimer]) clearTimeout(timer);
    this.unwatch?.();
    if (this.keys) this.host.removeEventListener('keydown', this.keys);
    for (const part of [this.intake, this.fleet, this.base, this.engine, this.labelLayer, this.controls, this.list, this.rows]) part?.destroy();
    this.surface.remove();
  }
}
