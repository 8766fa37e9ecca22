// Keys of the drawing surface while it has the focus; tools and undo of the draft are keys of the screen around it.

const STEP_M = 0.1;
const WIDE_STEP_M = 1; // with Shift
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Keyboard {
  /** act: {isDrawing(), push(east, north) -> bool, settle(), finish(), escape() -> bool, undoPoint(), remove(), step(by) -> bool}. */
  constructor(host, act) {
    this.act = act;
    this.host = host;
    this.held = new Set();
    this.listeners = {
      keydown: (event) => this.#down(event),
      keyup: (event) => this.#up(event),
      focusout: () => this.#settle(),
    };
    for (const [name, listener] of Object.entries(this.listeners)) host.addEventListener(name, listener);
  }

  #down(event) {
    if (event.target.closest('button, input, select, textarea')) return; // buttons on the map keep their keys
    if (this.#isTaken(event)) event.preventDefault();
  }

  #isTaken(event) {
    const { act } = this;
    const { key } = event;
    const isCommand = event.ctrlKey || event.metaKey;
    if (isCommand && key.toLowerCase() === 'z' && !event.shiftKey && act.isDrawing()) {
      event.stopPropagation(); // the point, not the draft's last change
      act.undoPoint();
      return true;
    }
    if (isCommand || event.altKey) return false;
    if (key in ARROWS) return this.#arrow(event);
    if (key === 'Escape') return act.escape();
    if (key === 'Enter' && act.isDrawing()) act.finish();
    else if (key === 'Backspace' && act.isDrawing()) act.undoPoint();
    else if (key === 'Delete' || key === 'Backspace') act.remove();
    else if (key === 'PageDown' || key === 'PageUp') return act.step(key === 'PageDown' ? 1 : -1);
    else return false;
    return true;
  }

  #arrow({ key, shiftKey }) {
    const step = shiftKey ? WIDE_STEP_M : STEP_M;
    const [east, north] = ARROWS[key];
    if (!this.act.push(east * step, north * step)) return true;
    this.held.add(key);
    return true;
  }

  #up({ key }) {
    if (this.held.delete(key) && !this.held.size) this.act.settle();
  }

  #settle() {
    if (!this.held.size) return;
    this.held.clear();
    this.act.settle();
  }

  destroy() {
    for (const [name, listener] of Object.entries(this.listeners)) this.host.removeEventListener(name, listener);
  }
}
