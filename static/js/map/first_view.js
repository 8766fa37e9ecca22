// Where the map stands before anybody moved it: at its robot and field, or over everything there is.

import { boxOf } from './geometry.js';

const ROBOT_ZOOM = 16.8; // 2.3 px per metre at 52 degrees north: a field of a hectare fills the screen
const FIELD_ZOOMS = [16.2, 19.5]; // a large field keeps its rows apart, a small one its surroundings in sight
const FIELD_MARGIN_PX = 40;
const MARGIN_PX = 40;

/** As near as the field of the mission allows. */
export function fieldZoom(intake, camera) {
  const box = boxOf(intake.parcels.features);
  if (!box) return ROBOT_ZOOM;
  const [least, most] = FIELD_ZOOMS;
  return Math.min(Math.max(camera.zoomFor(box, FIELD_MARGIN_PX), least), most);
}

/** The robot with its field; null while nobody knows where it is. */
export function robotView(intake, camera) {
  const pose = intake.selected?.pose;
  return pose ? { mx: pose.mx, my: pose.my, zoom: fieldZoom(intake, camera) } : null;
}

/** The box with every parcel whole that it touches. */
function withFields(box, features) {
  const touches = ([x0, y0, x1, y1]) => x0 <= box[2] && x1 >= box[0] && y0 <= box[3] && y1 >= box[1];
  const fields = features.filter((one) => one.properties?.kind === 'parcel').map((one) => boxOf([one])).filter((one) => one && touches(one));
  const far = (i, pick) => pick(box[i], ...fields.map((one) => one[i]));
  return [far(0, Math.min), far(1, Math.min), far(2, Math.max), far(3, Math.max)];
}

/** All robots of a fleet or all stations, else the farm with what is on it; null while there is nothing to look at. */
export function wholeView(intake, camera, fleet, controls) {
  const { farm, parcels, robots } = intake;
  const places = (fleet.places?.() ?? [...robots.values()].filter((robot) => robot.pose).map(({ pose }) => [pose.lon, pose.lat]))
    .map((coordinates) => ({ geometry: { type: 'Point', coordinates } }));
  // a farm may have sites in several countries: the map of a fleet, or of stations, begins where those are
  const box = fleet.isOn && places.length ? withFields(boxOf(places), farm.features) : boxOf([...farm.features, ...parcels.features, ...places]);
  if (!box) return null;
  return camera.viewOf(box, controls.freePx(Math.min(MARGIN_PX, camera.height / 10)), ROBOT_ZOOM);
}
