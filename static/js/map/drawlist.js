// What is drawn over the farm, in arrays that the GL layer uploads as they are and the 2D canvas reads back.
// Positions are mercator minus an origin near the farm: float32 then resolves a tenth of a millimetre.

export const LINE_FLOATS = 5; // x0, y0, x1, y1, metres walked at the start
export const STAMP_WORDS = 11; // x, y, cos, sin, width_m, length_m, least length px, shift, three colours

/** Straight pieces of lines; `dirty` asks the GL layer to upload again. */
export class LineSet {
  constructor(capacity = 64) {
    this.data = new Float32Array(capacity * LINE_FLOATS);
    this.count = 0;
    this.dirty = true;
  }

  clear() {
    this.count = 0;
    this.dirty = true;
  }

  /** Append a flat mercator line [x, y, x, y, ...]; `perMetre` mercator units per metre. */
  add(line, origin, perMetre, walked = 0) {
    for (let i = 0; i + 3 < line.length; i += 2) {
      walked += this.addPiece(line[i], line[i + 1], line[i + 2], line[i + 3], origin, perMetre, walked);
    }
    return walked;
  }

  addPiece(x0, y0, x1, y1, origin, perMetre, walked) {
    if ((this.count + 1) * LINE_FLOATS > this.data.length) {
      const larger = new Float32Array(this.data.length * 2);
      larger.set(this.data);
      this.data = larger;
    }
    const at = this.count * LINE_FLOATS;
    this.data[at] = x0 - origin.mx;
    this.data[at + 1] = y0 - origin.my;
    this.data[at + 2] = x1 - origin.mx;
    this.data[at + 3] = y1 - origin.my;
    this.data[at + 4] = walked;
    this.count += 1;
    this.dirty = true;
    return Math.hypot(x1 - x0, y1 - y0) / perMetre;
  }
}

/** Marks and machines of one shape, one record each. */
export class StampBatch {
  constructor(shape, capacity = 16) {
    this.shape = shape;
    this.#grow(capacity);
    this.count = 0;
  }

  #grow(capacity) {
    const buffer = new ArrayBuffer(capacity * STAMP_WORDS * 4);
    const floats = new Float32Array(buffer);
    if (this.floats) floats.set(this.floats);
    this.floats = floats;
    this.words = new Uint32Array(buffer);
  }

  clear() {
    this.count = 0;
  }

  /** headingRad clockwise from north; `shift` moves the outline forward, in half lengths; colours packed. */
  push(x, y, headingRad, widthM, lengthM, leastPx, shift, fill, accent, rim) {
    if ((this.count + 1) * STAMP_WORDS > this.floats.length) this.#grow(this.count * 2 + 16);
    const at = this.count * STAMP_WORDS;
    const { floats, words } = this;
    floats[at] = x;
    floats[at + 1] = y;
    floats[at + 2] = Math.cos(headingRad);
    floats[at + 3] = Math.sin(headingRad);
    floats[at + 4] = widthM;
    floats[at + 5] = lengthM;
    floats[at + 6] = leastPx;
    floats[at + 7] = shift;
    words[at + 8] = fill;
    words[at + 9] = accent;
    words[at + 10] = rim;
    this.count += 1;
  }
}
