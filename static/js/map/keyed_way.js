// Where a key moves the view: {zoom: steps} or {mx, my}; null for any other key.

const STEP_PX = 80;
const ZOOMS = { '+': 1, '=': 1, '-': -1 };
const STEPS = { ArrowLeft: [-STEP_PX, 0], ArrowRight: [STEP_PX, 0], ArrowUp: [0, -STEP_PX], ArrowDown: [0, STEP_PX] };

export function keyedWay(event, camera) {
  if (event.key in ZOOMS) return { zoom: ZOOMS[event.key] };
  const step = STEPS[event.key];
  if (!step || !event.shiftKey) return null; // plain arrows drive the robot
  const [mx, my] = camera.unproject(camera.width / 2 + step[0], camera.height / 2 + step[1]);
  return { mx, my };
}
