// Strokes, texts and boxes on the canvas over the map.

const HALO = 0.3; // of the type size

export const fontOf = (palette, size, weight) => `${weight} ${(size * palette.scale).toFixed(1)}px ${palette.font}`;

export function trace(context, points, isClosed = false) {
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (isClosed) context.closePath();
}

export function line(context, points, colour, width, isClosed = false) {
  context.beginPath();
  trace(context, points, isClosed);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

export function dashed(context, pattern, draw) {
  context.setLineDash(pattern);
  draw();
  context.setLineDash([]);
}

export function disc(context, x, y, radius, { fill = null, stroke = null, width = 1, alpha = 1 }) {
  context.globalAlpha = alpha;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  if (fill) {
    context.fillStyle = fill;
    context.fill();
  }
  context.globalAlpha = 1;
  if (!stroke) return;
  context.strokeStyle = stroke;
  context.lineWidth = width;
  context.stroke();
}

export function square(context, x, y, size, { fill, stroke, width }) {
  const half = (size - width) / 2;
  context.beginPath();
  context.rect(x - half, y - half, 2 * half, 2 * half);
  context.fillStyle = fill;
  context.fill();
  context.strokeStyle = stroke;
  context.lineWidth = width;
  context.stroke();
}

/** A text that stays readable on anything. */
export function haloText(context, text, x, y, { palette, size, weight = 650, align = 'center' }) {
  context.font = fontOf(palette, size, weight);
  context.textAlign = align;
  context.textBaseline = 'middle';
  context.lineJoin = 'round';
  context.strokeStyle = palette.halo;
  context.lineWidth = size * palette.scale * HALO;
  context.strokeText(text, x, y);
  context.fillStyle = palette.label;
  context.fillText(text, x, y);
}

/** A length on its edge, turned along it and never upside down. */
export function pill(context, text, x, y, angle, palette) {
  const isFlipped = Math.cos(angle) < -1e-9;
  context.save();
  context.translate(x, y);
  context.rotate(isFlipped ? angle + Math.PI : angle);
  context.font = fontOf(palette, 16, 650);
  const width = context.measureText(text).width + 26 * palette.scale;
  const height = 30 * palette.scale;
  context.beginPath();
  context.roundRect(-width / 2, -height / 2, width, height, 6);
  context.fillStyle = palette.raised;
  context.fill();
  context.strokeStyle = palette.ink2;
  context.globalAlpha = 0.6;
  context.lineWidth = 1;
  context.stroke();
  context.globalAlpha = 1;
  context.fillStyle = palette.ink;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(text, 0, 0.5);
  context.restore();
}

/** Dark box beside a corner: what it is called and how far it went, and what holds it. Never outside the map. */
export function tooltip(context, lines, [x, y], palette, { width, height }) {
  const { scale } = palette;
  const fonts = lines.map((_, i) => (i ? fontOf(palette, 15, 500) : fontOf(palette, 16.5, 700)));
  const widths = lines.map((text, i) => {
    context.font = fonts[i];
    return context.measureText(text).width;
  });
  const wide = Math.max(...widths) + 30 * scale;
  const high = (lines.length * 27 + 20) * scale;
  const left = Math.max(8, x + 38 + wide + 8 <= width ? x + 38 : x - 38 - wide); // on the other side where the map ends
  const top = Math.min(Math.max(8, y + 18), height - high - 8);
  context.beginPath();
  context.roundRect(left, top, wide, high, 6);
  context.fillStyle = palette.ink;
  context.fill();
  context.fillStyle = palette.raised;
  context.textAlign = 'left';
  context.textBaseline = 'middle';
  lines.forEach((text, i) => {
    context.font = fonts[i];
    context.fillText(text, left + 15 * scale, top + (10 + 13.5 + 27 * i) * scale);
  });
}
