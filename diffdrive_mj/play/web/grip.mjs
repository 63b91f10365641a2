// How the robot holds on to the floor, as diffdrive_mj/physics/_probes.py reads it: the share of its friction that each
// wheel uses, contacts that leave the floor, falls.

const CONTACTS = ["left_contact", "right_contact", "caster_contact"];
const LARGEST_USE = 0.95;  // above it a wheel is said to slip
const LARGEST_TILT = Math.PI / 6, HIGHEST = 5;  // [rad], [m]

export class Grip {
  constructor(model, data, drive) {
    [this.left, this.right, this.caster] = CONTACTS.map((name) => model.sensor(name).adr);
    this.chassis = model.sensor("chassis_contact").adr;
    this.forces = data.sensordata;
    this.qpos = data.qpos;
    this.friction = drive.friction;
    this.up = vertical(this.qpos);
    this.height = this.qpos[2];
    this.before = null;
    this.use = [0, 0];  // the largest shares, left and right
    this.slipTime = [null, null];  // when each wheel first slipped [s]
    this.lift = null;  // when a contact first left the floor [s]
    this.fall = null;  // when the robot fell [s]
  }

  // The forces of a step that has ended at a time [s].
  read(time) {
    const { forces, friction } = this;
    const now = [this.left, this.right].map((k) => [Math.hypot(forces[k + 1], forces[k + 2]), forces[k] * friction]);
    for (const [side, [pull, hold]] of now.entries()) {
      const [earlier, held] = (this.before ?? now)[side];
      const use = hold + held > 0 ? (pull + earlier) / (hold + held) : 0;
      if (use > this.use[side]) this.use[side] = use;
      if (use > LARGEST_USE) this.slipTime[side] ??= time;
    }
    this.before = now;
    if ([this.left, this.right, this.caster].some((k) => forces[k] <= 0)) this.lift ??= time;
    const up = vertical(this.qpos), cosine = up[0] * this.up[0] + up[1] * this.up[1] + up[2] * this.up[2];
    if (forces[this.chassis] > 0 || cosine < Math.cos(LARGEST_TILT) || this.qpos[2] > this.height + HIGHEST) {
      this.fall ??= time;
    }
  }

  // What of it is worth saying, as plain data.
  get said() {
    const { use, slipTime, lift, fall } = this;
    return { use, slip: slipTime, lift, fall };
  }
}

// The world's vertical in the body's axes.
function vertical(qpos) {
  const w = qpos[3], x = qpos[4], y = qpos[5], z = qpos[6];
  return [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
}
