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

// How far off a belief is at a time; its heading error may pass half a turn between two samples.
export function errorAt(belief, at) {
  const [k, part] = at, before = belief.heading_error[k];
  const heading = wrapped(before + wrapped(belief.heading_error[k + 1] - before) * part);
  return {position: between(belief.position_error, at), heading};
}

// An angle on the circle, in (-pi, pi].
export function wrapped(angle) {
  const turned = angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
  return turned <= -Math.PI ? turned + 2 * Math.PI : turned;
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
