// A neutral drawing of vector base maps with the layers of Protomaps or OpenMapTiles. No names: there are no glyphs.

const area = (id, layer, colour, filter) => ({ id, type: 'fill', 'source-layer': layer, paint: { 'fill-color': colour }, ...(filter && { filter }) });
const line = (id, layer, colour, widths, filter) => ({
  id, type: 'line', 'source-layer': layer, layout: { 'line-join': 'round', 'line-cap': 'round' },
  paint: { 'line-color': colour, 'line-width': ['interpolate', ['exponential', 1.6], ['zoom'], ...widths] }, ...(filter && { filter }),
});
const isOneOf = (key, ...values) => ['in', ['coalesce', ['get', key], ''], ['literal', values]];
const isArea = ['in', ['geometry-type'], ['literal', ['Polygon', 'MultiPolygon']]];
const isLine = ['in', ['geometry-type'], ['literal', ['LineString', 'MultiLineString']]];
const GREEN = ['forest', 'wood', 'park', 'nature_reserve', 'scrub', 'orchard', 'national_park', 'protected_area', 'tree', 'hedge'];
const STREET = [10, 0.6, 15, 2.5, 20, 26];
const TRACK = [12, 0.5, 16, 1.6, 20, 10];
const MINOR = ['path', 'other', 'track', 'service', 'footway'];

const SCHEMAS = {
  protomaps: [
    area('earth', 'earth', '@ground', isArea),
    area('green', 'landuse', '@tree', isOneOf('kind', ...GREEN)),
    area('lake', 'water', '@water', isArea),
    line('river', 'water', '@water', [8, 0.5, 16, 4], isLine),
    area('house', 'buildings', '@building', isArea),
    line('way', 'roads', '@roadEdge', TRACK, isOneOf('kind', ...MINOR)),
    line('kerb', 'roads', '@roadEdge', [10, 1.2, 15, 4, 20, 29], ['!', isOneOf('kind', ...MINOR, 'rail', 'ferry')]),
    line('street', 'roads', '@road', STREET, ['!', isOneOf('kind', ...MINOR, 'rail', 'ferry')]),
    line('rail', 'roads', '@plan', [10, 0.5, 18, 2], isOneOf('kind', 'rail')),
  ],
  openmaptiles: [
    area('green', 'landcover', '@tree', isOneOf('class', 'wood', 'forest')),
    area('park', 'landuse', '@tree', isOneOf('class', 'cemetery', 'park')),
    area('lake', 'water', '@water', isArea),
    line('river', 'waterway', '@water', [8, 0.5, 16, 4], isLine),
    area('house', 'building', '@building', isArea),
    line('way', 'transportation', '@roadEdge', TRACK, isOneOf('class', ...MINOR)),
    line('kerb', 'transportation', '@roadEdge', [10, 1.2, 15, 4, 20, 29], ['!', isOneOf('class', ...MINOR, 'rail', 'transit', 'ferry')]),
    line('street', 'transportation', '@road', STREET, ['!', isOneOf('class', ...MINOR, 'rail', 'transit', 'ferry')]),
    line('rail', 'transportation', '@plan', [10, 0.5, 18, 2], isOneOf('class', 'rail')),
  ],
};

/** MapLibre layers of a schema, bottom to top, in the colours of the palette. */
export function vectorLayers(schema, palette) {
  const colour = (value) => (typeof value === 'string' && value[0] === '@' ? palette[value.slice(1)] : value);
  return (SCHEMAS[schema] ?? []).map((layer) => ({
    ...layer, id: `base-${layer.id}`, source: 'base',
    paint: Object.fromEntries(Object.entries(layer.paint).map(([key, value]) => [key, colour(value)])),
  }));
}
