// What the robot believes: its wheels read at the odometry's rate, in whole ticks, and put together on arcs.

import { step } from "../../report/web/odometry.mjs";

export class Belief {
  // The believed robot, encoders with some ticks a turn of the wheel (0 for encoders without), and the start pose.
  constructor(robot, ticks, start = [0, 0, 0]) {
    this.robot = robot;
    this.tick = ticks ? 2 * Math.PI / ticks : 0;
    this.angles = [0, 0];
    this.pose = start;
  }

  // The pose after a reading of the wheels at their true angles [left, right].
  read(angles) {
    const seen = angles.map((angle) => this.seen(angle));
    this.pose = step(this.pose, [seen[0] - this.angles[0], seen[1] - this.angles[1]], this.robot);
    this.angles = seen;
    return this.pose;
  }

  // An angle as the encoder shows it, to the nearest tick.
  seen(angle) {
    return this.tick ? Math.floor(angle / this.tick + 0.5) * this.tick : angle;
  }
}
