// Sites: what of a farm lies together. A farm may have fields in two countries, and a map of both shows neither.

import { boxOf, latOf, lonOf } from '../map/geometry.js';
import { lengthM } from '../map/plane.js';

const SITE_M = 20000;
const SAME_PX = 2; // no finger moved the map since

const middleOf = ([x0, y0, x1, y1]) => [lonOf((x0 + x1) / 2), latOf((y0 + y1) / 2)];
const sizeOf = ({ box: [x0, y0, x1, y1], isParcel }) => (x1 - x0) * (y1 - y0) + Number(isParcel);

/** Lists of features that lie together, the one with the largest parcel first; without parcels the one with the most. */
export function sitesOf(features) {
  let left = features
    .map((feature) => ({ feature, box: boxOf([feature]), isParcel: feature.properties?.kind === 'parcel' }))
    .filter(({ box }) => box)
    .sort((a, b) => sizeOf(b) - sizeOf(a));
  const sites = [];
  while (left.length) {
    const middle = middleOf(left[0].box);
    const isNear = new Set(left.filter(({ box }) => lengthM(middle, middleOf(box)) < SITE_M));
    sites.push([...isNear].map(({ feature }) => feature));
    left = left.filter((one) => !isNear.has(one));
  }
  const hasParcel = (site) => site.some((one) => one.properties?.kind === 'parcel');
  return sites.some(hasParcel) ? sites : sites.sort((a, b) => b.length - a.length);
}

/** The site around the middle of the picture, or the next one where it is shown whole already; viewOf(box): how it is shown. */
export function siteToShow(features, camera, viewOf) {
  const sites = sitesOf(features);
  const here = [lonOf(camera.mx), latOf(camera.my)];
  const away = sites.map((site) => lengthM(here, middleOf(boxOf(site))));
  const nearest = away.indexOf(Math.min(...away));
  if (nearest < 0) return [];
  const { mx, my, zoom } = viewOf(boxOf(sites[nearest]));
  const offPx = Math.hypot(camera.mx - mx, camera.my - my) * camera.worldPx;
  const isShown = offPx < SAME_PX && Math.abs(camera.zoom - zoom) < 0.01;
  return sites[isShown ? (nearest + 1) % sites.length : nearest];
}
