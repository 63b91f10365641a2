"""The page that lies beside the files of the suite: all that a runner in any language must know."""

PAGE = """\
# Conformance suite for differential-drive odometry

Each CSV file here is a drive: what the encoders of the wheels read, and the exact poses. A runner needs these files and
nothing else. It computes the poses with the odometry under test, compares, and fails where one is off.

## A file

    # diffdrive 1 unit=rad left_radius=0.1 right_radius=0.091 track_width=0.4 ticks_per_revolution=4096.0 x=2.0 ...
    t,left,right,x,y,theta
    0.0,0.0,0.0,2.0,-1.0,0.5

- Line 1: the header, words apart by blanks. After `# diffdrive 1` pairs `name=value` in any order; names that are not
  known are passed over.
- Line 2: the names of the columns.
- Then a line for each reading: time [s], left and right wheel, and the pose that is expected after it [m, m, rad].

| name | meaning |
| --- | --- |
| unit | of left and right: `rad`, or `ticks`, which are whole numbers |
| left_radius, right_radius, track_width | of the robot [m] |
| ticks_per_revolution | ticks for a turn of a wheel, gears included; need not be whole |
| x, y, theta | the pose at the first reading that counts [m, m, rad] |
| counter_bits | of counters that wrap; left out where none does |
| tolerance | how far a pose may be off [m] |

Wheels are absolute and cumulative; they need not begin at zero. x points forward and y left of a robot whose theta is
zero, theta grows counter-clockwise, the pose is that of the midpoint between the wheels. Between two readings the
wheels turn at constant rates, so that the robot drives an arc.

## Readings that do not count

A reading counts if t, left and right are numbers (not NaN) and t is later than that of the last reading that counted.
One that does not count holds the pose, and is not taken in: the next one that counts takes the whole motion since the
last one that did. So do missing readings. The pose at the first reading that counts is the start, and before it too.

## Counters that wrap

With counter_bits = n a step is the difference of two counts modulo 2^n, taken into [-2^(n-1), 2^(n-1)). This is right
for signed counters and for unsigned ones.

## Comparing

A case passes if for every reading

    hypot(x - x', y - y', (track_width / 2) wrap(theta - theta')) <= tolerance

where the pose with the dash is the expected one, and wrap takes an angle into [-pi, pi]: theta may wrap. NaN fails.

The poses are computed in 50-digit arithmetic and rounded once. The tolerances are twice what rounding can add up to
in double precision, whatever the order of the sums, also for readings that are turned into metres before differences
are taken, and for formulas with 1 / turn that drive straight below some turn, if that is chosen well (about 1e-8 rad).
The chord with sin(turn / 2) / (turn / 2) needs no such threshold and stays fifty times below the tolerances.

`index.json` lists the cases, with what each is to show. The same suite in Python: `diffdrive_mj.judging.suite.cases()`.
"""
