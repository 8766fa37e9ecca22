// Outlines drawn by hand: thinned, and refused if they are none. Points are [x, y], metres.
(() => {
  "use strict";

  const area = (ring) => Math.abs(ring.reduce((sum, [x, y], k) => { const [u, v] = ring[(k + 1) % ring.length]; return sum + x * v - u * y; }, 0) / 2);

  function off([x, y], [ax, ay], [bx, by]) {
    const [dx, dy] = [bx - ax, by - ay];
    const long = dx * dx + dy * dy;
    const t = long ? Math.max(0, Math.min(1, ((x - ax) * dx + (y - ay) * dy) / long)) : 0;
    return Math.hypot(x - ax - t * dx, y - ay - t * dy);
  }

  // leaves out points nearer than `least` metres to the line of their neighbours
  function thinned(points, least) {
    if (points.length < 3) return points;
    let [worst, at] = [0, 0];
    for (let k = 1; k < points.length - 1; k += 1) {
      const d = off(points[k], points[0], points.at(-1));
      if (d > worst) [worst, at] = [d, k];
    }
    if (worst <= least) return [points[0], points.at(-1)];
    return [...thinned(points.slice(0, at + 1), least).slice(0, -1), ...thinned(points.slice(at), least)];
  }

  const side = ([ax, ay], [bx, by], [cx, cy]) => Math.sign((bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
  const cross = (a, b, c, d) => side(a, b, c) !== side(a, b, d) && side(c, d, a) !== side(c, d, b);

  function isCrossed(ring) {
    const n = ring.length;
    for (let i = 0; i < n; i += 1) {
      for (let j = i + 2; j < n; j += 1) {
        if (i === 0 && j === n - 1) continue; // neighbours over the end
        if (cross(ring[i], ring[i + 1], ring[j], ring[(j + 1) % n])) return true;
      }
    }
    return false;
  }

  // a finger's line as a ring: its beginning may overshoot its end
  function closed(points, least) {
    const ring = thinned(points, least);
    const last = ring.at(-1);
    if (ring.length > 3 && Math.hypot(last[0] - ring[0][0], last[1] - ring[0][1]) < 2 * least) ring.pop();
    return ring;
  }

  // what is wrong with a ring, in words; "" if nothing
  function problem(ring, leastArea) {
    if (ring.length < 3) return "An area needs three corners.";
    if (isCrossed(ring)) return "The line crosses itself. Draw it again.";
    return area(ring) < leastArea ? "Too small. Draw around it, or zoom in." : "";
  }

  HL.areaShape = { thinned, closed, problem, area };
})();
