// Fingers and mouse over the map: who may move what. One finger is the tool's, two fingers are always the map's.

export const TAP_PX = 6;

/**
 * act: {grab(at, event) -> gesture or null, tap(at, event), hover(at), hold(), share(), release()};
 * a gesture has move(at, event), finish(), tap(at, event) and cancel().
 */
export class Pointer {
  constructor(target, act) {
    this.target = target;
    this.act = act;
    this.fingers = new Map();
    this.gesture = null;
    this.listeners = [
      [target, 'pointerdown', (event) => this.#down(event)],
      [target, 'pointermove', (event) => this.#hover(event)],
      [target, 'pointerleave', () => act.hover(null)],
      [window, 'pointermove', (event) => this.#move(event)],
      [window, 'pointerup', (event) => this.#up(event)],
      [window, 'pointercancel', (event) => this.#up(event)],
      [target, 'contextmenu', (event) => event.preventDefault()],
    ];
    for (const [on, name, listener] of this.listeners) on.addEventListener(name, listener, { capture: true });
  }

  at(event) {
    const box = this.target.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #down(event) {
    if (event.button > 0) return;
    const at = this.at(event);
    this.fingers.set(event.pointerId, at);
    if (this.fingers.size > 1) {
      this.isSeveral = true;
      this.cancel();
      this.act.share();
      return;
    }
    this.isSeveral = false;
    this.hasMoved = false;
    this.start = at;
    this.gesture = this.act.grab(at, event);
    if (this.gesture) this.act.hold();
  }

  #hover(event) {
    if (!this.fingers.size && event.pointerType !== 'touch') this.act.hover(this.at(event));
  }

  #move(event) {
    if (!this.fingers.has(event.pointerId)) return;
    const at = this.at(event);
    this.fingers.set(event.pointerId, at);
    if (this.isSeveral) return;
    this.hasMoved ||= Math.hypot(at[0] - this.start[0], at[1] - this.start[1]) > TAP_PX;
    if (this.hasMoved) this.gesture?.move(at, event);
  }

  #up(event) {
    if (!this.fingers.delete(event.pointerId)) return;
    const { gesture } = this;
    if (!this.isSeveral && event.type === 'pointerup') {
      this.gesture = null;
      if (gesture && this.hasMoved) gesture.finish();
      else if (gesture) gesture.tap(this.at(event), event);
      else if (!this.hasMoved) this.act.tap(this.at(event), event);
    } else this.cancel();
    if (!this.fingers.size) this.act.release();
  }

  /** Give up what is being dragged; everything goes back to where it was. */
  cancel() {
    const { gesture } = this;
    this.gesture = null;
    gesture?.cancel();
  }

  destroy() {
    this.cancel();
    for (const [on, name, listener] of this.listeners) on.removeEventListener(name, listener, { capture: true });
  }
}
