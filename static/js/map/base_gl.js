// A base map inside MapLibre, below everything of the farm.

import { FARM_LAYERS } from './farm_style.js';
import { areaAlpha, lineAlpha, veil } from './base_look.js';
import { vectorLayers } from './base_vector.js';

const SOURCE = 'base';
const FARM = new Set(['farm', 'mission', 'edit']);

export class GlBase {
  /** hear: {loaded(), failed(status)}. */
  constructor(engine, spec, hear) {
    this.map = engine.map;
    this.spec = spec;
    this.onError = (event) => event.sourceId === SOURCE && hear.failed(event.error?.status ?? 0);
    this.onData = (event) => event.sourceId === SOURCE && event.tile?.state === 'loaded' && hear.loaded();
    this.map.on('error', this.onError);
    this.map.on('data', this.onData);
  }

  show(palette) {
    const { map, spec } = this;
    const { url, isVector, tilePx, minZoom, maxZoom, bounds } = spec;
    map.addSource(SOURCE, {
      type: isVector ? 'vector' : 'raster', tiles: [url], minzoom: minZoom, maxzoom: maxZoom,
      ...(isVector ? {} : { tileSize: tilePx }), ...(bounds && { bounds }),
    });
    const layers = isVector ? vectorLayers(spec.schema, palette) : [{ id: 'base-raster', type: 'raster', source: SOURCE }];
    this.ids = layers.map((layer) => layer.id);
    for (const layer of layers) map.addLayer(layer, FARM_LAYERS[0].id);
    this.repaint(palette);
  }

  /** Other colours: another theme. */
  repaint(palette) {
    const { map } = this;
    const paint = (id, values) => Object.entries(values).forEach(([key, value]) => map.setPaintProperty(id, key, value));
    if (this.spec.isVector) vectorLayers(this.spec.schema, palette).forEach((layer) => paint(layer.id, layer.paint));
    else {
      const { opacity, saturation, low, high } = veil();
      paint('base-raster', { 'raster-opacity': opacity, 'raster-saturation': saturation, 'raster-brightness-min': low, 'raster-brightness-max': high, 'raster-fade-duration': 0 });
    }
  }

  /** Whether the farm's areas make way for the picture. */
  cover(isCovered) {
    if (this.isCovering === isCovered || this.spec.isVector) return;
    this.isCovering = isCovered;
    if (isCovered) this.#farm(areaAlpha, lineAlpha);
    else this.#farm(() => 1, () => 1);
  }

  #farm(area, line) {
    for (const { id, type, source } of this.map.getStyle().layers) {
      if (!FARM.has(source)) continue;
      if (type === 'fill') this.map.setPaintProperty(id, 'fill-opacity', area(id));
      else if (type === 'circle') this.map.setPaintProperty(id, 'circle-opacity', area(id));
      else if (type === 'line') this.map.setPaintProperty(id, 'line-opacity', line(id));
    }
  }

  /** Ask again for what failed. */
  retry() {
    this.map.getSource(SOURCE)?.setTiles([this.spec.url]);
  }

  /** Areas of the farm hide the ground again. */
  destroy() {
    const { map } = this;
    map.off('error', this.onError);
    map.off('data', this.onData);
    if (!map.getStyle()) return;
    for (const id of this.ids ?? []) if (map.getLayer(id)) map.removeLayer(id);
    if (map.getSource(SOURCE)) map.removeSource(SOURCE);
    this.cover(false);
  }
}
