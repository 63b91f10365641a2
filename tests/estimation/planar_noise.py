"""Drives with noise of the wheels, by arithmetic of their own."""

from __future__ import annotations

import numpy as np


def drives_with_noise(angles, robot, k, count, generator):
    """Where many drives end (count, 3) whose wheels' ways have the variance k^2 times each step's way."""
    x, y, theta = np.zeros((3, count))
    for step in np.diff(angles, axis=0) * (robot.left_radius, robot.right_radius):
        left, right = (step + np.sqrt(np.abs(step)) * k * generator.normal(size=(count, 2))).T
        turn = (right - left) / robot.track_width
        chord = (left + right) / 2 * np.sinc(turn / 2 / np.pi)
        x += chord * np.cos(theta + turn / 2)
        y += chord * np.sin(theta + turn / 2)
        theta += turn
    return np.stack([x, y, theta], axis=-1)
