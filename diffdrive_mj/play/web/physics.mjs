// One drive in MuJoCo, step by step, as diffdrive_mj/physics does it in Python: the same model, the same commands, the
// same true pose. Nothing here knows of a page.

import { exactModel } from "./model.mjs";
import { Grip } from "./grip.mjs";

const WHEELS = ["left", "right"];

export class Physics {
  // A drive as diffdrive_mj/play/drives.py writes it; throws an Error if the model is not the one that Python compiled.
  constructor(mujoco, drive) {
    this.mujoco = mujoco;
    this.drive = drive;
    this.model = exactModel(mujoco, drive.model);
    this.data = new mujoco.MjData(this.model);
    this.data.qpos.set(this.model.qpos0);
    this.joints = WHEELS.map((side) => this.model.jnt(side).qposadr);
    this.grip = new Grip(this.model, this.data, drive);
    this.steps = 0;
    this.total = drive.rates.length / 2 * drive.steps_per_period;
    this.turns = 0;  // whole ones, to be added to the direction
    this.qpos = this.data.qpos;  // views of the engine's memory, which a step does not move
    this.ctrl = this.data.ctrl;
    this.direction = direction(this.qpos);
    this.engine = [this.qpos[0], this.qpos[1]];
    this.position = [0, 0];
  }

  get time() { return this.steps * this.drive.timestep; }
  get done() { return this.steps >= this.total || this.grip.fall !== null; }

  // The true pose [x, y, theta].
  get pose() { return [this.position[0], this.position[1], this.direction + 2 * Math.PI * this.turns]; }

  // The wheel angles [left, right].
  get angles() { return this.joints.map((address) => this.qpos[address]); }

  step() {
    const period = Math.floor(this.steps / this.drive.steps_per_period);
    const { rates } = this.drive, { ctrl, qpos } = this;
    ctrl[0] = ctrl[2] = rates[2 * period];  // the servos' proportional and integral parts
    ctrl[1] = ctrl[3] = rates[2 * period + 1];
    this.mujoco.mj_step(this.model, this.data);
    this.steps += 1;
    if (!Number.isFinite(qpos[0] + qpos[2] + qpos[3])) throw new Error(`the physics broke down at ${this.time} s`);
    this.follow();
    this.grip.read(this.time);
  }

  // The true pose after a step: its displacement is turned into the mean of the headings before and after it.
  follow() {
    const { qpos, engine, position } = this;
    const after = direction(qpos);
    let turn = after - this.direction;
    const wraps = Math.round(turn / (2 * Math.PI));
    turn -= 2 * Math.PI * wraps;
    this.turns -= wraps;
    this.direction = after;
    const ahead = this.drive.turned_on * turn, cos = Math.cos(ahead), sin = Math.sin(ahead);
    const dx = qpos[0] - engine[0], dy = qpos[1] - engine[1];
    position[0] += cos * dx - sin * dy;
    position[1] += sin * dx + cos * dy;
    engine[0] = qpos[0];
    engine[1] = qpos[1];
  }

  // The engine's memory is not taken back by itself.
  free() {
    this.data.delete();
    this.model.delete();
  }
}

// The direction of the body's x axis on the floor, of positions that begin with a free joint's.
function direction(qpos) {
  const w = qpos[3], x = qpos[4], y = qpos[5], z = qpos[6];
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}
