// The map under the drawing: engine, names, buttons. Falls back to the canvas map, on which nothing can be drawn.

import { CanvasEngine } from '../map/canvas_engine.js';
import { farmLabels, readableLabels } from '../map/captions.js';
import { Controls } from '../map/controls.js';
import { boxOf, latOf, lonOf, mercX, mercY } from '../map/geometry.js';
import { farmWidths } from '../map/farm_style.js';
import { GlEngine } from '../map/gl_engine.js';
import { webgl } from '../map/webgl.js';
import { LabelLayer } from '../map/labels.js';
import { Scene } from '../map/scene.js';
import { baseChoice } from '../map/layers.js';
import { readPalette, watchTheme } from '../map/theme.js';
import { addEditorStyle, paintEditorStyle, showBed, showStrips } from './editor_style.js';
import { idOf } from './draft.js';
import { siteToShow } from './sites.js';

const LOST_CONTEXT_MS = 3000;
const FREE_PX = 52; // for handles and lengths of edges
const NEAREST_ZOOM = 20.5; // a single corner must not fill the screen
const BELOW_PX = 20;
const SAME_SCALE_DEG = 0.5; // a metre is drawn within 1 % of what it should be
const START = { mx: mercX(10), my: mercY(50), zoom: 5, bearing: 0 };

export class Surface {
  /** hooks: {moved(), framed(), palette(), lost()}. */
  constructor(host, { vendorUrl, baseMapsUrl, hooks }) {
    this.baseMapsUrl = baseMapsUrl;
    this.host = host;
    this.vendorUrl = vendorUrl;
    this.hooks = hooks;
    this.palette = readPalette();
    this.labels = new WeakMap();
    this.element = document.createElement('div');
    this.element.className = 'hl-map-surface';
    host.classList.add('hl-map', 'hl-edit');
    host.append(this.element);
    this.names = new LabelLayer(host);
    this.names.canvas.classList.add('hl-edit-names');
    this.shownNames = [];
  }

  /** Start the engine; false where only the canvas map runs. */
  async start() {
    const hooks = {
      moved: () => this.#moved(),
      panned: () => {},
      framed: () => this.#framed(),
      tapped: () => {},
      lost: () => { this.lostTimer = setTimeout(() => this.#fallBack(), LOST_CONTEXT_MS); },
      restored: () => clearTimeout(this.lostTimer),
    };
    this.setup = { scene: new Scene(this.palette), palette: this.palette, view: START, vendor: this.vendorUrl, hooks };
    const engine = (await this.#gl()) ?? (await CanvasEngine.create(this.element, this.setup));
    this.#settle(engine);
    this.unwatch = watchTheme((palette) => this.#theme(palette));
    return engine.kind === 'gl';
  }

  async #gl() {
    try {
      if (webgl() !== 'none') return await GlEngine.create(this.element, this.setup);
    } catch (error) {
      console.warn('map builder: the GL engine did not start:', error);
    }
    this.element.replaceChildren();
    return null;
  }

  #settle(engine) {
    this.engine = engine;
    this.host.dataset.engine = engine.kind;
    engine.setPalette(this.palette);
    this.scaledAt = latOf(START.my);
    if (engine.kind === 'gl') addEditorStyle(engine.map, this.palette);
    this.element.querySelector('canvas').tabIndex = -1; // the host around it is the one stop of the Tab key
    this.controls ??= this.#controls();
    this.base?.attach(engine, this.palette);
    if (baseChoice()) this.#under();
    this.#moved();
  }

  #controls() {
    const controls = new Controls(this.host, {
      mode: 'fleet',
      hasButtons: true,
      layers: [],
      act: {
        fit: () => this.hooks.fit(),
        zoom: (step) => this.engine.ease({ zoom: this.camera.zoom + step }),
        north: () => this.engine.ease({ bearing: 0 }),
        menu: (menu) => this.#under(menu),
      },
    });
    controls.first.title = 'Show the whole site, again: the next one';
    controls.first.setAttribute('aria-label', 'Show the whole site');
    controls.menuButton.title = 'Base map';
    controls.menuButton.setAttribute('aria-label', 'Base map');
    return controls;
  }

  /** Base maps load when one was chosen, or when the menu asks what there is. */
  async #under(menu) {
    if (!this.baseMapsUrl) return;
    try {
      const { BaseMaps } = await import('../map/base_maps.js');
      if (this.isGone) return;
      if (!this.base) {
        this.base = new BaseMaps({ host: this.host, url: this.baseMapsUrl, changed: (isLook) => (isLook ? this.#theme(readPalette()) : this.#said()) });
        this.base.attach(this.engine, this.palette);
      }
      if (menu) this.base.fill(menu);
    } catch (error) {
      console.warn('map builder: base maps did not load:', error);
      this.controls.setNotice('Base map did not load. Showing plain ground.', { isSmall: true });
    }
  }

  /** Lay a base map with these bounds under the map and bring it into view. */
  async showBase(id, [west, south, east, north]) {
    await this.#under();
    await this.base?.load();
    this.base?.choose(id);
    this.fit([{ geometry: { type: 'LineString', coordinates: [[west, south], [east, north]] } }]);
  }

  #said() {
    this.controls.setNotice(this.base.note, { isSmall: true });
  }

  async #fallBack() {
    const view = { ...this.camera };
    this.engine.destroy();
    this.element.replaceChildren();
    this.#settle(await CanvasEngine.create(this.element, { ...this.setup, view }));
    this.setFeatures(this.features);
    this.hooks.lost();
  }

  get camera() {
    return this.engine.camera;
  }

  get isEditable() {
    return this.engine?.kind === 'gl';
  }

  /** Show features, all anew. */
  setFeatures(features) {
    this.features = features;
    this.engine?.setFarm({ type: 'FeatureCollection', features: features.map(withId) });
    this.#relabel();
  }

  /** Replace single features: the others are not sent to the worker again. */
  update({ features, removed = [], changed = [], isRelabelled = true }) {
    this.features = features;
    const source = this.isEditable ? this.engine.map.getSource('farm') : null;
    if (!source) this.setFeatures(features);
    else source.updateData({ remove: removed, add: changed.map(withId) });
    if (isRelabelled) this.#relabel();
  }

  /** Names stand on everything but what is in hand. */
  setUnnamed(ids) {
    this.unnamed = new Set(ids);
    this.#relabel();
  }

  #relabel() {
    this.shownNames = this.features.flatMap((feature) => {
      if (this.unnamed?.has(idOf(feature))) return [];
      let labels = this.labels.get(feature);
      if (!labels) this.labels.set(feature, (labels = farmLabels([feature]).map((label) => besidePoint(label, feature))));
      return labels;
    });
    this.redraw();
  }

  showBed(beds) {
    if (this.isEditable) showBed(this.engine.map, beds, latOf(this.camera.my));
  }

  showStrips(lines) {
    this.host.dataset.strips = lines.length;
    if (this.isEditable) showStrips(this.engine.map, lines);
  }

  redraw() {
    this.engine?.repaint();
  }

  /** While a corner is dragged, the map itself must not move. */
  hold() {
    this.#hands(false, false);
  }

  /** Let two fingers move the map. Not as a tap: the first finger dragged something, and lifting both must not zoom. */
  share() {
    this.#hands(true, false);
  }

  /** Give the fingers back to the map; `isDrawing`: a double tap ends the drawing instead of zooming. */
  release(isDrawing) {
    this.#hands(true, !isDrawing);
  }

  #hands(isMoving, isDoubleZooming) {
    if (!this.isEditable) return;
    const { map } = this.engine;
    for (const name of ['dragPan', 'touchZoomRotate']) map[name][isMoving ? 'enable' : 'disable']();
    map.doubleClickZoom[isDoubleZooming ? 'enable' : 'disable']();
  }

  /** Bring features into view; false when they have no place. */
  fit(features) {
    const box = boxOf(features);
    if (!box) return false;
    this.#rescale(latOf((box[1] + box[3]) / 2));
    this.engine.jump(this.#viewOf(box));
    return true;
  }

  /** Bring the site at hand into view, or the next one where it stands already. */
  fitSite(features) {
    return this.fit(siteToShow(features, this.camera, (box) => this.#viewOf(box)));
  }

  #viewOf(box) {
    return this.camera.viewOf(box, this.controls.freePx(FREE_PX), NEAREST_ZOOM);
  }

  /** Widths and radii in metres are right at one latitude: that of the farm, which is known with its first features. */
  #rescale(lat) {
    if (!this.isEditable || Math.abs(lat - this.scaledAt) < SAME_SCALE_DEG) return;
    this.scaledAt = lat;
    for (const [layer, key, value] of farmWidths(lat)) this.engine.map.setPaintProperty(layer, key, value);
  }

  toPx([lon, lat]) {
    return this.camera.project(mercX(lon), mercY(lat));
  }

  toLonLat([x, y]) {
    const [mx, my] = this.camera.unproject(x, y);
    return [lonOf(mx), latOf(my)];
  }

  #moved() {
    if (!this.engine) return;
    this.controls?.setCamera(this.engine.camera);
    this.base?.moved();
    this.hooks.moved();
  }

  #framed() {
    if (!this.engine) return;
    const names = this.engine.isFarmDrawn ? readableLabels(this.shownNames, this.camera) : []; // no names without their fields
    this.names.draw(this.camera, names, this.palette);
    this.hooks.framed();
  }

  #theme(plain) {
    const palette = this.base?.palette(plain) ?? plain;
    if (this.base) this.#said();
    this.palette = palette;
    this.engine.setPalette(palette);
    if (this.isEditable) paintEditorStyle(this.engine.map, palette);
    this.hooks.palette();
  }

  destroy() {
    this.isGone = true;
    clearTimeout(this.lostTimer);
    this.unwatch?.();
    this.base?.destroy();
    this.engine?.destroy();
    this.controls?.destroy();
    this.names.destroy();
    this.element.remove();
    this.host.classList.remove('hl-map', 'hl-edit');
  }
}

/** The name of a place stands below its sign. */
const besidePoint = (label, feature) => (feature.geometry.type === 'Point' ? { ...label, dy: BELOW_PX } : label);

const withId = (feature) => (feature.id === undefined ? { ...feature, id: idOf(feature) } : feature);
