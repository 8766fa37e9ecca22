// What a finished drawing is: a new feature, or a hole or cut that the server makes.

import { contains, idOf } from './draft.js';
import { radiusOf } from './circle_pen.js';
import { PENS } from './pen.js';
import { kept } from '../map/plane.js';
import { isArea, newFeature, partsOf, turnOf } from './shape.js';

/** {feature}, {operation: {tool, coordinates, target}} or {problem}. */
export function drawnOf(tool, points, selection, draft) {
  const { shape, kind, own } = PENS[tool];
  if (!kind) return operationOf(tool, points.map(kept), selection, draft);
  const geometry = {
    area: () => ({ type: 'Polygon', coordinates: [[...points, points[0]]] }),
    line: () => ({ type: 'LineString', coordinates: points }),
    point: () => ({ type: 'Point', coordinates: points[0] }),
    circle: () => ({ type: 'Point', coordinates: points[0] }),
  }[shape]();
  if (shape === 'circle') return { feature: newFeature(kind, geometry, { radius_m: radiusOf(points[0], points[1]) }) };
  return { feature: newFeature(kind, geometry, kind === 'rows' ? { ...rowsOf(points, selection, draft), ...own } : own) };
}

function rowsOf(points, selection, draft) {
  const parcel = targetOf(points, selection, draft, (feature) => feature.properties.kind === 'parcel');
  return { type: points.length > 2 ? 'curve' : 'a-b', ...(parcel && { parcel_id: idOf(parcel) }) };
}

function operationOf(tool, points, selection, draft) {
  if (tool === 'hole') {
    const target = targetOf(points, selection, draft, (feature) => feature.properties.kind === 'parcel' && isArea(feature));
    if (!target) return { problem: 'A hole belongs into a parcel. Draw it inside one.' };
    const ring = turnOf(points) > 0 ? [...points].reverse() : points; // holes run clockwise
    return { operation: { tool, coordinates: [...ring, ring[0]], target: idOf(target) } };
  }
  const target = targetOf(points, selection, draft, (feature) => feature.geometry.type !== 'Point');
  if (!target) return { problem: 'Draw the cut across a parcel or a road.' };
  return { operation: { tool, coordinates: points, target: idOf(target) } };
}

/** The selected feature if it fits, else the smallest one that the drawing lies in or runs through. */
function targetOf(points, { only }, draft, fits) {
  if (only && fits(only)) return only;
  const middles = points.slice(1).map((b, i) => [(points[i][0] + b[0]) / 2, (points[i][1] + b[1]) / 2]);
  for (const place of [...middles, ...points]) {
    const id = draft.under(place, 0.5).find((found) => {
      const feature = draft.get(found);
      return fits(feature) && (!isArea(feature) || partsOf(feature).some((part) => contains(part, place)));
    });
    if (id) return draft.get(id);
  }
  return null;
}
