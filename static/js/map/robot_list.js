// The robots of the map as a list for assistive technology and for tests: the map itself is a picture.

const ALL_UP_TO = 60; // robots that are all brought up to date at every update
const IN_TURN = 20; // of more robots, so many each second: writing the page costs more than drawing the map
const TURN_MS = 1000;
const COMPASS = ['north', 'north-east', 'east', 'south-east', 'south', 'south-west', 'west', 'north-west'];

export class RobotList {
  constructor(host) {
    this.root = document.createElement('ul');
    this.root.className = 'hl-map-list';
    this.root.setAttribute('aria-label', 'Robots on the map');
    host.append(this.root);
    this.entries = new Map();
    this.next = 0;
  }

  /** Bring entries up to date; `now` is console time. */
  update(robots, now) {
    const isComplete = this.entries.size > ALL_UP_TO && this.entries.size === this.placed;
    if (isComplete && robots.size === this.count && now.page - this.turnedAt < TURN_MS) return undefined;
    for (const [id, entry] of this.entries) {
      if (robots.has(id) && robots.get(id).pose) continue;
      entry.remove();
      this.entries.delete(id);
    }
    const placed = [...robots.values()].filter((robot) => robot.pose);
    [this.placed, this.count, this.turnedAt] = [placed.length, robots.size, now.page];
    if (placed.length <= ALL_UP_TO) return placed.forEach((robot) => this.#entry(robot, now));
    const first = this.entries.size < placed.length ? ALL_UP_TO : IN_TURN; // complete soon, then current in turn
    for (let i = 0; i < first; i += 1) {
      this.next = (this.next + 1) % placed.length;
      this.#entry(placed[this.next], now);
    }
    return undefined;
  }

  #entry(robot, now) {
    let entry = this.entries.get(robot.id);
    if (!entry) {
      entry = document.createElement('li');
      entry.dataset.testid = `map-robot-${robot.id}`;
      this.root.append(entry);
      this.entries.set(robot.id, entry);
    }
    const { pose } = robot;
    const age = robot.ageMs(now);
    write(entry, 'lat', String(pose.lat));
    write(entry, 'lon', String(pose.lon));
    write(entry, 'headingDeg', String(pose.headingDeg ?? ''));
    write(entry, 'ageMs', Number.isFinite(age) ? String(Math.round(age)) : '');
    write(entry, 'state', robot.stop ?? (robot.isStale ? 'stale' : 'fresh'));
    const text = describe(robot);
    if (entry.hlText !== text) entry.textContent = entry.hlText = text;
  }

  destroy() {
    this.root.remove();
  }
}

function write(entry, key, value) {
  if (entry.dataset[key] !== value) entry.dataset[key] = value;
}

function describe(robot) {
  const parts = [robot.name];
  if (robot.stop === 'not-confirmed') parts.push('stop not confirmed');
  else if (robot.stop === 'stopped') parts.push('stopped');
  else if (robot.text) parts.push(robot.text);
  if (robot.isStale) parts.push('position is old');
  else if (robot.pose.headingDeg !== null) parts.push(`heading ${COMPASS[Math.round(robot.pose.headingDeg / 45) & 7]}`);
  return parts.join(', ');
}
