// The page's modules that need no browser, against what they must give in closed form. Run by node's own test runner.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Belief } from "../../diffdrive_mj/play/web/belief.mjs";
import { KNOBS, nearest, reach } from "../../diffdrive_mj/play/web/knobs.mjs";
import { Record, wrapped } from "../../diffdrive_mj/play/web/record.mjs";
import { compensated, enlightened, fromHash, toHash } from "../../diffdrive_mj/play/web/settings.mjs";
import { fixed, length, reasons, words } from "../../diffdrive_mj/play/web/words.mjs";

const OPENING = { robot: "matched", maneuver: "k", k: 0.91, left_radius: 0.1, right_radius: 0.1, track_width: 0.4,
  believed_left_radius: 0.1, believed_right_radius: 0.091, believed_track_width: 0.4, ticks: 0, rate: 50, friction: 1 };
const OTHER = { ...OPENING, robot: "my robot & <others>", left_radius: 0.033 };
const OPENINGS = [OPENING, OTHER];

test("a setting survives its address, with every digit", () => {
  for (const k of [0.91, 1 / 3, 1e-7, 123456.789, 0.1 + 0.2, 5e-324]) {
    const setting = { ...OTHER, k };
    assert.deepEqual(fromHash(`#${toHash(setting)}`, OPENINGS), setting);
  }
});

test("what an address leaves out is that of its robot, or of the first", () => {
  assert.deepEqual(fromHash("", OPENINGS), OPENING);
  assert.deepEqual(fromHash("#k=0.8", OPENINGS), { ...OPENING, k: 0.8 });
  assert.equal(fromHash(`#robot=${encodeURIComponent(OTHER.robot)}`, OPENINGS).left_radius, 0.033);
});

test("what is no number, and what is no setting, is passed on to be refused", () => {
  const setting = fromHash("#k=banana&friction=&rate=Infinity&wheels=3&robot=nobody", OPENINGS);
  assert.deepEqual([setting.k, setting.friction, setting.rate, setting.wheels, setting.robot],
    ["banana", "", "Infinity", "3", "nobody"]);
});

test("fitted wheels have r_r = k r_l, and believing the truth copies it", () => {
  assert.equal(compensated({ ...OPENING, k: 0.88 }).right_radius, 0.088);
  assert.equal(compensated(OPENING).believed_right_radius, OPENING.believed_right_radius);
  const wise = enlightened({ ...OTHER, track_width: 0.3 });
  assert.deepEqual([wise.believed_left_radius, wise.believed_right_radius, wise.believed_track_width], [0.033, 0.1, 0.3]);
});

test("a quarter turn of a wheel on an arc, in whole ticks and without", () => {
  const robot = { left_radius: 0.1, right_radius: 0.1, track_width: 0.4 };
  const [x, y, theta] = new Belief(robot, 0).read([0, Math.PI]);  // the left wheel stands: a circle of 0.2 m about it
  const turn = 0.1 * Math.PI / 0.4;
  assert.ok(Math.abs(theta - turn) < 1e-15);
  assert.ok(Math.hypot(x - 0.2 * Math.sin(turn), y - 0.2 * (1 - Math.cos(turn))) < 1e-15);
  // Of 8 ticks a turn, each 45 degrees: 22 degrees are none, 23 are one.
  const degrees = Math.PI / 180, counted = new Belief(robot, 8);
  const seen = [22, 23, -22, -23].map((angle) => Math.round(counted.seen(angle * degrees) / degrees));
  assert.deepEqual(seen, [0, 45, 0, -45]);
  // Ticks do not add up: two readings of 22 degrees are one tick of 45.
  counted.read([22 * degrees, 22 * degrees]);
  assert.ok(Math.abs(counted.read([44 * degrees, 44 * degrees])[0] - 0.1 * 45 * degrees) < 1e-15);
});

// A drive of two seconds, straight at 1 m/s, believed to be 10 % longer.
function straight() {
  const setting = { ...OPENING, believed_right_radius: 0.1, rate: 10 };
  const frames = [], samples = [];
  for (let k = 0; k <= 200; k++) {
    const x = k / 100, seen = Math.floor(k / 10 + 1e-9) / 10;
    frames.push(k / 100, x, 0, 0.1, 1, 0, 0, 0, 10 * x, 10 * x, 1.1 * seen, 0, 0);
    if (k % 10 === 0) samples.push(k / 100, x, 0, 0, 10 * x, 10 * x, 1.1 * x, 0, 0);
  }
  const grip = { slip: [null, null], use: [0, 0], lift: null, fall: null };
  return new Record({ rates: new Array(400), steps_per_period: 5, timestep: 0.002, rate: 10, setting },
    { frames: new Float64Array(frames), samples: new Float64Array(samples), grip });
}

test("a record knows where everything is, and what was known then", () => {
  const record = straight();
  assert.equal(record.duration, 2);
  assert.ok(Math.abs(record.at(1.005).position[0] - 1.005) < 1e-12);  // between two frames
  assert.ok(Math.abs(record.at(1.095).believed[0] - 1.1) < 1e-12);  // the ghost waits for the next reading
  assert.equal(record.known(1.099).t, 1);
  assert.equal(record.known(1.1).t, 1.1);
  assert.equal(record.known(99).t, 2);
  assert.deepEqual(record.at(99).position.slice(0, 2), [2, 0]);
  const last = record.errors.at(-1);
  assert.ok(Math.abs(last.position - 0.2) < 1e-12 && Math.abs(last.driven - 2) < 1e-12);
});

test("the distance of a circle is that of its arcs, not of their chords", () => {
  const record = straight();
  record.errors = [];
  for (let k = 0; k <= 12; k++) {
    const a = 2 * Math.PI * k / 12;
    record.errors.push(record.off([k, Math.sin(a), 1 - Math.cos(a), a, 0, 0, 0, 0, 0]));
  }
  assert.ok(Math.abs(record.errors.at(-1).driven - 2 * Math.PI) < 1e-12);
});

test("words say how far off it is, and why", () => {
  const record = straight();
  assert.equal(words(record.errors.at(-1)),
    "After 2.0 s and 2.00 m the robot is 200 mm (10.0 % of the way) from where it believes it is.");
  assert.equal(words({ ...record.errors[0], heading: -Math.PI / 6 }),
    "After 0.0 s and 0.00 m the robot is 0 mm from where it believes it is, " +
    "and it believes that it faces 30.0° further to the right.");
  assert.deepEqual(reasons(record), ["It reads its wheels 10 times a second, and takes each piece for an arc."]);
  record.planned.setting = { ...OPENING, believed_track_width: 0.42, ticks: 60 };
  record.grip = { ...record.grip, slip: [null, 1.25], fall: 3 };
  const [radius, track, slip, fall, ticks] = reasons(record);
  assert.match(radius, /right radius to be 9\.0 % smaller/);
  assert.match(track, /track width to be 5\.0 % larger/);
  assert.match(slip, /^The right wheel slips, first at 1\.3 s/);
  assert.match(fall, /falls at 3\.0 s/);
  assert.match(ticks, /60 steps a turn/);
  record.grip = { ...record.grip, lift: 1.04, fall: null };
  assert.equal(reasons(record)[3], "A wheel or the caster is off the floor, first at 1.0 s.");
});

test("whatever is believed wrongly is named, and nothing else", () => {
  const record = straight(), wise = enlightened({ ...OPENING, rate: 50 });
  const labels = { left_radius: "left radius", right_radius: "right radius", track_width: "track width" };
  for (const [name, label] of Object.entries(labels)) {
    for (const [factor, far] of [[1 + 1e-7, "slightly larger"], [0.9996, "0.040 % smaller"], [1.1, "10.0 % larger"],
      [0.01, "99.0 % smaller"], [100, "9900 % larger"]]) {
      record.planned.setting = { ...wise, [`believed_${name}`]: factor * wise[name] };
      assert.deepEqual(reasons(record), [`It takes its ${label} to be ${far} than it is.`]);
    }
  }
  record.planned.setting = wise;
  assert.deepEqual(reasons(record), ["It believes what is true of its wheels, and they roll: odometry works."]);
  record.planned.setting = { ...wise, rate: 1 };
  assert.deepEqual(reasons(record), ["It reads its wheels once a second, and takes each piece for an arc."]);
});

test("lengths and numbers read well", () => {
  const lengths = [12.3456, 0.99996, 0.5, 0.0123, 6.94e-4, 1.2e-5, 1e-9];
  assert.deepEqual(lengths.map(length),
    ["12.35 m", "1000 mm", "500 mm", "12.3 mm", "694 µm", "12 µm", "0 mm"]);
  const row = straight().errors.at(-1);
  assert.match(words({ ...row, position: 46.25 }), /46\.25 m \(2313 % of the way\)/);
  assert.match(words({ ...row, position: 1e-6, heading: 0.1 }), /1\.0 µm \(less than 0\.01 % of the way\)/);
  assert.deepEqual([-0.0001, -1.25, 0.05].map((x) => fixed(x, 1)), ["0.0", "−1.3", "0.1"]);
  assert.ok(Math.abs(wrapped(3 * Math.PI / 2) + Math.PI / 2) < 1e-15);
  assert.equal(wrapped(-Math.PI), Math.PI);
});

test("sliders reach a fifth to either side, on their own steps", () => {
  assert.deepEqual(reach("left_radius", 0.1), { min: 80, max: 120, step: 0.1 });
  assert.deepEqual(reach("left_radius", 0.02835), { min: 22.68, max: 34.02, step: 0.01 });
  assert.deepEqual([0, 11, 12, 3000, 1e6].map((ticks) => KNOBS.ticks.steps[nearest(KNOBS.ticks.steps, ticks)]),
    [0, 12, 12, 4096, 4096]);
});
