// A whole drive: stepped, read by the odometry at its rate, and kept for drawing.

import { Belief } from "./belief.mjs";
import { Physics } from "./physics.mjs";

// What a row of `frames` and of `samples` holds, in this order.
export const FRAME = ["t", "x", "y", "z", "qw", "qx", "qy", "qz", "left", "right", "gx", "gy", "gtheta"];
export const SAMPLE = ["t", "x", "y", "theta", "left", "right", "gx", "gy", "gtheta"];
export const FRAMES_PER_SECOND = 100;

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

  // Step until the drive ends. Returns how many times faster than real time that was.
  run() {
    const { physics } = this, begin = performance.now();
    while (!physics.done) {
      physics.step();
      if (physics.steps % this.stepsPerSample === 0) this.sample();
      if (physics.steps % this.stepsPerFrame === 0 || physics.done) this.frame();
    }
    return physics.time / ((performance.now() - begin) / 1000);
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

  // Everything there is to show, and how the robot held on.
  get kept() {
    const { frames, samples, physics } = this;
    return { frames: new Float64Array(frames), samples: new Float64Array(samples), grip: physics.grip.said };
  }

  free() { this.physics.free(); }
}
