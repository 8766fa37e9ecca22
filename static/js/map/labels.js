// Names and warnings over the map, drawn with the page's own font on a 2D canvas: no glyph server, same in both engines.

const MOST_LABELS = 80; // more cannot be read
const MARGIN_PX = 6;
const HALO = 0.28; // of the type size
const ASIDE_PX = [0, -34, 34, -60, 60, -104, 104]; // where the name of a place may go when something stands on it

const BESIDE_PX = [0, -12, 12, -22, 22]; // where the name of a sign may go and still stand beside it

/** Shifts of a place's name that leave it on its own ground: on the next field it would name that one. */
export function asides(label, scale, worldPx) {
  if (!label.kind) return label.isWhole ? BESIDE_PX.map((shift) => shift * scale) : [0];
  const shifts = ASIDE_PX.map((shift) => shift * scale);
  return label.room ? shifts.filter((shift) => Math.abs(shift) <= label.room[shift < 0 ? 0 : 1] * worldPx) : shifts;
}

/** Where the middle of a place's name goes so that the edge of the map does not cut it: as far as its own ground lies. */
export function withinSight(x, wide, room, edge) {
  if (x < 0 || x > edge) return x;
  const shift = Math.max(0, MARGIN_PX - (x - wide / 2)) - Math.max(0, x + wide / 2 + MARGIN_PX - edge);
  return x + Math.max(-room, Math.min(room, shift));
}

/** A text left of its robot goes to the right of it where the edge of the map would cut it. */
export function sideOf({ align, dx }, x, wide) {
  return align === 'right' && dx < 0 && x - wide < MARGIN_PX ? 'left' : align;
}

/** The layer of texts; `draw` is called after each frame of the engine. */
export class LabelLayer {
  constructor(host) {
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'hl-map-labels';
    this.canvas.setAttribute('aria-hidden', 'true');
    host.insertBefore(this.canvas, host.querySelector(':scope > .hl-map-controls')); // never over a button
    this.context = this.canvas.getContext('2d');
    this.blocked = [];
  }

  /**
   * Draw labels by falling priority; one that would cover another is left out unless `isFixed`.
   *
   * label without lines: keeps `clearPx` around its place free of texts (`isSoft`: of names alone, not of warnings); else
   * label: {mx, my, lines: [{text, size, weight}], dx, dy, align, priority, isFixed, isWhole, pill: {fill, ink} | null, icon}
   */
  draw(camera, labels, palette) {
    const ratio = window.devicePixelRatio || 1;
    const { mx, my, zoom, bearing } = camera;
    const words = labels.map((label) => [label.mx, label.my, label.dx, label.dy, label.priority, label.cluster?.level, label.cluster?.isAsking, label.cluster?.px, ...label.lines.map((line) => line.text)].join());
    const drawn = [mx, my, zoom, bearing, camera.width, camera.height, ratio, palette.label, palette.scale, document.fonts.size, document.fonts.status, ...words].join('|');
    if (drawn === this.drawn) return; // most pictures change robots only
    this.drawn = drawn;
    const { canvas, context } = this;
    const [width, height] = [Math.round(camera.width * ratio), Math.round(camera.height * ratio)];
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    context.lineJoin = 'round';
    context.textBaseline = 'alphabetic';
    const taken = [...this.blocked];
    this.edge = camera.width;
    this.worldPx = camera.worldPx;
    let count = 0;
    this.texts = [];
    const order = [...labels].sort((a, b) => b.priority - a.priority);
    for (const label of order) {
      if (count >= MOST_LABELS) break;
      const [x, y] = camera.project(label.mx, label.my);
      if (x < -200 || y < -100 || x > camera.width + 200 || y > camera.height + 100) continue;
      const shifts = asides(label, palette.scale, camera.worldPx);
      const isDrawn = shifts.some((shift) => this.#one(label, x + (label.dx ?? 0), y + (label.dy ?? 0) + shift, palette, taken))
        || (label.pill && label.align === 'left' && this.#elsewhere(label, x, y, palette, taken));
      if (isDrawn && label.lines.length) count += 1;
    }
  }

  /** Parts of the map that something else covers: boxes in px. No text is drawn beneath them but what is fixed. */
  block(boxes) {
    const key = boxes.join();
    if (key === this.blockedKey) return;
    [this.blocked, this.blockedKey, this.drawn] = [boxes, key, null];
  }

  /** A warning whose usual side is taken stands on the other one, above or below: it is not left out while there is room. */
  #elsewhere(label, x, y, palette, taken) {
    const off = label.dx * 1.6 * palette.scale;
    return this.#one({ ...label, align: 'right' }, x - label.dx, y, palette, taken)
      || [-off, off].some((dy) => this.#one({ ...label, align: 'centre' }, x, y + dy, palette, taken));
  }

  /** Draw one label; false if something else is there. */
  #one(label, at, y, palette, taken) {
    const { context } = this;
    let x = at;
    if (label.cluster) return drawCluster(context, label, x, y, palette, taken, this.texts);
    if (label.clearPx) {
      const clear = label.clearPx * palette.scale;
      const box = [x - clear, y - clear, x + clear, y + clear];
      box.isSoft = label.isSoft;
      taken.push(box);
      return true;
    }
    const lines = label.lines.map((line) => ({ ...line, px: line.size * palette.scale }));
    const font = (line) => `${line.weight ?? 600} ${line.px}px ${palette.font}`;
    let wide = 0;
    let high = 0;
    for (const line of lines) {
      context.font = font(line);
      line.wide = context.measureText(line.text).width;
      wide = Math.max(wide, line.wide);
      high += line.px * 1.25;
    }
    if (label.kind) x = withinSight(x, wide, ((label.widthM ?? 0) * this.worldPx) / 2, this.edge);
    const align = sideOf(label, x, wide);
    if (align !== label.align) x -= 2 * label.dx;
    const left = align === 'left' ? x : align === 'right' ? x - wide : x - wide / 2;
    const box = [left - 4, y - high / 2 - 2, left + wide + 4, y + high / 2 + 2];
    const overlaps = (o) => !(o.isSoft && label.pill) && box[0] < o[2] && o[0] < box[2] && box[1] < o[3] && o[1] < box[3];
    const isCut = (label.pill && box[2] > this.edge) || ((label.pill || label.isWhole) && box[0] < 0); // it has another side to stand on, or is of no use in part
    if (!label.isFixed && (isCut || taken.some(overlaps))) return false;
    taken.push(box);
    this.texts.push(...lines.map((line) => line.text));
    if (label.pill) {
      context.fillStyle = label.pill.fill;
      context.beginPath();
      context.roundRect(box[0] - 2, box[1], box[2] - box[0] + 4, box[3] - box[1], 3);
      context.fill();
    }
    let top = y - high / 2;
    for (const line of lines) {
      const baseline = top + line.px * 0.98;
      top += line.px * 1.25;
      const at = align === 'left' ? left : align === 'right' ? left + wide - line.wide : left + (wide - line.wide) / 2;
      context.font = font(line);
      if (!label.pill) {
        context.strokeStyle = palette.halo;
        context.lineWidth = Math.max(3, line.px * HALO * 1.1);
        context.strokeText(line.text, at, baseline);
      }
      context.fillStyle = label.pill ? label.pill.ink : palette.label;
      context.fillText(line.text, at, baseline);
    }
    return true;
  }

  destroy() {
    this.canvas.remove();
  }
}

const SIGN_PX = 9;
const SIGNS = { 1: [[-1, -1], [1, -1], [1, 1], [-1, 1]], 2: [[0, -1.15], [1.15, 1], [-1.15, 1]], 3: [[0, -1.3], [1.3, 0], [0, 1.3], [-1.3, 0]] };

const MOST_DISCS = 400;
const discs = new Map(); // what it says and how it looks -> its picture: the same few are drawn again and again

/** A disc with its count; the sign of the worst inside it sits on its shoulder, as shape, number and colour. */
function drawCluster(context, { cluster, lines }, x, y, palette, taken, texts) {
  const radius = (cluster.px / 2) * palette.scale;
  taken.push([x - radius, y - radius, x + radius, y + radius]);
  const [line] = lines;
  texts.push(line.text);
  const ratio = window.devicePixelRatio || 1;
  const key = [line.text, cluster.px, cluster.level, cluster.isAsking, cluster.fill, palette.halo, palette.scale, ratio, document.fonts.status].join();
  let picture = discs.get(key);
  if (!picture) {
    if (discs.size >= MOST_DISCS) discs.clear();
    discs.set(key, (picture = discPicture(cluster, line, radius, palette, ratio)));
  }
  const half = picture.width / 2 / ratio;
  context.drawImage(picture, Math.round(x * ratio) / ratio - half, Math.round(y * ratio) / ratio - half, 2 * half, 2 * half);
  return true;
}

function discPicture(cluster, line, radius, palette, ratio) {
  const half = Math.ceil(radius * 1.8 + (SIGN_PX + 4) * palette.scale);
  const picture = document.createElement('canvas');
  picture.width = picture.height = Math.round(2 * half * ratio);
  const context = picture.getContext('2d');
  context.scale(ratio, ratio);
  context.translate(half, half);
  context.beginPath();
  context.arc(0, 0, radius, 0, 7);
  context.fillStyle = cluster.fill;
  context.fill();
  context.lineWidth = 2.5;
  context.strokeStyle = palette.halo;
  context.stroke();
  context.font = `${line.weight} ${line.size * palette.scale}px ${palette.font}`;
  context.fillStyle = cluster.ink;
  const wide = context.measureText(line.text).width;
  context.fillText(line.text, -wide / 2, line.size * palette.scale * 0.36);
  if (cluster.level) drawSign(context, cluster, radius * 0.78, -radius * 0.78, palette);
  return picture;
}

function drawSign(context, { level, isAsking }, x, y, palette) {
  const half = SIGN_PX * palette.scale;
  const trace = (size) => {
    context.beginPath();
    if (SIGNS[level]) SIGNS[level].forEach(([sx, sy]) => context.lineTo(x + sx * size, y + sy * size));
    else context.arc(x, y, size, 0, 7);
    context.closePath();
  };
  trace(half + 3);
  context.fillStyle = isAsking ? palette.ink : palette.halo; // a ring: nobody has seen it yet
  context.fill();
  if (isAsking) {
    trace(half + 1.5);
    context.fillStyle = palette.halo;
    context.fill();
  }
  trace(half);
  context.fillStyle = palette[`p${level}`];
  context.fill();
  context.font = `800 ${11 * palette.scale}px ${palette.font}`;
  context.fillStyle = palette[`onP${level}`];
  context.fillText(String(level), x - context.measureText(String(level)).width / 2, y + 4 * palette.scale + (level === 2 ? 2 : 0));
}
