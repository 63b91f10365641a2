"""Wrong odometries that are not in the museum: other numbers, other places of a fault, two faults at once.

Each is the right one with some of its parts replaced, beside words that its reason must have.
"""

import math

import numpy as np

from diffdrive_mj.judging.right import Right

RADII = ("left_radius", "right_radius")


def wrong(told=None, wheels=None, counts=None, step=None, motion=None, move=None, answer=None, shift=None):
    """A class that is right but for some of its parts; each is a function of the odometry and what the part gets."""

    class Wrong(Right):
        def __init__(self, header):
            super().__init__({**header, **told(header)} if told else header)

        def update(self, read, t):
            return super().update(tuple(wheels(self, *read)) if wheels else read, t)

    parts = {"counts": counts, "step": step, "motion": motion, "move": move, "answer": answer, "shift": shift}
    for name, part in parts.items():
        if part is not None:
            setattr(Wrong, name, part)
    return Wrong


def euler(self, distance, turn):
    self.shift(distance, self.theta)
    self.theta += turn


def midpoint(self, distance, turn):
    self.shift(distance, self.theta + turn / 2)
    self.theta += turn


def backward_euler(self, distance, turn):
    self.theta += turn
    self.shift(distance, self.theta)


def trapezoid(self, distance, turn):
    for direction in (self.theta, self.theta + turn):
        self.shift(distance / 2, direction)
    self.theta += turn


def clamped(self, left, right, dt):
    """No wheel is believed to be faster than 0.3 m/s."""
    left, right = (max(-0.3 * dt, min(0.3 * dt, way)) for way in (left, right))
    return (left + right) / 2, (right - left) / self.track


def straight_below(threshold, along=0.0):
    def move(self, distance, turn):
        if abs(turn) < threshold:
            self.shift(distance, self.theta + along * turn)
            self.theta += turn
        else:
            Right.move(self, distance, turn)

    return move


def by_radius_above(threshold):
    def move(self, distance, turn):
        if abs(turn) < threshold:
            Right.move(self, distance, turn)
        else:
            after = self.theta + turn
            self.x += distance / turn * (math.sin(after) - math.sin(self.theta))
            self.y -= distance / turn * (math.cos(after) - math.cos(self.theta))
            self.theta = after

    return move


def scaled(x, y, theta):
    return lambda self: (x * self.x, y * self.y, theta * self.theta)


def factors(left=1.0, right=1.0, distance=1.0, turn=1.0):
    def motion(self, a, b, seconds):
        a, b = left * a, right * b
        return distance * (a + b) / 2, turn * (b - a) / self.track

    return motion


def finite(left, right, t):
    return all(map(math.isfinite, (left, right, t)))


def at_rest_after_a_gap(self, left, right, seconds):
    return (0.0, 0.0) if seconds > 1.0 else Right.motion(self, left, right, seconds)


def whole_radians(self, *read):
    return [math.trunc(wheel * self.unit) / self.unit if math.isfinite(wheel) else wheel for wheel in read]


def point_ahead(self):
    return self.x + 0.12 * math.cos(self.theta), self.y + 0.12 * math.sin(self.theta), self.theta


def filtered(self, left, right, seconds):
    """A low pass, which no table of mistakes has."""
    before = getattr(self, "before", (0.0, 0.0))
    self.before = (0.7 * before[0] + 0.3 * left, 0.7 * before[1] + 0.3 * right)
    return Right.motion(self, *self.before, seconds)


def drifting(self, left, right, seconds):
    distance, turn = Right.motion(self, left, right, seconds)
    return distance, turn + 1e-3


def theta_in_single_precision(self, distance, turn):
    Right.move(self, distance, turn)
    self.theta = float(np.float32(self.theta))


def every_second(self):
    self.count = getattr(self, "count", 0) + 1
    if self.count % 2:
        self.answered = Right.answer(self)
    return self.answered


def left_late(self, left, right):
    before, self.left = getattr(self, "left", left), left
    return before, right


def dead_band(self, left, right, seconds):
    left, right = (0.0 if abs(way) < 0.003 else way for way in (left, right))
    return Right.motion(self, left, right, seconds)


def whole_millimetres(self, left, right, seconds):
    return Right.motion(self, math.trunc(left * 1e3) / 1e3, math.trunc(right * 1e3) / 1e3, seconds)


def mean_from_zero(self, distance, turn):
    before, after = self.theta % (2 * math.pi), (self.theta + turn) % (2 * math.pi)
    self.shift(distance * (math.sin(turn / 2) / (turn / 2) if turn else 1.0), (before + after) / 2)
    self.theta = after


ONE = {
    "backward Euler": (wrong(move=backward_euler), "heading after them"),
    "straight below 1e-5": (wrong(move=straight_below(1e-5)), "driven straight on"),
    "straight below 1e-2": (wrong(move=straight_below(1e-2)), "driven straight on"),
    "straight below 0.05": (wrong(move=straight_below(0.05)), "driven straight on"),
    "midpoint below 0.05": (wrong(move=straight_below(0.05, 0.5)), "along chords as long as their arcs"),
    "divided above 1e-12": (wrong(move=by_radius_above(1e-12)), "lost in rounding, divided by their turn"),
    "track of the outer edges": (wrong(told=lambda h: {"track_width": h["track_width"] + 0.03}), "a track width of"),
    "track of the inner edges": (wrong(told=lambda h: {"track_width": h["track_width"] - 0.03}), "a track width of"),
    "half of the track": (wrong(told=lambda h: {"track_width": h["track_width"] / 2}), "half of the track width"),
    "track twice": (wrong(told=lambda h: {"track_width": h["track_width"] * 2}), "the track width twice"),
    "centimetres": (wrong(answer=scaled(100, 100, 1)), "centimetres: give metres"),
    "millimetres": (wrong(answer=scaled(1e3, 1e3, 1)), "millimetres: give metres"),
    "degrees": (wrong(answer=scaled(1, 1, 180 / math.pi)), "headings are in degrees"),
    "sign of theta": (wrong(answer=scaled(1, 1, -1)), "headings have the wrong sign"),
    "bearings": (wrong(answer=lambda self: (self.x, self.y, math.pi / 2 - self.theta)), "bearings"),
    "x and y exchanged": (wrong(answer=lambda self: (self.y, self.x, self.theta)), "x and y are exchanged"),
    "sine and cosine exchanged": (
        wrong(shift=lambda self, length, direction: Right.shift(self, length, math.pi / 2 - direction)),
        "sine and cosine are exchanged",
    ),
    "cosine of degrees": (
        wrong(shift=lambda self, length, direction: Right.shift(self, length, math.degrees(direction))),
        "sine and cosine get degrees",
    ),
    "left reversed": (wrong(wheels=lambda self, left, right: (-left, right)), "left wheel counts backwards"),
    "right reversed": (wrong(wheels=lambda self, left, right: (left, -right)), "right wheel counts backwards"),
    "both reversed": (wrong(wheels=lambda self, left, right: (-left, -right)), "both wheels count backwards"),
    "left for both": (wrong(motion=lambda self, a, b, dt: (a, 0.0)), "left wheel"),
    "radii exchanged": (
        wrong(told=lambda h: {"left_radius": h["right_radius"], "right_radius": h["left_radius"]}),
        "radii of left and right are exchanged",
    ),
    "right radius for both": (wrong(told=lambda h: {"left_radius": h["right_radius"]}), "taken for the right one"),
    "mean radius": (
        wrong(told=lambda h: dict.fromkeys(RADII, (h["left_radius"] + h["right_radius"]) / 2)), "taken for the mean one"
    ),
    "start heading forgotten": (wrong(told=lambda h: {"theta": 0.0}), "heading at the start is forgotten"),
    "start position forgotten": (wrong(told=lambda h: {"x": 0.0, "y": 0.0}), "position at the start is forgotten"),
    "start heading in degrees": (
        wrong(told=lambda h: {"theta": math.radians(h["theta"])}), "heading at the start is taken for degrees"
    ),
    "path not turned": (
        wrong(told=lambda h: {"theta": 0.0, "first": h["theta"]},
              answer=lambda self: (self.x, self.y, self.theta + self.header["first"])),
        "not turned by the heading at the start",
    ),
    "four edges": (wrong(motion=factors(left=4.0, right=4.0)), "counted four times"),
    "pi of 3.14": (wrong(motion=factors(left=3.14 / math.pi, right=3.14 / math.pi)), "pi is taken for 3.14"),
    "two percent of slip": (wrong(motion=factors(distance=0.98)), "distances are 0.98 times the right ones"),
    "one diameter": (wrong(motion=factors(left=2.0)), "left wheel rolls 2 times the right way (diameters for radii)"),
    "wheels five percent apart": (
        wrong(motion=factors(left=1.02, right=0.97)), "1.02 times the right way and the right wheel rolls 0.97 times"
    ),
    "no radius": (wrong(told=lambda h: {"left_radius": 1.0, "right_radius": 1.0}), "wheel"),
    "wraps backwards only": (
        wrong(step=lambda self, d: d - 2**self.bits if self.bits and d > 2 ** (self.bits - 1) else d), "backwards only"
    ),
    "unsigned steps": (wrong(step=lambda self, d: d % 2**self.bits if self.bits else d), "unsigned"),
    "wraps left out": (
        wrong(step=lambda self, d: 0.0 if self.bits and abs(d) > 2 ** (self.bits - 1) else d), "across a wrap is left"
    ),
    "wraps at 15 bits": (
        wrong(step=lambda self, d: (d + 2**14) % 2**15 - 2**14 if self.bits else d), "undone at 15 bits"
    ),
    "counts in an int16_t": (
        wrong(wheels=lambda self, *read: [(r + 2**15) % 2**16 - 2**15 if self.unit != 1 else r for r in read],
              step=lambda self, d: d),
        "kept in 16 bits, signed",
    ),
    "no number for zero": (
        wrong(wheels=lambda self, *read: [r if math.isfinite(r) else 0.0 for r in read]), "taken for zero"
    ),
    "equal times taken in": (
        wrong(counts=lambda self, a, b, t: finite(a, b, t) and (self.last is None or t >= self.last[0])),
        "at the time of the one before are taken in",
    ),
    "gaps lost": (wrong(motion=at_rest_after_a_gap), "the motion across missing readings"),
    "answers in millimetres' steps": (
        wrong(answer=lambda self: (round(self.x, 3), round(self.y, 3), self.theta)), "whole millimetres"
    ),
    "answers in centimetres' steps": (
        wrong(answer=lambda self: (round(self.x, 2), round(self.y, 2), self.theta)), "whole centimetres"
    ),
    "turns rounded to degrees": (
        wrong(motion=lambda self, a, b, dt: ((a + b) / 2, math.radians(round(math.degrees((b - a) / self.track))))),
        "whole degrees",
    ),
    "distances cut to millimetres": (
        wrong(motion=lambda self, a, b, dt: (math.trunc((a + b) / 2 * 1e3) / 1e3, (b - a) / self.track)),
        "cut to whole millimetres",
    ),
    "trapezoid": (wrong(move=trapezoid), "mean of the directions before and after them (trapezoid)"),
    "nothing taken in": (wrong(answer=lambda self: (0.0, 0.0, 0.0)), "all answers are the same pose"),
    "integer radians": (wrong(wheels=whole_radians), "whole radians"),
    "distance is a speed": (
        wrong(motion=lambda self, a, b, dt: ((a + b) / 2 / dt, (b - a) / self.track)), "distance is its speed"
    ),
    "time twice": (wrong(motion=lambda self, a, b, dt: ((a + b) / 2 * dt, (b - a) / self.track * dt)), "need not"),
    "period of 20 ms": (
        wrong(motion=lambda self, a, b, dt: ((a + b) / 2 / dt * 0.02, (b - a) / self.track / dt * 0.02)),
        "a fixed period of 0.02 s",
    ),
    "point ahead of the axle": (
        wrong(answer=point_ahead), "a point 0.12 m ahead and"
    ),
    "readings in single precision": (wrong(wheels=lambda self, *read: map(float, np.float32(read))), "single"),
    "backwards for forwards": (
        wrong(motion=lambda self, a, b, dt: (abs(a + b) / 2, (b - a) / self.track)), "backwards is taken for forwards"
    ),
    "sine of the turn": (
        wrong(motion=lambda self, a, b, dt: ((a + b) / 2, math.sin((b - a) / self.track))), "a turn is its sine"
    ),
    "theta in single precision": (wrong(move=theta_in_single_precision), "theta is in single precision"),
    "every second answer": (wrong(answer=every_second), "answers are those before: answer each reading"),
    "left wheel late": (wrong(wheels=left_late), "the left wheel's readings are one behind the right one's"),
    "dead band": (wrong(motion=dead_band), "of wheels that roll by"),
    "whole millimetres of each wheel": (wrong(motion=whole_millimetres), "each way of a wheel is cut"),
    "mean of headings from zero": (wrong(move=mean_from_zero), "both sides of zero degrees are averaged"),
    "tangent of the turn": (
        wrong(motion=lambda self, a, b, dt: ((a + b) / 2, math.tan((b - a) / self.track))), "a turn is its tangent"
    ),
    "pi of 22 / 7": (wrong(motion=factors(22 / 7 / math.pi, 22 / 7 / math.pi)), "pi is taken for 22 / 7"),
    "inches": (wrong(answer=scaled(1 / 0.0254, 1 / 0.0254, 1)), "x and y are in inches"),
    "headings in turns": (wrong(answer=scaled(1, 1, 0.5 / math.pi)), "headings are in turns"),
    "degrees that wrap": (
        wrong(answer=lambda self: (self.x, self.y, math.degrees(math.remainder(self.theta, 2 * math.pi)))),
        "headings are in degrees",
    ),
    "x mirrored": (wrong(answer=scaled(-1, 1, 1)), "x has the wrong sign"),
    "start elsewhere": (wrong(told=lambda h: {"theta": 2 * h["theta"]}), "it begins at x = "),
    "unsigned steps of 32 bits": (
        wrong(step=lambda self, d: d % 2**32 if self.bits else d), "unsigned ones of 32 bits"
    ),
}  # fmt: skip

TWO = {
    "swapped, Euler": (wrong(wheels=lambda self, a, b: (b, a), move=euler), ("swapped", "Euler")),
    "start, midpoint": (
        wrong(told=lambda h: {"x": 0.0, "y": 0.0, "theta": 0.0}, move=midpoint), ("start pose is forgotten", "midpoint")
    ),
    "diameters, Euler": (wrong(motion=factors(2.0, 2.0), move=euler), ("diameters for radii", "Euler")),
    "diameters, no track": (
        wrong(motion=lambda self, a, b, dt: (a + b, 2 * (b - a))), ("2 times", "turns are")
    ),
    "swapped, degrees": (
        wrong(wheels=lambda self, a, b: (b, a), answer=scaled(1, 1, 180 / math.pi)), ("swapped", "degrees")
    ),
    "one radius, start": (
        wrong(told=lambda h: {"right_radius": h["left_radius"], "x": 0.0, "y": 0.0, "theta": 0.0}),
        ("taken for the left one", "start pose is forgotten"),
    ),
    "left reversed, half of the track": (
        wrong(wheels=lambda self, a, b: (-a, b), told=lambda h: {"track_width": h["track_width"] / 2}),
        ("left wheel counts backwards", "half of the track"),
    ),
    "speeds, Euler": (
        wrong(motion=lambda self, a, b, dt: ((a + b) / 2 / dt, (b - a) / self.track / dt), move=euler),
        ("steps are speeds", "Euler"),
    ),
    "clockwise, start": (
        wrong(told=lambda h: {"x": 0.0, "y": 0.0, "theta": 0.0}, motion=factors(turn=-1.0)),
        ("clockwise", "start pose is forgotten"),
    ),
    "centimetres, midpoint": (wrong(move=midpoint, answer=scaled(100, 100, 1)), ("centimetres", "midpoint")),
    "wraps not undone, Euler": (wrong(step=lambda self, d: d, move=euler), ("Euler",)),
    "swapped, track of the outer edges": (
        wrong(wheels=lambda self, a, b: (b, a), told=lambda h: {"track_width": h["track_width"] + 0.03}),
        ("swapped", "track width of"),
    ),
    "y to the right, start": (
        wrong(told=lambda h: {"x": 0.0, "y": 0.0, "theta": 0.0},
              shift=lambda self, length, direction: Right.shift(self, length, -direction)),
        ("y grows to the right",),
    ),
    "slip, start heading": (
        wrong(told=lambda h: {"theta": 0.0}, motion=factors(distance=0.98)), ("0.98 times", "heading at the start")
    ),
}  # fmt: skip

# What no table has: nothing is said rather than something wrong.
UNKNOWN = {"a low pass": wrong(motion=filtered), "a turn that drifts": wrong(motion=drifting),
    "a gyro's drift": wrong(motion=lambda self, a, b, dt: ((a + b) / 2, (b - a) / self.track + 1e-4 * dt)),
    "speeds are clamped": wrong(motion=clamped)}  # fmt: skip
