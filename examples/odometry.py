"""Odometry over a pipe: reads t,left,right, in radians or ticks, and answers x,y,theta [m, m, rad].

diffdrive judge --robot ct_bot -- python examples/odometry.py
"""

import math
import sys

last = None
for line in sys.stdin:
    if line.startswith("#"):
        header = dict(pair.split("=") for pair in line.split()[3:])
        unit = header.pop("unit")
        number = {name: float(value) for name, value in header.items()}
        x, y, theta = number["x"], number["y"], number["theta"]
        scale = 2 * math.pi / number["ticks_per_revolution"] if unit == "ticks" else 1.0
        continue
    _, left, right = (float(cell) for cell in line.split(","))
    last = last or (left, right)
    d_left = number["left_radius"] * scale * (left - last[0])
    d_right = number["right_radius"] * scale * (right - last[1])
    last = left, right
    half = (d_right - d_left) / number["track_width"] / 2
    chord = (d_left + d_right) / 2 * (math.sin(half) / half if half else 1.0)
    x += chord * math.cos(theta + half)
    y += chord * math.sin(theta + half)
    theta += 2 * half
    print(x, y, theta, sep=",")
