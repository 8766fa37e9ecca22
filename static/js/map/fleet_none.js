// On the map of one robot nothing is added; see FleetView and StationsView for what each of these does there.

export const NO_FLEET = {
  isOn: false,
  said: null,
  isOutgrown: false,
  placed: 0,
  set: () => false,
  settle() {},
  gather() {},
  drawClusters: () => [],
  single: (robots) => robots,
  tapped() {},
  destroy() {},
};

/** Give a map what the fleet, or the stations, need; without it the map still shows the farm and every robot. */
export async function loadFleet(map) {
  try {
    const { View } = await (map.options.mode === 'stations' ? import('./stations_view.js') : import('./fleet_view.js'));
    if (!map.isGone) map.fleet = new View(map);
  } catch (error) {
    console.warn('map: what it adds for the fleet did not load:', error);
    map.engineNote = `Simple map: ${map.options.mode === 'stations' ? 'stations' : 'clusters and paths'} did not load.`;
  }
}
