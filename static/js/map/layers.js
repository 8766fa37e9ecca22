// Which layers a person wants to see, kept in this browser.

export const LAYERS = [['rows', 'Rows'], ['plan', 'Planned path'], ['trail', 'Trail'], ['labels', 'Names'], ['surroundings', 'Roads, trees, buildings']];
const LAYER_KEY = 'headland.map.layers';

/** {name: isOn} of all layers. */
export function readLayers() {
  const usual = Object.fromEntries(LAYERS.map(([name]) => [name, true]));
  try {
    return { ...usual, ...JSON.parse(localStorage.getItem(LAYER_KEY) ?? '{}') };
  } catch {
    return usual; // private mode, or a value of an older version
  }
}

/** Remember the choice. */
export function keepLayers(shown) {
  try {
    localStorage.setItem(LAYER_KEY, JSON.stringify(shown));
  } catch {
    // a full or forbidden storage only means that the choice is not remembered
  }
}

const BASE_KEY = 'headland.map.base';

/** Id of the base map a person chose in this browser; empty for plain ground. */
export function baseChoice() {
  try {
    return localStorage.getItem(BASE_KEY) ?? '';
  } catch {
    return '';
  }
}

export function keepBaseChoice(id) {
  try {
    localStorage.setItem(BASE_KEY, id);
  } catch {
    // only not remembered
  }
}
