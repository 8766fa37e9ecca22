// What lies under the map: plain ground, a photo or map of the farm, or the online map. Loaded only when somebody
// chose one or opens the menu. The ground never goes: whatever fails, it is there, with a line that says why.

import { mercX, mercY, viewBox } from './geometry.js';
import { strong } from './base_look.js';
import { baseChoice, keepBaseChoice } from './layers.js';

const AGAIN_MS = 10000;
const SETTLED_MS = 1500; // one tile that comes does not yet make up for one that just failed
const MOSTLY = 0.97; // less of the view than this under the picture is said
const ONLINE = 'online';
const PLAIN = 'Showing plain ground.';
let groups = 0;

function node(tag, className, ...children) {
  const made = document.createElement(tag);
  made.className = className;
  made.append(...children);
  return made;
}

export class BaseMaps {
  #failure = '';
  #failedAt = -Infinity; // nothing has failed: a picture in the first second of a page counts too

  /** host: the map's element; url: of the list; changed(): note, credit or colours are others now. */
  constructor({ host, url, changed }) {
    this.host = host;
    this.url = url;
    this.changed = changed;
    this.list = null;
    this.isLost = false;
    this.credit = node('div', 'hl-map-credit');
    this.credit.dataset.testid = 'map-credit';
    this.credit.hidden = true;
    (host.querySelector('.hl-map-controls') ?? host).append(this.credit);
    const reload = (event) => event?.kind === 'base_map' && this.load();
    this.unsubscribe = window.headland?.on?.('event', reload);
    this.again = setInterval(() => this.#again(), AGAIN_MS);
    this.load();
  }

  /** Draw on this engine from now on; a former one is gone with its picture. */
  attach(engine, palette) {
    this.engine = engine;
    this.plain = palette;
    this.drawn = null;
    this.drawnId = null;
    this.#show();
  }

  /** The palette to draw with; after a change of theme the picture takes it too. */
  palette(palette) {
    this.plain = palette;
    this.drawn?.repaint(palette);
    return this.drawn && !this.spec.isVector ? strong(palette) : palette;
  }

  async load() {
    try {
      const answer = await fetch(this.url, { headers: { Accept: 'application/json' } });
      if (!answer.ok) throw new Error(`${answer.status}`);
      this.list = await answer.json();
      this.isLost = false;
    } catch (error) {
      console.warn('map: no list of base maps:', error);
      this.isLost = true;
    }
    if (this.isGone) return;
    this.#show();
    if (this.menu?.isConnected) this.fill(this.menu);
  }

  choose(id) {
    keepBaseChoice(id);
    this.#show();
  }

  get note() {
    const id = baseChoice();
    if (!id) return '';
    if (!this.list) return this.isLost ? `Base map did not load. ${PLAIN}` : 'Loading base map';
    if (!this.spec) return `The chosen base map is not there any more. ${PLAIN}`;
    const { word, isVector, isThere } = this.spec;
    if (!isThere) return `The file of this ${word.toLowerCase()} is gone from the server. ${PLAIN}`;
    if (isVector && this.engine?.kind === 'canvas') return `This base map needs WebGL. ${PLAIN}`;
    if (this.#failure) return this.#failure;
    return this.#coverage();
  }

  #coverage() {
    const { word, box, minZoom, tilePx, isVector } = this.spec;
    const { camera } = this.engine;
    const shift = isVector ? 0 : Math.log2(512 / tilePx);
    if (Math.round(camera.zoom + shift) < minZoom) return `Zoom in to see the ${word.toLowerCase()}.`;
    if (!box) return '';
    const view = viewBox(camera);
    const span = (low, high) => Math.max(0, Math.min(view[high], box[high]) - Math.max(view[low], box[low])) / (view[high] - view[low]);
    const share = span(0, 2) * span(1, 3);
    if (share === 0) return `${word} does not reach here. ${PLAIN}`;
    return share < MOSTLY ? `${word} covers only part of this map.` : '';
  }

  /** The view moved: what the picture covers of it may be another share. */
  moved() {
    const { note } = this;
    if (note === this.said) return;
    this.said = note;
    this.changed(false);
  }

  #specOf(id) {
    const { list } = this;
    if (id === ONLINE && list.online) {
      const { url, credit, max_zoom: maxZoom } = list.online;
      return { url, credit, maxZoom, minZoom: 0, tilePx: 256, word: 'Online map', isThere: true };
    }
    const found = list.maps.find((one) => one.id === id);
    if (!found) return null;
    const [west, south, east, north] = found.bounds;
    return {
      url: `${new URL(this.url, window.location.href).href}/${id}/{z}/{x}/{y}`,
      credit: found.credit, minZoom: found.min_zoom, maxZoom: found.max_zoom, tilePx: found.tile_px || 512,
      bounds: found.bounds, box: [mercX(west), mercY(Math.min(north, 85.05)), mercX(east), mercY(Math.max(south, -85.05))],
      schema: found.schema, isVector: found.kind === 'vector', isThere: found.is_there,
      word: found.kind === 'photo' ? 'Photo' : 'Base map',
    };
  }

  async #show() {
    const id = baseChoice();
    this.spec = id && this.list ? this.#specOf(id) : null;
    const isDrawable = Boolean(this.spec?.isThere && this.engine) && !(this.spec.isVector && this.engine.kind === 'canvas');
    const wanted = isDrawable ? id : null;
    if (wanted !== this.drawnId) {
      this.drawn?.destroy();
      this.drawn = null;
      this.drawnId = wanted;
      this.#failure = '';
      if (wanted) await this.#draw(wanted);
    }
    this.host.dataset.base = this.drawn ? id : '';
    this.credit.textContent = (this.drawn && this.spec?.credit) || '';
    this.credit.hidden = !this.credit.textContent;
    this.said = this.note;
    this.changed(true);
  }

  async #draw(id) {
    const { engine, spec } = this;
    const hear = { loaded: () => performance.now() - this.#failedAt > SETTLED_MS && this.#heard(''), failed: (status) => this.#heard(status === 410 ? `The file of this ${spec.word.toLowerCase()} is gone from the server. ${PLAIN}` : `${spec.word} did not load. ${PLAIN}`) };
    const code = engine.kind === 'gl' ? await import('./base_gl.js').then(({ GlBase }) => GlBase) : await import('./base_canvas.js').then(({ CanvasBase }) => CanvasBase);
    if (this.isGone || this.engine !== engine || this.drawnId !== id) return;
    this.drawn = new code(engine, spec, hear);
    this.drawn.show(this.plain);
  }

  #heard(failure) {
    if (failure) this.#failedAt = performance.now();
    this.drawn?.cover(!failure); // without the picture, fields are what they were
    if (this.#failure === failure) return;
    this.#failure = failure;
    this.moved();
  }

  #again() {
    if (document.hidden || !baseChoice()) return;
    if (this.isLost) this.load();
    else if (this.#failure) this.retry();
  }

  /** Ask again for what failed. */
  retry() {
    this.#failedAt = -Infinity;
    this.drawn?.retry();
  }

  /** The choice as a part of a menu. */
  fill(menu) {
    this.menu = menu;
    let part = menu.querySelector('.hl-map-under');
    if (!part) {
      part = node('div', 'hl-map-under');
      part.setAttribute('role', 'radiogroup');
      part.setAttribute('aria-label', 'Base map');
      part.dataset.testid = 'map-base';
      menu.append(part);
    }
    groups += 1;
    const held = document.activeElement?.dataset?.testid;
    part.replaceChildren(node('div', 'hl-map-under-title', 'Base map'), ...this.#choices(`hl-base-${groups}`));
    if (held?.startsWith('map-base-')) part.querySelector(`[data-testid="${held}"]`)?.focus();
    this.#manage(part);
  }

  #choices(group) {
    const now = baseChoice();
    const rows = [this.#choice(group, '', 'Plain ground', '', true, now)];
    for (const one of this.list?.maps ?? []) rows.push(this.#choice(group, one.id, one.name, one.is_there ? '' : 'File is missing', one.is_there, now));
    if (this.list?.online) rows.push(this.#choice(group, ONLINE, 'Online map', new URL(this.list.online.url).host, true, now));
    if (this.isLost) rows.push(node('div', 'hl-map-under-hint', 'Base maps did not load. They are asked for again.'));
    else if (!this.list) rows.push(node('div', 'hl-map-under-hint', 'Loading base maps'));
    else if (rows.length === 1 && !this.host.closest('hl-maps')) rows.push(node('div', 'hl-map-under-hint', 'No photo yet. A planner adds one on the screen Maps.'));
    return rows;
  }

  #choice(group, id, name, hint, isOn, now) {
    const box = document.createElement('input');
    box.type = 'radio';
    box.name = group;
    box.checked = id === now;
    box.disabled = !isOn;
    box.dataset.testid = `map-base-${id || 'plain'}`;
    box.addEventListener('change', () => this.choose(id));
    const words = node('span', 'hl-map-under-name', name);
    if (hint) words.append(node('small', '', hint));
    return node('label', 'hl-map-layer', box, words);
  }

  #manage(part) {
    if (!this.host.closest('hl-maps')) return;
    const button = node('button', 'hl-map-under-manage', 'Add or change base maps');
    button.type = 'button';
    button.dataset.testid = 'map-base-manage';
    button.addEventListener('click', () => this.host.dispatchEvent(new CustomEvent('headland:base-maps', { bubbles: true })));
    part.append(button);
  }

  destroy() {
    this.isGone = true;
    clearInterval(this.again);
    this.unsubscribe?.();
    this.credit.remove();
    delete this.host.dataset.base;
  }
}
