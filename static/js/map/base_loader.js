// Base maps load when one was chosen, or when the menu asks what there is.

/** changed(isLook): the ground looks another way, or there is something to say about it. */
export async function loadBase(map, menu, changed) {
  try {
    const { BaseMaps } = await import('./base_maps.js');
    if (map.isGone || !map.engine) return;
    if (!map.base) {
      map.base = new BaseMaps({ host: map.host, url: map.options.baseMapsUrl, changed });
      map.base.attach(map.engine, map.palette);
    }
    if (menu) map.base.fill(menu);
  } catch (error) {
    console.warn('map: base maps did not load:', error);
    map.engineNote ||= 'Base map did not load. Showing plain ground.';
    changed(false);
  }
}
