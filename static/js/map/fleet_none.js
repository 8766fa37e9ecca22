// On the map of one robot nothing is added for a fleet; see FleetView for what each of these does there.

export const NO_FLEET = {
  isOn: false,
  said: null,
  isOutgrown: false,
  set: () => false,
  settle() {},
  gather() {},
  drawClusters: () => [],
  single: (robots) => robots,
  tapped() {},
  destroy() {},
};

/** Give a map what the fleet needs; without it the map still shows every robot. */
export async function loadFleet(map) {
  try {
    const { FleetView } = await import('./fleet_view.js');
    if (!map.isGone) map.fleet = new FleetView(map);
  } catch (error) {
    console.warn('map: what it adds for the fleet did not load:', error);
    map.engineNote = 'Simple map: clusters and paths did not load.';
  }
}
