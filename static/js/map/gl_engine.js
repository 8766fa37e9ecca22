// MapLibre GL behind the same small interface as the 2D canvas engine. Loaded only when a map is on screen.

import { Camera, latOf, lonOf, mercX, mercY } from './geometry.js';
import { FramePace } from './frame_pace.js';
import { FARM_LAYERS, SURROUNDINGS, farmStyle, themedPaints } from './farm_style.js';
import { SceneLayer } from './gl_layer.js';

const MAX_ZOOM = 23.5;
const MIN_ZOOM = 3;
const EASE_MS = 180;
let library = null;

/** Import MapLibre and its worker from our own origin, once per page. */
async function load(base) {
  library ??= import(`${base}/maplibre-gl.mjs`).then((maplibre) => {
    maplibre.setWorkerUrl(new URL(`${base}/maplibre-gl-worker.mjs`, location.href).href);
    return maplibre;
  });
  try {
    return await library;
  } catch (error) {
    library = null; // a later attempt may find the server again
    throw error;
  }
}

/** True where WebGL 2 works. */
export class GlEngine {
  kind = 'gl';
  gone = new Set(); // graphics contexts that were lost
  asked = null;
  isLoaded = false;
  #isFarmDrawn = false;
  #hasFarm = false;
  #pace = new FramePace();

  /** hooks: {moved(byUser), panned(), framed(), failed(error)}. */
  static async create(host, { scene, palette, view, vendor, hooks }) {
    const maplibre = await load(vendor);
    const engine = new GlEngine();
    await engine.#start(maplibre, host, scene, palette, view, hooks);
    return engine;
  }

  #start(maplibre, host, scene, palette, view, hooks) {
    this.scene = scene;
    this.hooks = hooks;
    this.camera = new Camera();
    this.map = new maplibre.Map({
      container: host,
      style: farmStyle(palette, latOf(view.my)),
      center: [lonOf(view.mx), latOf(view.my)],
      zoom: view.zoom,
      bearing: view.bearing,
      minZoom: MIN_ZOOM,
      maxZoom: MAX_ZOOM,
      maxPitch: 0,
      attributionControl: false,
      maplibreLogo: false,
      keyboard: false, // arrow keys drive the robot
      boxZoom: false,
      touchPitch: false,
      pitchWithRotate: false,
      renderWorldCopies: false,
      fadeDuration: 0,
      canvasContextAttributes: { antialias: false },
    });
    const { map } = this;
    this.#measure();
    this.#sync();
    map.on('move', (event) => { this.#sync(); hooks.moved(Boolean(event.originalEvent)); });
    map.on('dragstart', () => hooks.panned());
    map.on('render', () => { this.#sync(); this.#frame(); });
    map.on('resize', () => { this.#measure(); this.#sync(); hooks.moved(false); hooks.resized?.(); });
    map.on('click', (event) => hooks.tapped(event.point.x, event.point.y));
    map.on('webglcontextlost', () => this.#lost('map'));
    map.on('webglcontextrestored', () => this.#restored('map'));
    this.layer = new SceneLayer(scene, this.camera, host, { lost: () => this.#lost('scene'), restored: () => this.#restored('scene') });
    return new Promise((resolve, reject) => {
      map.once('error', (event) => reject(event.error));
      map.once('style.load', () => { this.isLoaded = true; resolve(); });
    });
  }

  /** A picture: the farm's, if it was drawn, lies below already. */
  #frame() {
    cancelAnimationFrame(this.asked);
    this.asked = null;
    const { width, height } = this.map.getCanvas();
    if (this.isLoaded) this.layer.draw(width, height); // before, nobody has told the scene how it is looked at
    this.hooks.framed();
    this.#pace.drawn();
  }

  /** Both contexts go together as a rule; the map is whole again when both are back. */
  #lost(which) {
    this.gone.add(which);
    if (this.gone.size === 1) this.hooks.lost();
  }

  #restored(which) {
    this.gone.delete(which);
    if (!this.gone.size) this.hooks.restored();
    this.repaint();
  }

  /** Only when the size changed: asking the page for it forces a layout. */
  #measure() {
    const box = this.map.getContainer();
    this.camera.width = box.clientWidth || 1;
    this.camera.height = box.clientHeight || 1;
  }

  #sync() {
    const { camera, map } = this;
    const centre = map.getCenter();
    camera.mx = mercX(centre.lng);
    camera.my = mercY(centre.lat);
    camera.zoom = map.getZoom();
    camera.bearing = map.getBearing();
  }

  /** Whether the farm's shapes are in the picture: they are cut into tiles beside the page, which takes a moment. */
  get isFarmDrawn() {
    this.#isFarmDrawn ||= this.isLoaded && this.map.isSourceLoaded('farm');
    return this.#isFarmDrawn;
  }

  setFarm(collection) {
    if (!this.#hasFarm) this.#isFarmDrawn = false;
    this.#hasFarm = collection.features.length > 0;
    this.map.getSource('farm')?.setData(collection);
  }

  setRows(collection) {
    this.map.getSource('rows')?.setData(collection);
  }

  setMission(collection) {
    this.map.getSource('mission')?.setData(collection);
  }

  setPalette(palette) {
    for (const [layer, key, name] of themedPaints()) {
      if (this.map.getLayer(layer)) this.map.setPaintProperty(layer, key, palette[name]);
    }
    this.redraw();
  }

  showSurroundings(isShown) {
    for (const { id } of FARM_LAYERS) {
      if (!SURROUNDINGS.has(id)) continue;
      for (const layer of [id, `${id}-edge`]) {
        if (this.map.getLayer(layer)) this.map.setLayoutProperty(layer, 'visibility', isShown ? 'visible' : 'none');
      }
    }
  }

  /** Draw what moves; the farm below stays as it is. */
  redraw() {
    this.#pace.asked();
    this.asked ??= requestAnimationFrame(() => this.#frame());
  }

  /** Draw the farm, too. */
  repaint() {
    this.map.triggerRepaint();
  }

  /** Ms until the graphics can take another picture without falling behind. */
  waitMs() {
    return this.#pace.waitMs();
  }

  /** True while a finger or an animation moves the map: following then waits. */
  get isBusy() {
    return this.map.isMoving();
  }

  jump({ mx = this.camera.mx, my = this.camera.my, zoom = this.camera.zoom, bearing = this.camera.bearing }) {
    this.map.jumpTo({ center: [lonOf(mx), latOf(my)], zoom, bearing });
  }

  ease({ mx = this.camera.mx, my = this.camera.my, zoom = this.camera.zoom, bearing = this.camera.bearing }) {
    this.map.easeTo({ center: [lonOf(mx), latOf(my)], zoom, bearing, duration: EASE_MS });
  }

  /** While following, zooming keeps the robot in the middle. */
  setFollowing(isFollowing) {
    const around = isFollowing ? { around: 'center' } : {};
    this.map.scrollZoom.disable();
    this.map.scrollZoom.enable(around);
    this.map.touchZoomRotate.disable();
    this.map.touchZoomRotate.enable(around);
  }

  destroy() {
    cancelAnimationFrame(this.asked);
    this.layer.destroy();
    this.map.remove();
  }
}
