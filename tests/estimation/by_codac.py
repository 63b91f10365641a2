"""The largest drift over boxes of robots in codac's interval arithmetic; JSON in, a number out.

A process of its own: codac leaves the processor rounding upwards, which changes whatever is computed beside it.
"""

import itertools
import json
import sys

import codac


def drift(angles: list[list[float]], box: list[list[float]], end: list[float]) -> float:
    """An upper bound on how far robots of a box of mean radius, asymmetry and track end from a place."""
    mean, asymmetry, track = (codac.Interval(*span) for span in box)
    left, right = mean * (1 - asymmetry), mean * (1 + asymmetry)
    x = y = codac.Interval(0)
    for (l0, r0), (l1, r1) in itertools.pairwise(angles):
        # Heading is linear in the angles: nothing is added up.
        before, after = (right * r0 - left * l0) / track, (right * r1 - left * l1) / track
        middle, half = (before + after) / 2, (right * (r1 - r0) - left * (l1 - l0)) / track / 2
        # For small h sinc(h) lies between 1 - h^2 / 6 and 1.
        short = 1 - codac.sqr(half) / 6
        length = (left * (l1 - l0) + right * (r1 - r0)) / 2 * codac.Interval(max(short.lb(), -0.22), 1)
        x, y = x + length * codac.cos(middle), y + length * codac.sin(middle)
    return float(codac.sqrt(codac.sqr(x - end[0]) + codac.sqr(y - end[1])).ub())


if __name__ == "__main__":
    given = json.load(sys.stdin)
    print(max(drift(given["angles"], box, given["end"]) for box in given["boxes"]))
