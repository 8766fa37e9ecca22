// Robots that would lie on each other are drawn as one disc. Cells are fixed on the ground for a zoom, so that discs
// do not move with the robots in them, nor jump when the map is dragged; what may still be moving after STOP is never put into one.

const CELL_PX = 44;
const LEAST = 3; // two machines side by side can still be told apart

/** The grid changes in steps of half a zoom, not with each notch of a wheel. */
export const stepOf = (camera) => Math.floor(camera.zoom * 2);

/** {of: Map robot id -> cluster, list: [{mx, my, count, level, isAsking, px, ids}]} */
export function clustersOf(robots, camera, { now, current = null, scale = 1 }) {
  const cells = new Map();
  const zoom = stepOf(camera) / 2;
  const size = (CELL_PX * scale) / (512 * 2 ** zoom);
  for (const robot of robots) {
    if (!robot.pose || robot.isOut || robot.id === current || robot.stop === 'not-confirmed') continue;
    const { mx, my } = robot.drawn(now);
    const [column, row] = [Math.floor(mx / size), Math.floor(my / size)];
    const key = column * 4294967296 + row;
    const cell = cells.get(key);
    if (cell) {
      cell.robots.push(robot);
    } else cells.set(key, { robots: [robot], mx: (column + 0.5) * size, my: (row + 0.5) * size });
  }
  const of = new Map();
  const list = [];
  for (const cell of cells.values()) {
    const count = cell.robots.length;
    if (count < LEAST || spreadPx(cell.robots, camera) > CELL_PX * scale * 1.5) continue;
    const cluster = { mx: cell.mx, my: cell.my, count, ...worst(cell.robots), px: count < 10 ? 30 : count < 100 ? 36 : 44, ids: cell.robots.map((robot) => robot.id) };
    list.push(cluster);
    for (const robot of cell.robots) of.set(robot.id, cluster);
  }
  return { of, list };
}

/** How far the robots of a cell are apart on the screen; machines that are drawn larger than a cell are never gathered. */
function spreadPx(robots, camera) {
  const bodies = Math.max(...robots.slice(0, 8).map((robot) => robot.lengthM)) / camera.metresPerPx;
  return bodies > 20 ? Infinity : 0;
}

function worst(robots) {
  let level = null;
  let isAsking = false;
  for (const robot of robots) {
    const own = robot.level || (robot.stop ? 3 : robot.isStale ? 2 : null);
    if (own && (!level || own < level)) [level, isAsking] = [own, Boolean(robot.isAsking)];
    else if (own && own === level) isAsking ||= Boolean(robot.isAsking);
  }
  return { level, isAsking };
}
