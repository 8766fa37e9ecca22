// `window.headlandMap`: for tests and support, where things are drawn and what the map believes.

import { latOf, lonOf, mercX, mercY } from './geometry.js';

let shown = null;

/** Make `map` the one behind `window.headlandMap`; null gives the place up if `former` still holds it. */
export function publish(map, former = null) {
  if (map) shown = map;
  else if (shown === former) shown = null;
}

/** Plain facts about a map. */
function describe({ engine, intake, scene, look, ...map }) {
  const camera = engine?.camera;
  return {
    engine: engine?.kind ?? null,
    camera: camera ? { lon: lonOf(camera.mx), lat: latOf(camera.my), zoom: camera.zoom, bearing: camera.bearing, metresPerPx: camera.metresPerPx } : null,
    isFollowing: map.viewpoint.isFollowing,
    frame: map.frameNumber,
    texts: map.labelLayer.texts ?? [],
    stations: map.fleet.said?.stations?.map(({ id, state, isChosen }) => ({ id, state, isChosen: Boolean(isChosen) })) ?? [],
    farm: intake.farmState,
    mission: intake.missionState,
    piece: scene.progress?.at ?? null,
    robots: [...intake.robots.values()].filter((robot) => robot.pose).map((robot) => ({
      id: robot.id, lon: robot.pose.lon, lat: robot.pose.lat, isStale: robot.isStale, stop: robot.stop,
      reachM: look?.reachOf(robot) ?? null,
    })),
  };
}

window.headlandMap = {
  /** lon/lat -> [x, y] in CSS px of the viewport, or null without a map. */
  project(lon, lat) {
    if (!shown?.engine) return null;
    const box = shown.host.getBoundingClientRect();
    const [x, y] = shown.engine.camera.project(mercX(lon), mercY(lat));
    return [box.left + x, box.top + y];
  },
  state: () => (shown ? describe(shown) : null),
};
