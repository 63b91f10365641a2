// What kinematics says of two wheels that turn at constant rates: the drive as a replay, and its end in words.

import {integrate, methods} from '#web/odometry.mjs';
import {degrees, quantity} from '#web/quantities.mjs';
import {wrapped} from '#web/replay.mjs';

export const SECONDS = 10;
const FINE = 400;  // samples that are drawn
const ROUNDING = 1e-9;  // [m], [rad]

const robotOf = (left, right, track) => ({
  left_radius: left / 1000, right_radius: right / 1000, track_width: track / 1000,
  // As the package scales what a robot leaves out.
  tyre_width: 0.04 * (left + right) / 191, caster_x: -track / 2000, caster_radius: 0.025 * (left + right) / 191,
});

export const trueRobot = s => robotOf(s.left, s.right, s.track);
export const believedRobot = s => robotOf(s.believed_left, s.believed_right, s.believed_track);

// The wheel angles [left, right] at the samples of a rate [Hz].
export function wheelAngles({k, rate}, hz) {
  return Array.from({length: SECONDS * hz + 1}, (_, i) => [k * rate * i / hz, rate * i / hz]);
}

// The drive: the truth on its arc, and what the odometry believes at its rate; between two updates it is shown what an
// update there would make it believe.
export function drive(settings) {
  const {hz, method, k: ratio, rate} = settings, robot = trueRobot(settings), believed = believedRobot(settings);
  const updates = integrate(wheelAngles(settings, hz), believed, [0, 0, 0], methods[method]);
  const parts = Math.max(1, Math.ceil(FINE / (SECONDS * hz)));
  const t = Array.from({length: SECONDS * hz * parts + 1}, (_, i) => i / (hz * parts));
  const truth = integrate(wheelAngles(settings, hz * parts), robot);
  const belief = t.map((_, i) => {
    const turned = rate * (i % parts) / (hz * parts), last = updates[Math.floor(i / parts)];
    return i % parts ? methods[method](last, [ratio * turned, turned], believed) : last;
  });
  const off = belief.map((pose, i) => [Math.hypot(pose[0] - truth[i][0], pose[1] - truth[i][1]), wrapped(pose[2] - truth[i][2])]);
  return {
    title: 'k by hand', t, truth: columns(truth), robot,
    beliefs: [{
      name: 'odometry', ...columns(belief), robot: believed,
      position_error: off.map(([position]) => position), heading_error: off.map(([, heading]) => heading),
    }],
  };
}

const columns = poses => ({x: poses.map(p => p[0]), y: poses.map(p => p[1]), theta: poses.map(p => p[2])});

// What comes of it, in words.
export function inWords(settings) {
  const {truth, beliefs: [belief]} = drive(settings), robot = trueRobot(settings);
  return [
    `${path(settings, robot)} After ${SECONDS} s it is ${place(truth.x.at(-1), truth.y.at(-1))}.`,
    error(belief.position_error.at(-1), belief.heading_error.at(-1)),
  ];
}

function path({k, rate}, {left_radius, right_radius, track_width}) {
  const left = left_radius * k * rate, right = right_radius * rate, turn = (right - left) / track_width;
  if (Math.abs(turn) < ROUNDING) return 'The robot drives straight: r_r = k r_l.';
  const radius = (left + right) / 2 / turn;
  return `The robot drives a circle of radius ${quantity(Math.abs(radius), 'm')} about a point on its ${radius > 0 ? 'left' : 'right'}.`;
}

// Where that is, seen from the start; less than rounding is not worth its words.
function place(x, y) {
  const along = [[x, 'ahead of', 'behind'], [y, 'to the left of', 'to the right of']]
    .filter(([value]) => Math.abs(value) > ROUNDING)
    .map(([value, more, less]) => `${quantity(Math.abs(value), 'm')} ${value > 0 ? more : less}`);
  return along.length ? `${along.join(' and ')} its start` : 'back at its start';
}

function error(position, heading) {
  if (position < ROUNDING && Math.abs(heading) < ROUNDING) return 'Its odometry is right, to rounding.';
  return `Its odometry is ${quantity(position, 'm')} off, and its heading off by ${degrees(heading)}.`;
}
