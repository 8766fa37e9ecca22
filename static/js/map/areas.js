// Areas of the mission on the map: ground with a dose of its own, ground left out, obstacles somebody drew.

import { LineSet } from './drawlist.js';
import { boxOf, labelPoint, mercPerMetre, mercX, mercY, polygonParts } from './geometry.js';

const KINDS = new Set(['dose', 'leave_out', 'obstacle']);
const NAMES = { leave_out: 'Left out', obstacle: 'Obstacle' };
const LEAST_LABEL_PX = 46;

/** A dose as a person says it. */
export const doseText = (dose) => (dose === 0 ? 'Off' : dose === 0.5 ? 'Half dose' : dose === 1 ? 'Usual dose' : dose === 2 ? 'Double dose' : `${dose} × dose`);

/** {kind, text, rings: flat mercator, at, widthM} of every area of a mission's GeoJSON. */
export function readAreas(features) {
  return features.filter((one) => KINDS.has(one.properties?.kind)).flatMap((feature) => {
    const { kind, dose } = feature.properties;
    const box = boxOf([feature]);
    return polygonParts(feature.geometry).map((rings) => {
      const [lon, lat] = labelPoint(rings[0]);
      return { kind, text: NAMES[kind] ?? doseText(dose), rings: rings.map((ring) => ring.flatMap(([x, y]) => [mercX(x), mercY(y)])), mx: mercX(lon), my: mercY(lat), widthM: box[2] - box[0] };
    });
  });
}

/** Rows with less or more than the usual dose, and outlines, as the scene draws them. */
export class AreaLines {
  sets = { less: new LineSet(8), more: new LineSet(8), outline: new LineSet(8), obstacle: new LineSet(8) };

  lay(model, origin) {
    for (const set of Object.values(this.sets)) set.clear();
    const perMetre = mercPerMetre(origin.my);
    for (const piece of model?.pieces ?? []) {
      if (piece.isWorked && piece.dose !== 1) this.sets[piece.dose < 1 ? 'less' : 'more'].add(piece.line, origin, perMetre);
    }
    for (const { kind, rings } of model?.areas ?? []) {
      for (const ring of rings) this.sets[kind === 'obstacle' ? 'obstacle' : 'outline'].add(ring, origin, perMetre);
    }
  }

  /** A lower dose is a dashed row, a higher one a broad row: the pattern says it without a colour. */
  lines(rowWidthM, ink, isRows) {
    const all = (set, look) => ({ set, from: 0, count: set.count, cap: 0, ...look });
    const { less, more, outline, obstacle } = this.sets;
    return [
      ...(isRows ? [
        all(less, { colour: ink.bed, widthM: rowWidthM * 0.5, leastPx: 3, dash: [5, 6] }),
        all(more, { colour: ink.row, widthM: rowWidthM * 0.3, leastPx: 2.6 }),
      ] : []),
      all(outline, { colour: ink.path, leastPx: 2, dash: [7, 5] }),
      all(obstacle, { colour: ink.obstacle, leastPx: 3.4 }),
    ].filter((line) => line.count);
  }
}

/** Names that fit into their areas at this zoom. */
export const areaLabels = (areas, camera) => areas
  .filter((area) => area.widthM * camera.worldPx > LEAST_LABEL_PX)
  .map(({ text, mx, my }) => ({ mx, my, lines: [{ text, size: 13, weight: 650 }], priority: 45 }));
