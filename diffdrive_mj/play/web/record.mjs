// What the physics has posted of a drive: where everything is at any time, and how far the belief is off.

import { FRAME, FRAMES_PER_SECOND, SAMPLE } from "./drive.mjs";

export class Record {
  // A drive as it was planned, and what `Drive.kept` has of it.
  constructor(planned, { frames, samples, grip }) {
    this.planned = planned;
    this.grip = grip;
    this.duration = planned.rates.length / 2 * planned.steps_per_period * planned.timestep;
    this.frames = rows(frames, FRAME.length);
    // A row an odometry sample: { t, position [m], heading [rad, not wrapped], driven [m], truth, belief }.
    this.errors = [];
    for (const row of rows(samples, SAMPLE.length)) this.errors.push(this.off(row));
  }

  off([t, x, y, theta, , , gx, gy, gtheta]) {
    const last = this.errors.at(-1);
    const step = last ? arc(x - last.truth[0], y - last.truth[1], theta - last.truth[2]) : 0;
    return {
      t, truth: [x, y, theta], belief: [gx, gy, gtheta],
      position: Math.hypot(gx - x, gy - y),
      heading: gtheta - theta,
      driven: (last?.driven ?? 0) + step,
    };
  }

  // How far the drive has come: its duration, unless the robot fell [s].
  get end() { return this.frames.at(-1)[0]; }

  // Where everything is at a time, between two frames: { truth, believed, wheels }.
  at(time) {
    const { frames } = this, last = frames.length - 1;
    const k = Math.min(Math.max(Math.floor(time * FRAMES_PER_SECOND), 0), last), next = Math.min(k + 1, last);
    const [a, b] = [frames[k], frames[next]];
    const part = b[0] > a[0] ? Math.min(Math.max((time - a[0]) / (b[0] - a[0]), 0), 1) : 0;
    const mix = (i) => a[i] + (b[i] - a[i]) * part;
    return {
      position: [mix(1), mix(2), mix(3)],
      quaternion: [mix(4), mix(5), mix(6), mix(7)],  // drawn only, and nearly of length 1
      wheels: { left: mix(8), right: mix(9) },
      believed: part < 1 ? [a[10], a[11], a[12]] : [b[10], b[11], b[12]],
    };
  }

  // The last odometry sample up to a time.
  known(time) {
    const every = 1 / this.planned.rate;
    return this.errors[Math.min(Math.floor(time / every + 1e-6), this.errors.length - 1)];
  }
}

function rows(numbers, width) {
  return Array.from({ length: numbers.length / width }, (_, k) => numbers.subarray(k * width, (k + 1) * width));
}

// The length of the arc through two poses, from the chord and the turn.
function arc(dx, dy, turn) {
  const half = turn / 2;
  return Math.hypot(dx, dy) * (Math.abs(Math.sin(half)) > 1e-9 ? half / Math.sin(half) : 1);
}

// An angle on the circle, in (-pi, pi].
export function wrapped(angle) {
  const turned = angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
  return turned === -Math.PI ? Math.PI : turned;
}
