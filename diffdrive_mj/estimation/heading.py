"""The heading from a gyro beside wheels: which of the two to believe, and the gyro's bias while the robot stands.

All of it works on steps between an encoder's readings: by how much the wheels say that the robot turned, and the gyro.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._checks import Array
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.sensors.gyro import Gyro

Flags = NDArray[np.bool_]


def standing(
    t: ArrayLike, wheel_angles: ArrayLike, *, settle: float = 0.5, lead: float = 0.1, still: float = 1e-3
) -> Flags:
    """Find the steps on which a robot stands: neither wheel turns, nor did or will for some time.

    Between a coarse encoder's last tick and the wheel's rest a robot still turns: with 60 ticks a turn and a servo that
    lags by 33 ms, by 0.03 degrees a second 0.3 s after the tick.

    Args:
        t: (T,) [s], increasing.
        wheel_angles: (..., T, 2) [rad], left then right.
        settle: how long the wheels have stood before [s].
        lead: how long they stand after [s].
        still: the wheel rate below which a wheel stands [rad/s]; less than a tick between two readings.

    Returns:
        (..., T - 1).

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, times that do not increase, numbers out of their range.

    Example:
        >>> t = np.linspace(0, 1, 11)
        >>> wheels = np.outer(np.maximum(t - 0.5, 0), (1, 1))
        >>> dd.estimation.heading.standing(t, wheels, lead=0.2).tolist()
        [True, True, True, False, False, False, False, False, False, False]
    """
    angles = checks.array("wheel_angles", wheel_angles, "T", 2)
    at = checks.increasing("t", checks.vector("t", t, angles.shape[-2]))
    after, before = checks.not_negative("settle", settle) - 1e-9, checks.not_negative("lead", lead) - 1e-9
    rates = np.abs(np.diff(angles, axis=-2)).max(axis=-1) / np.diff(at)
    moving = rates > checks.not_negative("still", still)
    last = np.maximum.accumulate(np.where(moving, at[1:], -np.inf), axis=-1)
    following = np.minimum.accumulate(np.where(moving, at[:-1], np.inf)[..., ::-1], axis=-1)[..., ::-1]
    return np.asarray(~moving & (at[:-1] - last >= after) & (following - at[1:] >= before))


def switched(wheels: ArrayLike, gyro: ArrayLike, dt: ArrayLike, threshold: float) -> tuple[Array, Flags]:
    """Take each step's turn from the wheels, or from the gyro where their rates differ by more than a threshold.

    ```
    dtheta = dtheta_gyro    if |dtheta_gyro - dtheta_wheels| > threshold dt,    else dtheta_wheels
    ```

    Args:
        wheels: turns by the wheels (..., S) [rad].
        gyro: turns by the gyro, without its bias (..., S) [rad].
        dt: how long each step takes (S,) [s].
        threshold: [rad/s], above what ticks and the gyro's noise make of a rate on a good floor.

    Returns:
        The turns (..., S) [rad], and whether the gyro was believed (..., S).

    Raises:
        InvalidType: not numbers.
        InvalidValue: shapes that do not fit, steps that take no time, a negative threshold.

    References:
        Borenstein and Feng (1996), gyrodometry.

    Example:
        A bump that the wheels take for a turn:

        >>> turns, by_gyro = dd.estimation.heading.switched([0.0, 0.05, 0.0], [0.001, -0.01, 0.001], 0.1, threshold=0.1)
        >>> print(turns, by_gyro)
        [ 0.   -0.01  0.  ] [False  True False]
    """
    rolled, seen = checks.array("wheels", wheels, "S"), checks.array("gyro", gyro, "S")
    time = checks.positive_array("dt", dt)
    checks.broadcast(wheels=rolled, gyro=seen, dt=time)
    off = np.abs(seen - rolled) > checks.not_negative("threshold", threshold) * time
    return np.where(off, seen, rolled), off


def switch_threshold(gyro: Gyro, interval: float, heading_per_tick: ArrayLike, *, sigmas: float = 4.0) -> float:
    """Compute by how much the rates of wheels and gyro differ on a good floor, for `switched`.

    ```
    sigmas sqrt((h_l^2 + h_r^2) / (6 dt^2) + N^2 / dt)
    ```

    A step between two counts that are rounded is off by a tick / sqrt(6), at any phase.

    Args:
        gyro: as it is believed.
        interval: dt, of the encoder [s].
        heading_per_tick: h, for a tick of the left wheel and of the right (2,) [rad] (`Encoder.heading_per_tick`).
        sigmas: how many standard deviations.

    Returns:
        [rad/s]

    Raises:
        InvalidType: not a gyro, not numbers.
        InvalidValue: numbers that are not positive, or not two ticks.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> ticks = dd.Encoder(robot, sample_rate=20.0).heading_per_tick(robot)
        >>> round(dd.estimation.heading.switch_threshold(dd.Gyro.load("mpu6050"), 0.05, ticks), 3)
        0.018
    """
    ticks = checks.vector("heading_per_tick", heading_per_tick, 2)
    dt = checks.positive("interval", interval)
    rounding = float(np.square(ticks).sum()) / (6 * dt**2)
    white = checks.instance("gyro", gyro, Gyro).white_noise ** 2 / dt
    return checks.positive("sigmas", sigmas) * float(np.sqrt(rounding + white))


@dataclass(frozen=True, eq=False)
class FilteredHeading:
    """What `filtered` makes of a drive, before its first step and after each.

    Attributes:
        heading: (..., S + 1) [rad], zero at first.
        sigma: (..., S + 1) [rad], its stated standard deviation.
        bias: (..., S + 1) [rad/s].
        bias_sigma: (..., S + 1) [rad/s].
        standing: (..., S), on which steps the robot was taken to stand.

    Example:
        >>> dd.estimation.heading.filtered([0.1], dt=1.0, standing=[False], gyro=dd.Gyro()).heading.tolist()
        [0.0, 0.1]
    """

    heading: Array
    sigma: Array
    bias: Array
    bias_sigma: Array
    standing: Flags


def filtered(
    turns: ArrayLike,
    dt: ArrayLike,
    standing: ArrayLike,
    gyro: Gyro,
    *,
    wheels: ArrayLike | None = None,
    seen: ArrayLike | None = None,
    bias_sigma: float = 1.0,
    scale_sigma: float = 0.0,
    gate: float = 5.0,
) -> FilteredHeading:
    """Filter heading and bias: the gyro's turns add up, and what it reads while the robot stands is its bias.

    A Kalman filter with the exact covariance of the gyro's noise, Q here in what the gyro reads. While the robot drives

    ```
    theta += (w - b) dt / gain        Q = [[N^2 dt + K^2 dt^3 / 3, -K^2 dt^2 / 2], [-K^2 dt^2 / 2, K^2 dt]]
    ```

    and while it stands the heading stays and w measures the bias with the variance N^2 / dt + K^2 dt / 3. What a stop
    says of the bias also puts right, in part, the heading that was gained with a bias less well known.

    Args:
        turns: by the gyro, w dt (..., S) [rad].
        dt: how long each step takes, (S,) or a number [s].
        standing: on which steps the robot stands (..., S).
        gyro: as it is believed: its noise, its scale error and its tilt, which are taken out, and its bias, where the
            estimate begins.
        wheels: turns by the wheels (..., S) [rad], taken where the gyro has not seen a step.
        seen: whether it has (..., S); all of them where it is left out.
        bias_sigma: how well that bias is known before the start [rad/s].
        scale_sigma: how well the scale error is known, which standing does not show.
        gate: by how many standard deviations a reading may be off a standing robot's, or the robot is taken to turn
            though its wheels stand.

    Returns:
        Heading and bias with their standard deviations. That of the heading does not count what the wheels add.

    Raises:
        InvalidType: not numbers, not bools, not a gyro.
        InvalidValue: shapes that do not fit, steps that take no time, steps that are not seen without wheels.

    References:
        Farrenkopf (1978): the covariance.

    Example:
        A robot that stands for 10 s and turns by 1 rad in the next two, with a gyro that reads 0.1 rad/s at rest:

        >>> gyro = dd.Gyro(angle_random_walk=1e-3)
        >>> rates = np.where(np.arange(120) < 100, 0.1, 0.6)
        >>> found = dd.estimation.heading.filtered(0.1 * rates, 0.1, np.arange(120) < 100, gyro)
        >>> print(f"{found.heading[-1]:.4f} rad, sigma {found.sigma[-1]:.4f} rad, bias {found.bias[-1]:.4f} rad/s")
        1.0000 rad, sigma 0.0015 rad, bias 0.1000 rad/s
    """
    turned = checks.array("turns", turns, "S")
    count = turned.shape[-1]
    time = checks.positive_array("dt", dt)
    if time.shape not in ((), (1,), (count,)):
        raise InvalidValue(f"dt has shape {time.shape}: must be a number or ({count},), as many as turns has")
    time = np.broadcast_to(time, (count,))
    still = checks.flags("standing", standing, count)
    watched = np.ones(count, dtype=np.bool_) if seen is None else checks.flags("seen", seen, count)
    if wheels is None and not watched.all():
        raise InvalidValue("wheels = None: must be given where the gyro has not seen every step")
    rolled = np.zeros(count) if wheels is None else checks.array("wheels", wheels, "S")
    checks.broadcast(turns=turned, standing=still, wheels=rolled, seen=watched)
    checks.instance("gyro", gyro, Gyro)
    known, scale = checks.not_negative("bias_sigma", bias_sigma), checks.not_negative("scale_sigma", scale_sigma)
    turned, still, rolled, watched = np.broadcast_arrays(turned, still, rolled, watched)
    states, rested = _filter(
        turned, still, gyro.gain * rolled, watched, time, gyro, known, checks.positive("gate", gate)
    )
    heading, bias, variance, bias_variance = np.moveaxis(states, 1, -1)
    heading, variance = heading / gyro.gain, variance / gyro.gain**2
    sigma = np.sqrt(variance + (scale * heading) ** 2)
    return FilteredHeading(heading, sigma, bias, np.sqrt(bias_variance), np.moveaxis(rested, 0, -1))


def _filter(
    turned: Array, still: Flags, rolled: Array, watched: Flags, time: Array, gyro: Gyro, known: float, gate: float
) -> tuple[Array, Flags]:
    """Heading, bias and their variances (4, S + 1, ...), all as the gyro reads, and where the robot rested (S, ...)."""
    white, walk = gyro.white_noise**2, gyro.bias_random_walk**2
    states = np.zeros((4, turned.shape[-1] + 1, *turned.shape[:-1]))
    states[3, 0] = known**2
    states[1, 0] = gyro.bias
    heading, bias, variance, bias_variance = states[:, 0].copy()
    mixed = np.zeros_like(heading)
    rested = np.zeros((turned.shape[-1], *turned.shape[:-1]), dtype=np.bool_)
    # The steps run along the first axis: each of them is then contiguous.
    steps = (np.moveaxis(values, -1, 0) for values in (turned, rolled, still & watched, watched))
    for k, (dt, turn, roll, at_rest, seen) in enumerate(zip(time, *steps, strict=True), start=1):
        off = turn / dt - bias
        spread = bias_variance + white / dt + walk * dt / 3
        rests = at_rest & (off**2 <= gate**2 * spread)
        drives = seen & ~rests
        # What a standing robot's reading moves of the bias and of the heading: nothing while it drives.
        with_bias = bias_variance + walk * dt / 2
        certainty = np.divide(rests, spread, out=np.zeros_like(spread), where=spread > 0)
        gain, gain_of_heading = with_bias * certainty, mixed * certainty
        heading = heading + np.where(drives, turn - bias * dt, np.where(seen, 0.0, roll)) + gain_of_heading * off
        bias = bias + gain * off
        grown = white * dt + walk * dt**3 / 3 - 2 * dt * mixed + dt**2 * bias_variance
        variance = variance + drives * grown - gain_of_heading * mixed
        mixed = mixed - drives * dt * with_bias - gain_of_heading * with_bias
        bias_variance = np.maximum(bias_variance + walk * dt - gain * with_bias, 0.0)
        states[:, k] = heading, bias, np.maximum(variance, 0.0), bias_variance
        rested[k - 1] = rests
    return states, rested
