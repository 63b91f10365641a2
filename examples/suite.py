"""Test an odometry on the drives of `diffdrive suite`: python examples/suite.py cases/*.csv."""

import math
import operator
import sys


class Odometry:
    """The exact arc; readings that do not count hold the pose, and counters that wrap are counted on."""

    def __init__(self, header):
        tick = 2 * math.pi / header["ticks_per_revolution"] if header["unit"] == "ticks" else 1.0
        self.left, self.right = tick * header["left_radius"], tick * header["right_radius"]  # metres for each unit
        self.track, self.bits = header["track_width"], int(header.get("counter_bits", 0))
        self.x, self.y, self.theta = header["x"], header["y"], header["theta"]
        self.last = None

    def update(self, wheels, t):
        """Take in a reading, and answer with the pose."""
        if not all(map(math.isfinite, (t, *wheels))) or (self.last and t <= self.last[1]):
            return self.x, self.y, self.theta  # holds the pose
        if self.last:
            left, right = (self.step(new - old) for new, old in zip(wheels, self.last[0], strict=True))
            left, right = self.left * left, self.right * right
            half = (right - left) / self.track / 2
            chord = (left + right) / 2 * (math.sin(half) / half if half else 1.0)
            self.x += chord * math.cos(self.theta + half)
            self.y += chord * math.sin(self.theta + half)
            self.theta += 2 * half
        self.last = wheels, t
        return self.x, self.y, self.theta

    def step(self, ticks):
        """The shortest step of a counter that wraps."""
        half = 2 ** (self.bits - 1)
        return (ticks + half) % (2 * half) - half if self.bits else ticks


def off(path):
    """How far the odometry is off the expected poses at most, and how far it may be [m]."""
    with open(path) as file:
        pairs = (pair.split("=") for pair in next(file).split()[3:])
        header = {name: value if name == "unit" else float(value) for name, value in pairs}
        next(file)
        odometry, worst = Odometry(header), 0.0
        for line in file:
            t, left, right, *expected = map(float, line.split(","))
            x, y, theta = map(operator.sub, odometry.update((left, right), t), expected)
            gap = math.hypot(x, y, math.remainder(theta, 2 * math.pi) * header["track_width"] / 2)
            worst = max(worst, gap if math.isfinite(gap) else math.inf)
    return worst, header["tolerance"]


if __name__ == "__main__":
    failed = 0
    for path in sys.argv[1:]:
        worst, tolerance = off(path)
        failed += worst > tolerance
        print(f"{'ok  ' if worst <= tolerance else 'FAIL'} {path}: off by {worst:.1e} m, at most {tolerance:.1e} m")
    sys.exit(failed > 0)
