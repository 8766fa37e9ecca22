// Where the map gets its data: the live lane (`window.headland`), REST for geometry, STOP states from the page.

const RETRY_FIRST_MS = 1000;
const RETRY_MOST_MS = 15000;
const LANE_WAIT_MS = 100;

/** Subscription to one topic of the live lane; waits for the lane's script when that is still loading. */
export class LaneTopic {
  constructor(topic, changed) {
    this.topic = topic;
    this.changed = changed;
    this.#attach();
  }

  #attach() {
    const lane = window.headland;
    if (!lane?.on) {
      this.timer = setTimeout(() => this.#attach(), LANE_WAIT_MS);
      return;
    }
    this.off = lane.on(this.topic, (state, _topic, names) => this.changed(state ?? {}, names));
  }

  destroy() {
    clearTimeout(this.timer);
    this.off?.();
  }
}

/** Console time in ms, NaN before the first tick: then every age is unknown, and what is drawn counts as old. */
export function laneNow() {
  return window.headland?.now?.() ?? NaN;
}

/** Revision of the lane last applied, or null. */
export function laneRevision() {
  const revision = window.headland?.revision?.();
  return Number.isFinite(revision) ? revision : null;
}

/** GeoJSON from our own origin, asked again with growing pauses until it arrives; `told(state, collection)`. */
export class Geometry {
  /** `reading()` fetches what it takes to read the answer, beside the answer; failing, it is asked again like that. */
  constructor(told, reading = null) {
    Object.assign(this, { told, reading, url: null });
  }

  /** Load `url`; `isMissingOk`: 404 means there is none. Nothing happens when it is loaded already and `key` is the same. */
  load(url, { key = url, isMissingOk = false } = {}) {
    if (this.key === key) return;
    this.stop();
    Object.assign(this, { key, url, isMissingOk, pause: RETRY_FIRST_MS, state: null });
    this.#ask();
  }

  retry() {
    if (!this.url || this.state === 'loaded') return;
    clearTimeout(this.timer);
    this.pause = RETRY_FIRST_MS;
    this.#ask();
  }

  async #ask() {
    this.abort?.abort();
    const abort = (this.abort = new AbortController());
    if (this.state !== 'failed') this.#tell('loading'); // what is wrong stays said until it is right
    try {
      const reading = this.reading?.();
      reading?.catch(() => {}); // told below, if the answer comes
      const answer = await fetch(this.url, { signal: abort.signal, credentials: 'same-origin', cache: 'no-cache', headers: { Accept: 'application/geo+json, application/json' } });
      if (answer.status === 404 && this.isMissingOk) return this.#tell('missing');
      if (answer.status === 401 || answer.status === 403) return this.#tell('forbidden');
      if (!answer.ok) throw new Error(`status ${answer.status}`);
      const collection = await answer.json();
      await reading;
      if (abort.signal.aborted) return undefined;
      if (!Array.isArray(collection?.features)) throw new Error('not a FeatureCollection');
      return this.#tell('loaded', { type: 'FeatureCollection', features: collection.features.filter(isDrawable) });
    } catch (error) {
      if (abort.signal.aborted) return undefined;
      console.warn(`map: ${this.url}:`, error.message);
      this.#tell('failed');
      this.timer = setTimeout(() => this.#ask(), this.pause);
      this.pause = Math.min(this.pause * 2, RETRY_MOST_MS);
      return undefined;
    }
  }

  #tell(state, collection = null) {
    this.state = state;
    this.told(state, collection);
  }

  stop() {
    clearTimeout(this.timer);
    this.abort?.abort();
    this.key = this.url = null;
  }
}

/** One broken feature must not take the map with it. */
function isDrawable(feature) {
  const { geometry } = feature ?? {};
  const isNumber = (node) => (Array.isArray(node) ? node.length > 0 && node.every(isNumber) : Number.isFinite(node));
  return Boolean(geometry && Array.isArray(geometry.coordinates) && geometry.coordinates.length && isNumber(geometry.coordinates));
}

const RANK = ['standstill', 'acknowledged', 'sent', 'not-confirmed'];

/** What STOP knows of each robot: the worst press that is not reset, from `headland:stop` (see static/js/stop.js). */
export class StopStates {
  constructor(changed) {
    this.states = new Map();
    this.changed = changed;
    this.listener = ({ detail }) => this.#take(detail);
    window.addEventListener('headland:stop', this.listener);
    if (window.headlandStop) this.#take(window.headlandStop.state());
  }

  #take(detail) {
    this.states = new Map();
    for (const { robot, state } of detail?.steps ?? []) {
      if (RANK.indexOf(state) > RANK.indexOf(this.states.get(robot))) this.states.set(robot, state);
    }
    this.changed();
  }

  /** 'stopped' (confirmed), 'not-confirmed' or null, from the press and what the robot reports ({latched, standstill}). */
  of(robotId, safety) {
    if (!safety && !this.states.size) return null;
    const state = this.states.get(robotId);
    if (state === 'not-confirmed') return 'not-confirmed';
    if (safety) return safety.latched && safety.standstill ? 'stopped' : null;
    return state === 'standstill' ? 'stopped' : null;
  }

  destroy() {
    window.removeEventListener('headland:stop', this.listener);
  }
}
