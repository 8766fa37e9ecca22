// A planned path to draw and to travel along: where the robot is after so many seconds, and which way it looks.
(() => {
  "use strict";
  const TURN_S = 0.25; // half the turn on the spot is over by then at the latest; only the picture uses it
  const TURN_WEIGHT = 3; // a metre between rows is watched as long as so many metres of row

  // points of a leg: flat x, y in metres, y to the north
  const pointsOf = (leg) => Array.from({ length: leg.xy.length / 2 }, (_, k) => [leg.xy[2 * k], leg.xy[2 * k + 1]]);
  const angle = ([ax, ay], [bx, by]) => Math.atan2(by - ay, bx - ax);
  // how the robot looks from a to b: where it backs, against the line
  const facing = (leg, a, b) => angle(a, b) + (leg.back ? Math.PI : 0);
  const shortest = (rad) => Math.atan2(Math.sin(rad), Math.cos(rad));

  // the value in column `to` where column `from` of rising marks has reached `value`
  function along(marks, value, from, to) {
    const k = marks.findIndex((mark) => mark[from] >= value);
    if (k < 0) return marks.at(-1)[to];
    if (k === 0) return marks[0][to];
    const [a, b] = [marks[k - 1], marks[k]];
    return a[to] + ((value - a[from]) / (b[from] - a[from] || 1)) * (b[to] - a[to]);
  }

  class Path {
    constructor(drawing) {
      this.legs = drawing.legs.map((leg) => {
        const points = pointsOf(leg);
        const along = [0];
        for (let k = 1; k < points.length; k += 1) along.push(along[k - 1] + Math.hypot(points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1]));
        return { ...leg, points, along, length: along.at(-1) };
      });
      this.before = [];
      let sum = 0;
      for (const leg of this.legs) {
        this.before.push(sum);
        sum += leg.length;
      }
      this.length = sum;
      this.duration = this.legs.at(-1)?.t[1] ?? 0;
      this.rows = this.legs.reduce((most, leg) => Math.max(most, leg.row), 0);
      this.marks = this.watched();
    }

    // [seconds, share of the watching] where legs begin and end. Half of it goes by time and half by the way: a machine
    // that stands an hour in each row would turn too fast to be seen, one that flies through would be all turns.
    watched() {
      const weight = (leg) => leg.length * (leg.row ? 1 : TURN_WEIGHT);
      const way = this.legs.reduce((sum, leg) => sum + weight(leg), 0);
      const share = (t, gone) => (t / (this.duration || 1) + gone / (way || 1)) / 2;
      const marks = [[0, 0]];
      let gone = 0;
      for (const leg of this.legs) {
        marks.push([leg.t[0], share(leg.t[0], gone)]);
        gone += weight(leg);
        marks.push([leg.t[1], share(leg.t[1], gone)]);
      }
      return marks;
    }

    // how far a slider stands after t seconds, 0 to 1; and back
    shareAt(t) {
      return along(this.marks, t, 0, 1);
    }
    timeAt(share) {
      return along(this.marks, share, 1, 0);
    }

    // number of the leg under way at t seconds, or turned toward
    legAt(t) {
      let low = 0;
      let high = this.legs.length - 1;
      while (low < high) {
        const middle = (low + high) >> 1;
        if (this.legs[middle].t[1] < t) low = middle + 1;
        else high = middle;
      }
      return low;
    }

    // {x, y, heading, row, isOn, isBack, driven}: heading in radians, 0 east; row is 0 before the first
    at(t) {
      const number = this.legAt(t);
      const leg = this.legs[number];
      const share = Math.min(1, Math.max(0, (t - leg.t[0]) / Math.max(0.01, leg.t[1] - leg.t[0])));
      const s = share * leg.length;
      let k = 1;
      while (k < leg.along.length - 1 && leg.along[k] < s) k += 1;
      const [a, b] = [leg.points[k - 1], leg.points[k]];
      const part = (s - leg.along[k - 1]) / Math.max(1e-6, leg.along[k] - leg.along[k - 1]);
      return {
        x: a[0] + part * (b[0] - a[0]), y: a[1] + part * (b[1] - a[1]), heading: this.heading(number, t, facing(leg, a, b)),
        row: this.rowAt(number), isOn: leg.on && t >= leg.t[0], isBack: Boolean(leg.back) && t >= leg.t[0], driven: this.before[number] + s,
      };
    }

    // while it turns on the spot, from the direction it came to the one it takes
    heading(number, t, ahead) {
      const leg = this.legs[number];
      if (t >= leg.t[0] || number === 0) return ahead;
      const came = this.legs[number - 1];
      const from = facing(came, came.points.at(-2), came.points.at(-1));
      const share = Math.min(1, Math.max(0, (t - came.t[1]) / Math.max(TURN_S, leg.t[0] - came.t[1])));
      return from + share * shortest(ahead - from);
    }

    rowAt(number) {
      for (let k = number; k >= 0; k -= 1) if (this.legs[k].row) return this.legs[k].row;
      return 0;
    }
  }

  HL.planner.Path = Path;
})();
