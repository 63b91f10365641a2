// A whole drive: stepped, read by the odometry at its rate, and kept for drawing.

import { Belief } from "./belief.mjs";
import { Physics } from "./physics.mjs";

// What a row of `frames` and of `samples` holds, in this order.
export const FRAME = ["t", "x", "y", "z", "qw", "qx", "qy", "qz", "left", "right", "gx", "gy", "gtheta"];
export const SAMPLE = ["t", "x", "y", "theta", "left", "right", "gx", "gy", "gtheta"];
const FRAMES_PER_SECOND = 100;

export class Drive {
  constructor(mujoco, drive) {
    this.physics = new Physics(mujoco, drive);
    this.belief = new Belief(drive.believed, drive.ticks);
    this.stepsPerSample = Math.round(1 / (drive.rate * drive.timestep));
    this.stepsPerFrame = Math.round(1 / (FRAMES_PER_SECOND * drive.timestep));
    this.samples = [];
    this.frames = [];
    this.sample();
    this.frame();
  }

  get done() { return this.physics.done; }

  // Step until the drive ends, or for some time [ms].
  advance(milliseconds = Infinity) {
    const { physics } = this, end = performance.now() + milliseconds;
    while (!physics.done) {
      physics.step();
      if (physics.steps % this.stepsPerSample === 0) this.sample();
      if (physics.steps % this.stepsPerFrame === 0 || physics.done) this.frame();
      if (physics.steps % 50 === 0 && performance.now() > end) break;
    }
  }

  sample() {
    const { physics, belief } = this, angles = physics.angles;
    this.samples.push(physics.time, ...physics.pose, ...angles, ...belief.read(angles));
  }

  frame() {
    const { physics, belief } = this, { qpos } = physics, [x, y] = physics.pose;
    this.frames.push(
      physics.time, x, y, qpos[2], qpos[3], qpos[4], qpos[5], qpos[6], ...physics.angles, ...belief.pose,
    );
  }

  // What has been kept since the last call, and how the robot holds on.
  taken() {
    const part = { frames: new Float64Array(this.frames), samples: new Float64Array(this.samples) };
    this.frames = [];
    this.samples = [];
    return { ...part, grip: this.physics.grip.said, done: this.done };
  }

  free() { this.physics.free(); }
}
