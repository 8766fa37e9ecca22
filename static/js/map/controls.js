// Buttons, scale, north arrow and notices over the map. Signs are drawn here: no icon font is needed.

const SIGNS = {
  follow: 'M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8Zm9 3h-2.06A7 7 0 0 0 13 5.06V3h-2v2.06A7 7 0 0 0 5.06 11H3v2h2.06A7 7 0 0 0 11 18.94V21h2v-2.06A7 7 0 0 0 18.94 13H21Zm-9 6a5 5 0 1 1 0-10 5 5 0 0 1 0 10Z',
  fit: 'M3 9V3h6v2H5v4Zm12-6h6v6h-2V5h-4ZM5 15v4h4v2H3v-6Zm14 0h2v6h-6v-2h4Zm-8-7h2v8h-2Z',
  layers: 'm12 3 9 7-9 7-9-7Zm0 2.5L6.3 10 12 14.5 17.7 10ZM4.6 13.2 12 19l7.4-5.8L21 14.5l-9 7-9-7Z',
  plus: 'M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6Z',
  minus: 'M5 11h14v2H5Z',
  north: 'M12 2 19 21l-7-4.5L5 21Z',
};
const SCALE_STEPS = [1, 2, 5];
const SCALE_MOST_PX = 116;
const EDGE_PX = 16;

const SVG = 'http://www.w3.org/2000/svg';

function sign(name) {
  const svg = document.createElementNS(SVG, 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS(SVG, 'path');
  path.setAttribute('d', SIGNS[name]);
  svg.append(path);
  return svg;
}

function node(tag, className, ...children) {
  const made = document.createElement(tag);
  made.className = className;
  made.append(...children);
  return made;
}

function button(className, label, signName, hook, act) {
  const made = node('button', className, sign(signName));
  made.type = 'button';
  made.title = label;
  made.setAttribute('aria-label', label);
  made.dataset.testid = hook;
  made.addEventListener('click', act);
  return made;
}

/** Longest round length whose bar fits: [metres, px]. */
export function scaleBar(metresPerPx) {
  const most = SCALE_MOST_PX * metresPerPx;
  const power = 10 ** Math.floor(Math.log10(most));
  const metres = SCALE_STEPS.map((step) => step * power).filter((length) => length <= most).at(-1);
  return [metres, metres / metresPerPx];
}

/** Control block of one map; `act`: {follow, fit, zoom(step), north, layer(name, isOn), menu(node), retry}. */
export class Controls {
  constructor(host, { mode, hasButtons, layers, act }) {
    this.root = node('div', 'hl-map-controls');
    this.first = mode !== 'robot'
      ? button('hl-map-button', `Show all ${mode === 'fleet' ? 'robots' : 'stations'}`, 'fit', 'map-fit', act.fit)
      : button('hl-map-button', 'Follow robot', 'follow', 'map-follow', act.follow);
    const menu = button('hl-map-button', 'Layers', 'layers', 'map-layers', () => this.#toggleMenu());
    menu.setAttribute('aria-expanded', 'false');
    this.menuButton = menu;
    this.buttons = node('div', 'hl-map-buttons', this.first, menu,
      button('hl-map-button', 'Zoom in', 'plus', 'map-zoom-in', () => act.zoom(1)),
      button('hl-map-button', 'Zoom out', 'minus', 'map-zoom-out', () => act.zoom(-1)));
    this.menu = this.#layerMenu(layers, act);
    this.north = button('hl-map-north', 'North is up', 'north', 'map-north', act.north);
    this.north.append(node('span', '', 'N'));
    this.scaleText = node('span', 'hl-map-scale-text');
    this.scaleBar = node('i', 'hl-map-scale-bar');
    this.foot = node('div', 'hl-map-foot', this.north, node('div', 'hl-map-scale', this.scaleText, this.scaleBar));
    this.notice = node('div', 'hl-map-notice');
    this.notice.setAttribute('role', 'status');
    this.notice.dataset.testid = 'map-notice';
    this.notice.hidden = true;
    if (hasButtons) this.root.append(this.buttons, this.menu, this.foot);
    this.root.append(this.notice);
    host.append(this.root);
    this.act = act;
  }

  /** Px of the edges to leave free: `least`, and what buttons, north arrow and scale stand on. [top, right, bottom, left] */
  freePx(least) {
    const { offsetWidth: wide, offsetHeight: high } = this.buttons; // 0 without buttons
    const taken = (size) => Math.max(least, size && size + 2 * EDGE_PX);
    const bottom = Math.max(least, this.foot.offsetHeight);
    return wide > high ? [taken(high), least, bottom, least] : [least, taken(wide), bottom, least]; // low maps have them in a row
  }

  #layerMenu(layers, act) {
    const menu = node('div', 'hl-map-menu');
    menu.setAttribute('role', 'group');
    menu.setAttribute('aria-label', 'Layers');
    menu.hidden = true;
    for (const { name, label, isOn } of layers) {
      const box = document.createElement('input');
      box.type = 'checkbox';
      box.checked = isOn;
      box.dataset.testid = `map-layer-${name}`;
      box.addEventListener('change', () => act.layer(name, box.checked));
      menu.append(node('label', 'hl-map-layer', box, node('span', '', label)));
    }
    menu.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape') return;
      this.#toggleMenu();
      this.menuButton.focus();
    });
    return menu;
  }

  #toggleMenu() {
    this.menu.hidden = !this.menu.hidden;
    this.menuButton.setAttribute('aria-expanded', String(!this.menu.hidden));
    if (!this.menu.hidden) this.act.menu?.(this.menu);
  }

  closeMenu() {
    if (!this.menu.hidden) this.#toggleMenu();
  }

  setFollowing(isFollowing) {
    this.first.setAttribute('aria-pressed', String(isFollowing));
  }

  setCamera(camera) {
    const [metres, px] = scaleBar(camera.metresPerPx);
    const text = metres >= 1000 ? `${metres / 1000} km` : metres < 1 ? `${Math.round(metres * 100)} cm` : `${metres} m`;
    if (this.scaleText.textContent !== text) this.scaleText.textContent = text;
    this.scaleBar.style.width = `${Math.round(px)}px`;
    const isTurned = Math.abs(camera.bearing) > 0.5;
    this.north.firstChild.style.transform = `rotate(${-camera.bearing}deg)`;
    const label = isTurned ? 'Turn north up' : 'North is up';
    if (this.north.title !== label) {
      this.north.title = label;
      this.north.setAttribute('aria-label', label);
    }
  }

  /** One sentence over the map, or none; with a way to try again when that can help. */
  setNotice(text, { canRetry = false, isSmall = false } = {}) {
    const key = `${text}|${canRetry}|${isSmall}`;
    if (this.shown === key) return;
    this.shown = key;
    this.notice.hidden = !text;
    this.notice.classList.toggle('hl-map-notice-small', isSmall);
    this.notice.replaceChildren(node('span', '', text ?? ''));
    if (!canRetry) return;
    const again = node('button', 'hl-map-retry', 'Try again');
    again.type = 'button';
    again.addEventListener('click', () => this.act.retry());
    this.notice.append(again);
  }

  destroy() {
    this.root.remove();
  }
}
