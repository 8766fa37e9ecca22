// The rows of the fields, laid once the map rests. What draws them is fetched only then: the first picture needs no rows.

const REST_MS = 180; // after the last movement

export class FieldRows {
  #shown = null;

  /** `map` has an engine, or none for the moment. */
  constructor(map) {
    this.map = map;
  }

  later(features) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.#lay(features), REST_MS);
  }

  async #lay(features) {
    let drawing;
    try {
      drawing = await import('./row_strips.js');
    } catch (error) {
      console.warn('map: the rows of the fields did not load:', error); // tried again after the next movement
      return;
    }
    const { engine, host } = this.map;
    if (!engine || this.map.isGone) return;
    this.strips ??= new drawing.Strips();
    const { lines, key } = this.strips.of(features, engine.camera);
    if (this.#shown?.key === key && this.#shown.features === features && this.#shown.engine === engine) return;
    this.#shown = { key, features, engine };
    engine.setRows(drawing.rowsOf(lines));
    host.dataset.rows = lines.length;
  }

  destroy() {
    clearTimeout(this.timer);
  }
}
