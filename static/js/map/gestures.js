// Fingers, mouse and wheel for the canvas engine: one finger pans, two pinch and turn, double tap zooms.

const DOUBLE_TAP_MS = 320;
const DOUBLE_TAP_PX = 32;
const TAP_PX = 8;
const WHEEL_PX_PER_ZOOM = 450;
const TURN_DEADBAND_DEG = 10; // a pinch must not turn the map by accident

/** Calls `act` ({pan, zoomAround, turnAround, tap, start}) for what the fingers on `target` do. */
export class Gestures {
  constructor(target, act) {
    this.target = target;
    this.act = act;
    this.fingers = new Map();
    this.lastTap = null;
    this.listeners = {
      pointerdown: (event) => this.#down(event),
      pointermove: (event) => this.#move(event),
      pointerup: (event) => this.#up(event),
      pointercancel: (event) => this.#up(event),
      wheel: (event) => this.#wheel(event),
    };
    for (const [name, listener] of Object.entries(this.listeners)) target.addEventListener(name, listener, { passive: false });
  }

  get isActive() {
    return this.fingers.size > 0;
  }

  #at(event) {
    const box = this.target.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #down(event) {
    if (event.button > 0) return;
    this.target.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.#at(event));
    this.travelled = this.fingers.size > 1 ? Infinity : 0;
    this.turned = 0;
    this.isTurning = false;
    this.act.start();
  }

  #move(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const now = this.#at(event);
    if (this.fingers.size === 1) {
      this.travelled += Math.hypot(now[0] - before[0], now[1] - before[1]);
      if (this.travelled > TAP_PX) this.act.pan(now[0] - before[0], now[1] - before[1]);
    } else if (this.fingers.size === 2) {
      const [otherId] = [...this.fingers.keys()].filter((id) => id !== event.pointerId);
      this.#pinch(before, now, this.fingers.get(otherId));
    }
    this.fingers.set(event.pointerId, now);
  }

  #pinch(before, now, other) {
    const span = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
    const angle = (p) => (Math.atan2(p[1] - other[1], p[0] - other[0]) * 180) / Math.PI;
    const middle = [(now[0] + other[0]) / 2, (now[1] + other[1]) / 2];
    const turn = ((angle(now) - angle(before) + 540) % 360) - 180;
    this.turned += turn;
    if (Math.abs(this.turned) > TURN_DEADBAND_DEG) this.isTurning = true;
    this.act.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    this.act.zoomAround(middle[0], middle[1], Math.log2(span(now) / Math.max(span(before), 1)));
    if (this.isTurning) this.act.turnAround(middle[0], middle[1], -turn);
  }

  #up(event) {
    if (!this.fingers.delete(event.pointerId)) return;
    if (event.type === 'pointerup' && this.travelled <= TAP_PX) this.#tap(this.#at(event), event.timeStamp);
    this.travelled = Infinity;
    this.act.end();
  }

  #tap(place, time) {
    const last = this.lastTap;
    if (last && time - last.time < DOUBLE_TAP_MS && Math.hypot(place[0] - last.place[0], place[1] - last.place[1]) < DOUBLE_TAP_PX) {
      this.lastTap = null;
      this.act.zoomAround(place[0], place[1], 1);
      return;
    }
    this.lastTap = { time, place };
    this.act.tap(place[0], place[1]);
  }

  #wheel(event) {
    event.preventDefault();
    const [x, y] = this.#at(event);
    this.act.zoomAround(x, y, -event.deltaY * (event.deltaMode === 1 ? 16 : 1) / WHEEL_PX_PER_ZOOM);
  }

  destroy() {
    for (const [name, listener] of Object.entries(this.listeners)) this.target.removeEventListener(name, listener);
  }
}
