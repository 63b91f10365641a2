// What a drive has shown, in words.

import { KNOBS } from "./knobs.mjs";
import { wrapped } from "./record.mjs";

const SIZES = ["left_radius", "right_radius", "track_width"];
const COARSE_TICKS = 1000, SLOW = 20;  // below these the encoder and the rate are worth a word

// A number with some digits, a real minus, and no zero below zero.
export function fixed(value, digits) {
  return value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−");
}

// A length with the unit in which it reads well.
export function length(metres) {
  const size = Math.abs(metres);
  if (size >= 1) return `${metres.toFixed(2)} m`;
  if (size >= 0.001) return `${digits(1000 * metres, 3)} mm`;
  return size >= 1e-7 ? `${digits(1e6 * metres, 2)} µm` : "0 mm";
}

// A number with some digits, and never a power of ten behind it.
function digits(value, count) {
  const text = value.toPrecision(count);
  return text.includes("e+") ? value.toFixed(0) : text;
}

function angle(radians) {
  const degrees = Math.abs(radians) * 180 / Math.PI;
  return degrees >= 0.05 ? `${degrees.toFixed(1)}°` : "";
}

// One sentence or two: how far off the belief is at a row of the record.
export function words(row) {
  const { t, driven, position } = row, heading = wrapped(row.heading);
  const when = `After ${t.toFixed(1)} s and ${driven.toFixed(2)} m`;
  if (position < 1e-4 && Math.abs(heading) < 1e-3) {
    return `${when} the ghost is where the robot is, within ${length(Math.max(position, 1e-6))}.`;
  }
  const share = driven > 0.1 ? ` (${percent(position / driven)} of the way)` : "";
  const side = heading > 0 ? "left" : "right", turned = angle(heading);
  const facing = turned ? `, and it believes that it faces ${turned} further to the ${side}` : "";
  return `${when} the robot is ${length(position)}${share} from where it believes it is${facing}.`;
}

function percent(share) {
  return share < 1e-4 ? "less than 0.01 %" : `${digits(100 * share, share < 0.1 ? 2 : 3)} %`;
}

// Why: what the robot believes wrongly, and what its odometry cannot see.
export function reasons({ planned, grip }) {
  const { setting } = planned, found = [];
  for (const name of SIZES) {
    const [believed, truth] = [setting[`believed_${name}`], setting[name]];
    const off = believed / truth - 1;
    if (Math.abs(off) > 1e-9) {
      const far = Math.abs(off) < 1e-4 ? "slightly" : percent(Math.abs(off));
      const larger = off > 0 ? "larger" : "smaller";
      found.push(`It takes its ${KNOBS[name].label.toLowerCase()} to be ${far} ${larger} than it is.`);
    }
  }
  const slipping = ["left", "right"].filter((_, side) => grip.slip[side] !== null);
  if (slipping.length) {
    const first = Math.min(...grip.slip.filter((time) => time !== null));
    const since = first < 0.1 ? "from the start" : `first at ${first.toFixed(1)} s`;
    const who = slipping.length > 1 ? "Both wheels slip" : `The ${slipping[0]} wheel slips`;
    found.push(`${who}, ${since}: odometry counts turns of the wheels, and does not see the floor.`);
  }
  if (grip.lift !== null) {
    found.push(`A wheel or the caster is off the floor, first at ${grip.lift.toFixed(1)} s.`);
  }
  if (grip.fall !== null) found.push(`The robot falls at ${grip.fall.toFixed(1)} s: drive more gently.`);
  if (setting.ticks && setting.ticks < COARSE_TICKS) {
    found.push(`Its encoders see ${setting.ticks} steps a turn, and nothing in between.`);
  }
  if (setting.rate < SLOW) {
    const often = setting.rate === 1 ? "once" : `${setting.rate} times`;
    found.push(`It reads its wheels ${often} a second, and takes each piece for an arc.`);
  }
  if (!found.length) found.push("It believes what is true of its wheels, and they roll: odometry works.");
  return found;
}
