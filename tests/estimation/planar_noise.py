"""Drives with noise of the wheels, by arithmetic of their own, and what is stated of where they end."""

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


def drives_of_robots(angles, parameters, starts=0.0):
    """Where a drive ends (N, 3) for robots of many radii and track widths (N, 3)."""
    left_radius, right_radius, track = np.transpose(parameters)
    x, y, theta = np.transpose(np.broadcast_to(starts, (len(parameters), 3))).copy()
    for left, right in np.diff(angles, axis=0):
        turn = (right_radius * right - left_radius * left) / track
        chord = (left_radius * left + right_radius * right) / 2 * np.sinc(turn / 2 / np.pi)
        x += chord * np.cos(theta + turn / 2)
        y += chord * np.sin(theta + turn / 2)
        theta += turn
    return np.stack([x, y, theta], axis=-1)


def farthest(ends, mean, covariance):
    """How many standard errors where drives end (N, 3) is away from a stated mean, covariance and NEES of three."""
    count = len(ends)
    off = ends - mean
    products = np.einsum("ni,nj->nij", off, off)
    scatter = products.std(axis=0) / np.sqrt(count)
    squares = np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off)
    return (
        np.abs(off.mean(axis=0) / np.sqrt(np.diag(covariance) / count)).max(),
        np.abs((products.mean(axis=0) - covariance) / scatter).max(),
        abs(squares.mean() - 3) / (squares.std() / np.sqrt(count)),
    )


def least_eigenvalue(covariance):
    """The least eigenvalue of covariances (..., 3, 3), as a share of the scales of x, y and theta."""
    scale = np.sqrt(np.maximum(np.diagonal(covariance, axis1=-2, axis2=-1), 1e-300))
    scale = np.maximum(scale, 1e-9 * scale.max())
    return np.linalg.eigvalsh(covariance / (scale[..., :, None] * scale[..., None, :])).min()
