// Numbers and sentences of the builder.

import { areaM2 } from '../map/geometry.js';
import { areaText } from '../map/captions.js';
import { lengthM } from '../map/plane.js';
import { isArea, partsOf } from './shape.js';

export { areaText };

/** "98.5 m", "1.24 km", "42 cm". */
export function lengthText(metres) {
  if (metres < 1) return `${Math.round(metres * 100)} cm`;
  return metres < 10_000 ? `${metres.toFixed(1)} m` : `${(metres / 1000).toFixed(2)} km`;
}

/** How far something was moved: "1.4 m", "8 cm". */
export const movedText = lengthText;

export const degreesText = (degrees) => `${degrees.toFixed(1)}°`;

/** Area of a polygon, or the empty text. */
export function sizeText(feature) {
  if (!isArea(feature)) return '';
  return areaText(partsOf(feature).reduce((sum, rings) => sum + (rings[0].length > 2 ? areaM2(rings) : 0), 0));
}

export function pathM(points, isClosed = false) {
  let sum = 0;
  for (let i = 0; i + 1 < points.length; i += 1) sum += lengthM(points[i], points[i + 1]);
  return isClosed && points.length > 2 ? sum + lengthM(points.at(-1), points[0]) : sum;
}

/** "214.3 m", with "area 0.52 ha" when the points enclose something. */
export function measureText(points, hasArea) {
  const length = lengthText(pathM(points));
  return hasArea && points.length > 2 ? `${length}, area ${areaText(areaM2([points]))}` : length;
}

const KIND_WORDS = { 'no-go': 'Keep-out zone', rows: 'Row line' };

/** "Parcel", "Keep-out zone". */
export function kindWord(kind) {
  return KIND_WORDS[kind] ?? kind.charAt(0).toUpperCase() + kind.slice(1);
}
