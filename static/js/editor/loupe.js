// A round glass above the finger, twice the size, while something is dragged by touch.

const RADIUS_PX = 66;
const ABOVE_PX = 118; // the finger and its shadow end here
const TIMES = 2;
const EDGE_PX = 8;

export class Loupe {
  constructor(host) {
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'hl-edit-loupe';
    this.canvas.setAttribute('aria-hidden', 'true');
    this.canvas.hidden = true;
    this.canvas.dataset.testid = 'edit-loupe';
    host.append(this.canvas);
    this.context = this.canvas.getContext('2d');
  }

  get isShown() {
    return !this.canvas.hidden;
  }

  hide() {
    this.canvas.hidden = true;
  }

  /**
   * Show what lies around `place` (px of the map), for a finger at `finger`; `pictures` are canvases of the map's size,
   * bottom to top. Called within a frame of the map: its picture is gone afterwards.
   */
  show(place, finger, pictures, camera, ground) {
    const ratio = window.devicePixelRatio || 1;
    const size = Math.round(2 * RADIUS_PX * ratio);
    if (this.canvas.width !== size) this.canvas.width = this.canvas.height = size;
    const { context } = this;
    context.fillStyle = ground;
    context.fillRect(0, 0, size, size);
    for (const picture of pictures) {
      const scale = picture.width / camera.width;
      const cut = (2 * RADIUS_PX * scale) / TIMES;
      context.drawImage(picture, place[0] * scale - cut / 2, place[1] * scale - cut / 2, cut, cut, 0, 0, size, size);
    }
    const x = Math.min(Math.max(finger[0], RADIUS_PX + EDGE_PX), camera.width - RADIUS_PX - EDGE_PX);
    let y = finger[1] - ABOVE_PX;
    if (y < RADIUS_PX + EDGE_PX) y = finger[1] + ABOVE_PX; // no room above: below
    this.canvas.style.transform = `translate(${Math.round(x - RADIUS_PX)}px, ${Math.round(y - RADIUS_PX)}px)`;
    this.canvas.hidden = false;
  }

  destroy() {
    this.canvas.remove();
  }
}
