// A robot as seen from above: corners in its own axes [m], x forward and y left, as report/marks.py draws it.

export function outline({left_radius, right_radius, track_width, tyre_width, caster_x, caster_radius}) {
  const half = track_width / 2, front = 0.6 * (left_radius + right_radius) / 2;
  const inner = Math.max(half - tyre_width, 0.3 * half), back = caster_x + Math.sign(caster_x) * caster_radius;
  const wheel = (side, radius) => [[-radius, -1], [radius, -1], [radius, 1], [-radius, 1]]
    .map(([x, rim]) => [x, side * half + rim * tyre_width / 2]);
  return {
    body: [[front, inner], [back, 0.6 * inner], [back, -0.6 * inner], [front, -inner], [1.8 * front, 0]],
    wheels: [wheel(1, left_radius), wheel(-1, right_radius)],
  };
}

// How many times larger than it is a robot must be drawn to be seen at a scale [pixels/m].
export const enlarged = (robot, scale, pixels = 30) => Math.max(1, pixels / (robot.track_width * scale));

// Corners at a pose, turned and moved to where the robot is.
export function placed(corners, [x, y, theta], size = 1) {
  const c = size * Math.cos(theta), s = size * Math.sin(theta);
  return corners.map(([a, b]) => [x + c * a - s * b, y + s * a + c * b]);
}
