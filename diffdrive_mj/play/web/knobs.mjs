// What is on the page for each number of a setting: its name, unit, help where it needs any, and how far its slider
// reaches.

const RADIUS = { unit: "mm", scale: 1000, around: 0.2 };

export const GROUPS = [
  { title: "Drive", names: ["k", "right_rate", "speed", "seconds"] },
  { title: "True robot", names: ["left_radius", "right_radius", "track_width"] },
  {
    title: "What it believes", ghost: true,
    names: ["believed_left_radius", "believed_right_radius", "believed_track_width"],
  },
  { title: "Encoders and floor", names: ["ticks", "rate", "friction"] },
];

// `around`: the slider reaches this part below and above the robot's own number; `steps`: it has these alone.
export const KNOBS = {
  k: {
    label: "k, left / right", help: "rate of the left wheel / rate of the right wheel",
    unit: "", low: 0.8, high: 1.2, step: 0.005,
  },
  right_rate: {
    label: "Right rate", help: "rate of the right wheel",
    unit: "rad/s", low: 2, high: 25, step: 0.5,
  },
  speed: {
    label: "Speed", help: "of the axle's middle; on the spot that of the wheels' rims",
    unit: "m/s", low: 0.05, high: 2, step: 0.05,
  },
  seconds: { label: "Time", help: "at full speed", unit: "s", low: 2, high: 30, step: 1 },
  left_radius: { label: "Left radius", ...RADIUS },
  right_radius: { label: "Right radius", ...RADIUS },
  track_width: { label: "Track width", ...RADIUS },
  believed_left_radius: { label: "Left radius", ...RADIUS },
  believed_right_radius: { label: "Right radius", ...RADIUS },
  believed_track_width: { label: "Track width", ...RADIUS },
  ticks: {
    label: "Ticks a turn", help: "of the encoders; 0 for ideal ones",
    unit: "", steps: [0, 12, 24, 60, 100, 360, 1000, 4096],
  },
  rate: {
    label: "Read at", help: "how often odometry reads the wheels",
    unit: "Hz", steps: [1, 2, 5, 10, 20, 50, 100, 250, 500],
  },
  friction: {
    label: "Friction", help: "coefficient of the floor under the wheels",
    unit: "", low: 0.05, high: 1.2, step: 0.05,
  },
};

export const MANEUVERS = {
  k: "rates, left = k right",
  straight: "straight line",
  circle: "circle",
  square: "square",
  figure_eight: "figure eight",
  slalom: "slalom",
  spin: "spin on the spot",
};

// Which numbers a maneuver does not read.
export function idle(maneuver) {
  return maneuver === "k" ? ["speed"] : ["k", "right_rate"];
}

// The slider of a knob: { min, max, step } in the unit that is shown; around the robot's own number where it has one.
export function reach(name, own) {
  const { low, high, step, around, scale = 1, steps } = KNOBS[name];
  if (steps) return { min: 0, max: steps.length - 1, step: 1 };
  if (!around) return { min: low, max: high, step };
  const middle = own * scale, fine = 10 ** Math.floor(Math.log10(middle / 500));
  const snap = (x) => Number((Math.round(x / fine) * fine).toFixed(6));
  return { min: snap(middle * (1 - around)), max: snap(middle * (1 + around)), step: Number(fine.toFixed(6)) };
}

// The step of a list that is nearest to a number, in its ratio.
export function nearest(steps, value) {
  const far = (step) => Math.abs(Math.log((step + 1) / (Math.max(value, 0) + 1)));
  return steps.reduce((best, step, k) => (far(step) < far(steps[best]) ? k : best), 0);
}
