// Odometry of a differential drive, as in diffdrive_mj/odometry.py: SI units, radians, left before right.

// The pose [x, y, theta] after the wheels have turned by two angles [rad]: a chord along the mean heading.
//
//   alpha = (r_r phi_r - r_l phi_l) / track_width
//   chord = (r_l phi_l + r_r phi_r) / 2 * sin(alpha / 2) / (alpha / 2)
export function step([x, y, theta], [left, right], robot) {
  const dl = robot.left_radius * left, dr = robot.right_radius * right;
  const half = (dr - dl) / (2 * robot.track_width);
  const chord = (dl + dr) / 2 * (half === 0 ? 1 : Math.sin(half) / half);
  return [x + chord * Math.cos(theta + half), y + chord * Math.sin(theta + half), theta + 2 * half];
}

// The chord taken for the arc, along the heading at its start (Euler) or the mean heading (midpoint).
const straight = share => ([x, y, theta], [left, right], robot) => {
  const dl = robot.left_radius * left, dr = robot.right_radius * right;
  const turn = (dr - dl) / robot.track_width, along = theta + share * turn;
  return [x + (dl + dr) / 2 * Math.cos(along), y + (dl + dr) / 2 * Math.sin(along), theta + turn];
};

// By the names that diffdrive_mj.odometry.METHODS has.
export const methods = {euler: straight(0), midpoint: straight(0.5), arc: step};

// The poses of a list of wheel angles [[left, right], ...], the first of which is at the start pose.
export function integrate(wheelAngles, robot, start = [0, 0, 0], method = step) {
  const poses = [start];
  for (let k = 1; k < wheelAngles.length; k++) {
    const [before, after] = [wheelAngles[k - 1], wheelAngles[k]];
    poses.push(method(poses[k - 1], [after[0] - before[0], after[1] - before[1]], robot));
  }
  return poses;
}
