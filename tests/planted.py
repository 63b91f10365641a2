"""Drives of a robot that is known, and what an encoder and a tracker make of them."""

import math

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.derivatives import PARAMETERS
from diffdrive_mj.maneuvers import Segment, sequence

BELIEVED = dd.Robot.load("matched")
TRUE = BELIEVED.replace(left_radius=0.102, right_radius=0.097, track_width=0.413)


def mixed(robot=BELIEVED, **options):
    """Straight lines, turns on the spot and arcs, both ways."""
    legs = [
        [Segment(2, 0, 3)],
        [Segment(0, math.pi / 2, 1.5)],
        [Segment(2.5, 2.5, 4)],
        [Segment(2.5, -2.5, 4)],
        [Segment(0, -2 * math.pi / 3, 2)],
        [Segment(3, -4, 5)],
        [Segment(1.5, 0, 2.5)],
        [Segment(3, 4, 5)],
    ]
    return sequence(robot, legs, **options)


def ideal(robot, commands=None, start=(0.0, 0.0, 0.0), rate=1.0):
    """A drive of wheels that do exactly as told, the truth by the robot's own odometry."""
    commands = commands or mixed()
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(commands.wheel_rates * commands.period, axis=0)])
    t = np.arange(len(angles)) * commands.period
    truth = dd.odometry.integrate(angles, robot, start=start)
    every = round(1 / rate)
    return Drive(t=t, wheel_angles=angles, truth=truth[::every], truth_t=t[::every])


def noisy(drive, noise, rng):
    """A drive whose true poses are off by some noise [m, m, rad]."""
    truth = drive.truth + noise * rng.normal(size=drive.truth.shape)
    return Drive(t=drive.t, wheel_angles=drive.wheel_angles, truth=truth, truth_t=drive.clock, name=drive.name)


def counted(drive, ticks, every, rng):
    """A drive whose encoder has so many ticks a turn, and is read at every few of its samples."""
    tick = 2 * math.pi / ticks
    angles = np.floor(drive.wheel_angles / tick + rng.random(2)) * tick
    return Drive(drive.t[::every], angles[::every], drive.truth[::every], drive.t[::every], drive.name)


def ends(drive, samples):
    """The beginning of a drive, with its first and its last true pose alone."""
    last = samples - 1
    return Drive(drive.t[:samples], drive.wheel_angles[:samples], drive.truth[[0, last]], drive.t[[0, last]])


def similar(robot, rng, spread=0.05):
    """A robot that is not quite the one believed."""
    return robot.replace(**{name: getattr(robot, name) * (1 + rng.uniform(-spread, spread)) for name in PARAMETERS[:3]})


def vector(robot):
    return np.array([getattr(robot, name) for name in PARAMETERS])
