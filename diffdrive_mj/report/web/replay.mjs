// A drive over time: where the robot was, what was believed, and how far off that is; between samples all of it is
// interpolated.

// As the page holds it: poses as lists {x, y, theta}, and with each belief its errors [m] and [rad].
export const parse = text => JSON.parse(text);

// Where a time lies: the sample before it, and which part of the way to the next.
export function locate(times, t) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  const part = (t - times[low]) / (times[high] - times[low]);
  return [low, Math.min(Math.max(part, 0), 1)];
}

const between = (values, [k, part]) => values[k] + (values[k + 1] - values[k]) * part;

export const poseAt = (path, at) => [between(path.x, at), between(path.y, at), between(path.theta, at)];

// How far off a belief is at a time.
export function errorAt(belief, at) {
  return {position: between(belief.position_error, at), heading: between(belief.heading_error, at)};
}

// The box [[x, x], [y, y]] that all paths of a drive fill.
export function extent({truth, beliefs}) {
  const range = axis => {
    const all = [truth, ...beliefs].map(path => path[axis]);
    return [Math.min(...all.map(values => Math.min(...values))), Math.max(...all.map(values => Math.max(...values)))];
  };
  return [range('x'), range('y')];
}

export const largest = values => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
