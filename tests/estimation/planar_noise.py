"""Drives with noise of the wheels, by arithmetic of their own."""

from __future__ import annotations

import numpy as np

import diffdrive_mj as dd


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


def measured_drive(read, robot, k, generator, every=1, tracked=(0.0, 0.0)):
    """A drive at 10 Hz on wheel angles as read (T, 2): the true ways have noise, and so has the tracker."""
    steps = np.diff(read, axis=0) * (robot.left_radius, robot.right_radius)
    left, right = (steps + np.sqrt(np.abs(steps)) * k * generator.normal(size=steps.shape)).T
    turn = (right - left) / robot.track_width
    before = np.cumsum(turn) - turn
    chord = (left + right) / 2 * np.sinc(turn / 2 / np.pi) * np.exp(1j * (before + turn / 2))
    place = np.concatenate([[0], np.cumsum(chord)])
    truth = np.stack([place.real, place.imag, np.concatenate([[0], np.cumsum(turn)])], axis=-1)[::every]
    truth = truth + generator.normal(size=truth.shape) * (tracked[0], tracked[0], tracked[1])
    t = 0.1 * np.arange(len(read))
    return dd.Drive(t, read, truth, t[::every])
