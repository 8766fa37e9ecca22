// Which texts stand on the map: fields, homes, obstacles, and what is known about each robot.

import { areaM2, boxOf, labelPoint, mercX, mercY, polygonParts, roomAround } from './geometry.js';
import { clockTime, upTo } from './robots.js';

const NAMED = new Set(['parcel', 'home', 'obstacle', 'building', 'no-go', 'no_go']);
const MOST_GHOST_NAMES = 30;
const MOST_LETTERS = 30; // of what is wrong, beside a robot; the list has all of it
const SMALL_PX = 11; // around the others, as long as they are few, no name of a place
const MOST_CLEAR = 60;
const HOMES_PX = 84; // the width of "Home, bay 12"
const BODY_PX = 26; // around the chosen robot no name of the farm may stand

/** Field area as a person says it: "17.26 ha", small ones in m2. */
export function areaText(m2) {
  return m2 < 1000 ? `${Math.round(m2)} m²` : `${(m2 / 10000).toFixed(2)} ha`;
}

/** Texts that stay where they are: one per named feature. */
export function farmLabels(features) {
  const labels = [];
  for (const feature of features) {
    const { kind, name, crop, area_m2: declared } = feature.properties ?? {};
    if (!NAMED.has(kind) || (!name && kind !== 'home')) continue;
    const parts = polygonParts(feature.geometry);
    const lines = [{ text: name || 'Home', size: kind === 'parcel' ? 18 : 12, weight: kind === 'parcel' ? 650 : 600 }];
    if (kind === 'parcel' && parts.length) {
      const area = areaText(declared || parts.reduce((sum, rings) => sum + areaM2(rings), 0));
      lines.push({ text: crop ? `${crop}, ${area}` : area, size: 13, weight: 550 });
    }
    const at = labelAt(feature, parts);
    if (at) labels.push({ mx: mercX(at[0]), my: mercY(at[1]), lines, kind, name, priority: kind === 'parcel' ? 50 : 20, room: parts.length ? roomAround(parts[0][0], at) : null, ...extent(feature) });
  }
  return labels;
}

function labelAt(feature, parts) {
  if (parts.length) return labelPoint(parts[0][0]);
  if (feature.geometry?.type === 'Point') return feature.geometry.coordinates;
  return null;
}

function extent(feature) {
  const box = boxOf([feature]);
  return { widthM: box ? box[2] - box[0] : 0 };
}

/** Farm texts that make sense at this zoom: a name wider than its field would say the wrong thing. */
export function readableLabels(labels, camera) {
  const readable = labels.filter((label) => label.kind === 'home' || label.widthM === 0
    ? camera.zoom > 15
    : label.widthM * camera.worldPx > (label.kind === 'parcel' ? 70 : 34));
  const homes = readable.filter((label) => label.kind === 'home');
  return homes.length < 2 ? readable : [...readable.filter((label) => label.kind !== 'home'), ...together(homes, camera)];
}

/** Homes that stand closer than their names are wide get one name: "Home" and how many they are. */
function together(homes, camera) {
  const groups = [];
  for (const home of homes) {
    const near = groups.find(([first]) => Math.hypot(...apart(first, home, camera)) < HOMES_PX);
    if (near) near.push(home);
    else groups.push([home]);
  }
  return groups.map((group) => (group.length === 1 ? group[0] : grouped(group)));
}

function apart(one, other, camera) {
  const [x, y] = camera.project(one.mx, one.my);
  const [u, v] = camera.project(other.mx, other.my);
  return [u - x, v - y];
}

function grouped(group) {
  const mean = (key) => group.reduce((sum, one) => sum + one[key], 0) / group.length;
  const names = group.map((one) => one.lines[0].text.split(/,| (?=\d)/)[0].trim());
  const name = names.every((one) => one === names[0]) ? names[0] : 'Homes';
  const [first] = group;
  return { ...first, mx: mean('mx'), my: mean('my'), dx: 0, dy: 0, name, lines: [{ ...first.lines[0], text: name }, { text: `${group.length} places`, size: 12, weight: 550 }] };
}

/** Texts beside robots. `look`: {ageOf, reachOf, selected, isFleet, palette, now}. */
export function robotLabels(robots, look) {
  const labels = [];
  const isFew = look.count <= MOST_CLEAR;
  let ghosts = 0;
  for (const robot of robots) {
    if (!robot.pose) continue;
    const pose = robot.drawn(look.now);
    const at = { mx: pose.mx, my: pose.my, isFixed: robot.id === look.selected };
    if (robot.id === look.selected) labels.push({ ...at, lines: [], clearPx: BODY_PX, priority: 95 });
    else if (isFew) labels.push({ mx: pose.mx, my: pose.my, lines: [], clearPx: SMALL_PX, isSoft: true, priority: 93 });
    if (robot.stop === 'not-confirmed') labels.push(...dangerLabels(robot, at, look));
    else if (robot.isStale && (robot.id === look.selected || ghosts < MOST_GHOST_NAMES)) {
      ghosts += 1;
      labels.push(ghostLabel(robot, at, look));
      if (look.isFleet && robot.level === 1 && !robot.isQuiet) labels.push({ ...fleetLabel(robot, at, look), priority: 91 }); // it fell silent in danger: that before when it was seen
    } else if (look.isFleet) {
      const label = fleetLabel(robot, at, look);
      if (label) labels.push(label);
    }
  }
  return labels;
}

/** "last seen 14:36:20 / within 5 m if it kept going". */
export function ghostTexts(robot, look) {
  const age = look.ageOf(robot);
  const reach = look.reachOf(robot);
  const seen = Number.isFinite(age) ? `last seen ${clockTime(age)}` : 'last seen some time ago';
  if (reach === null) return [seen, 'its speed is not known'];
  if (robot.pose.speed === 0) return [seen, 'it stood still then'];
  return [seen, `within ${upTo(reach)} if it kept going`];
}

function ghostLabel(robot, at, look) {
  const [seen, reach] = ghostTexts(robot, look);
  const lines = [{ text: seen, size: 14, weight: 650 }, { text: reach, size: 12, weight: 560 }];
  if (look.isFleet) lines.unshift({ text: robot.name, size: 13, weight: 650 });
  const radius = (look.reachOf(robot) ?? 0) / look.metresPerPx;
  return { ...at, lines, dx: -Math.max(32, Math.min(radius, 140) + 8), align: 'right', priority: 90 };
}

function dangerLabels(robot, at, look) {
  const keepOut = robot.body?.keep_out_m || 15;
  const reach = look.reachOf(robot);
  const px = (metres) => metres / look.metresPerPx;
  const name = look.isFleet ? `${robot.name} not confirmed` : `keep out ${upTo(keepOut)}`;
  const ring = Math.max(px(keepOut), 32);
  const labels = [look.isFleet
    ? { ...at, lines: [{ text: name, size: 13, weight: 700 }], dx: 20, align: 'left', priority: 100, isFixed: true, pill: { fill: look.palette.p1, ink: look.palette.onP1 } }
    : { ...at, lines: [{ text: name, size: 20, weight: 700 }], dy: -ring - 18, priority: 100, isFixed: true }];
  if (reach !== null && robot.pose && !look.isFleet) {
    const text = robot.isStale ? `may be here, within ${upTo(Math.max(reach, 0.1))}` : 'may still be moving';
    labels.push({ ...at, lines: [{ text, size: 17, weight: 650 }], dy: Math.max(px(reach), 23) + 22, priority: 99, isFixed: true });
  }
  return labels;
}

/** A cluster says how many it is, and carries the worst sign in it. */
export function clusterLabels(clusters, palette) {
  return clusters.map((one) => ({
    mx: one.mx, my: one.my, lines: [{ text: String(one.count), size: 14, weight: 700 }], priority: one.level ? 90 - one.level : 40, isFixed: true,
    cluster: { level: one.level, isAsking: one.isAsking, px: one.px, fill: palette.sel, ink: palette.onSel },
  }));
}

const shortened = (text) => (text.length > MOST_LETTERS ? `${text.slice(0, MOST_LETTERS - 1).trimEnd()}…` : text);

function fleetLabel(robot, at, look) {
  const { palette } = look;
  if (robot.level && !robot.isQuiet) {
    const text = robot.text ? `${robot.name} ${shortened(robot.text)}` : robot.name;
    const pill = { fill: palette[`p${robot.level}`], ink: palette[`onP${robot.level}`] };
    return { ...at, lines: [{ text, size: 13, weight: 650 }], dx: 18, align: 'left', priority: 80 - robot.level, pill };
  }
  if (robot.id !== look.selected && !look.isNear) return null;
  return { ...at, lines: [{ text: robot.name, size: 12, weight: 600 }], dy: 22, priority: robot.id === look.selected ? 60 : 10 };
}
