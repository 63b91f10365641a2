// Tests an odometry on the drives of `diffdrive suite`: node suite.js cases/*.csv
'use strict';
const { readFileSync } = require('node:fs');

class Odometry {
  constructor(header) {
    const tick = header.unit === 'ticks' ? (2 * Math.PI) / header.ticks_per_revolution : 1;
    this.leftRadius = tick * header.left_radius; // metres for each unit of the readings
    this.rightRadius = tick * header.right_radius;
    this.track = header.track_width;
    this.range = header.counter_bits ? 2 ** header.counter_bits : 0;
    [this.x, this.y, this.theta] = [header.x, header.y, header.theta];
    this.last = null;
  }

  update(t, left, right) {
    if (![t, left, right].every(Number.isFinite) || (this.last && t <= this.last.t)) return; // holds the pose
    if (this.last) {
      const dLeft = this.leftRadius * this.step(left - this.last.left);
      const dRight = this.rightRadius * this.step(right - this.last.right);
      const half = (dRight - dLeft) / this.track / 2;
      const chord = ((dLeft + dRight) / 2) * (half === 0 ? 1 : Math.sin(half) / half);
      this.x += chord * Math.cos(this.theta + half);
      this.y += chord * Math.sin(this.theta + half);
      this.theta += 2 * half;
    }
    this.last = { t, left, right };
  }

  step(ticks) {
    return this.range ? ticks - this.range * Math.floor(ticks / this.range + 0.5) : ticks;
  }
}

const wrapped = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));

function passes(path) {
  const [first, , ...rows] = readFileSync(path, 'utf8').trimEnd().split('\n');
  const pairs = first.split(' ').slice(3).map((pair) => pair.split('='));
  const header = Object.fromEntries(pairs.map(([name, value]) => [name, name === 'unit' ? value : Number(value)]));
  const odometry = new Odometry(header);
  let worst = 0;
  for (const row of rows) {
    const [t, left, right, x, y, theta] = row.split(',').map(Number);
    odometry.update(t, left, right);
    const turn = (wrapped(odometry.theta - theta) * header.track_width) / 2;
    worst = Math.max(worst, Math.hypot(odometry.x - x, odometry.y - y, turn)); // NaN stays
  }
  const ok = worst <= header.tolerance;
  const off = `off by ${worst.toExponential(1)} m, at most ${header.tolerance.toExponential(1)} m`;
  console.log(`${ok ? 'ok  ' : 'FAIL'} ${path}: ${off}`);
  return ok;
}

const failed = process.argv.slice(2).filter((path) => !passes(path));
process.exitCode = failed.length > 0 ? 1 : 0;
