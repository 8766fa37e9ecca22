// What a finished drawing is: a new feature, or a hole or cut that the server makes.

import { contains, idOf } from './draft.js';
import { radiusOf } from './circle_pen.js';
import { PENS } from './pen.js';
import { kept } from '../map/plane.js';
import { edgesOf, isArea, newFeature, partsOf, turnOf } from './shape.js';

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
  const told = { parcel: () => ({ name: freeName('Parcel', draft) }), rows: () => rowsOf(points, selection, draft) }[kind]?.();
  return { feature: newFeature(kind, geometry, { ...told, ...own }) };
}

/** "Parcel 3": a name that nothing on the map has yet. */
function freeName(word, draft) {
  const names = new Set(draft.features.map((feature) => feature.properties?.name));
  let number = 1;
  while (names.has(`${word} ${number}`)) number += 1;
  return `${word} ${number}`;
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
  const isCut = selection.only && isCutBy(selection.only, points);
  const target = isCut ? selection.only : targetOf(points, selection, draft, (feature) => feature.geometry.type !== 'Point');
  if (!target) return { problem: 'Draw the cut across a parcel or a road.' };
  return { operation: { tool, coordinates: points, target: idOf(target) } };
}

/** What the drawing lies in or runs through: the selected feature where it fits and does, else the smallest one. */
function targetOf(points, { only }, draft, fits) {
  const middles = points.slice(1).map((b, i) => [(points[i][0] + b[0]) / 2, (points[i][1] + b[1]) / 2]);
  const isChosen = only && fits(only);
  const holds = (feature, place) => !isArea(feature) || partsOf(feature).some((part) => contains(part, place));
  for (const place of [...middles, ...points]) {
    if (isChosen && isArea(only) && holds(only, place)) return only;
    const id = draft.under(place, 0.5).find((found) => fits(draft.get(found)) && holds(draft.get(found), place));
    if (id) return draft.get(id);
  }
  return isChosen ? only : null;
}

/** Whether a cut runs right across: a line once, an area in and out again. */
function isCutBy(feature, points) {
  const lines = partsOf(feature).flat().filter((line) => line.length > 1);
  const edges = lines.flatMap((line) => [...edgesOf(line, isArea(feature))]);
  const cuts = edges.flatMap((edge) => points.slice(1).filter((b, i) => crosses(edge, [points[i], b])));
  return cuts.length >= (isArea(feature) ? 2 : 1);
}

function crosses([a, b], [c, d]) {
  const side = ([px, py], [qx, qy], [x, y]) => Math.sign((qx - px) * (y - py) - (qy - py) * (x - px));
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}
