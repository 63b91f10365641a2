"""From a recording to what a robot's encoders and a tracker write down of it: a drive like one of a real robot."""

from __future__ import annotations

from typing import Any, overload

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import shown
from diffdrive_mj.drive import Drive
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.recording import Recording
from diffdrive_mj.robot import Robot
from diffdrive_mj.sensors.encoder import Encoder
from diffdrive_mj.sensors.gyro import Gyro
from diffdrive_mj.sensors.tracker import Tracker

Seed = int | np.random.SeedSequence | np.random.Generator


@overload
def measure(
    recording: Recording[Robot, Any],
    *,
    encoder: Encoder | None = None,
    tracker: Tracker | None = None,
    gyro: Gyro | None = None,
    seed: Seed | None = None,
) -> Drive: ...


@overload
def measure(
    recording: Recording[tuple[Robot, ...], Any],
    *,
    encoder: Encoder | None = None,
    tracker: Tracker | None = None,
    gyro: Gyro | None = None,
    seed: Seed | None = None,
) -> list[Drive]: ...


def measure(
    recording: Recording[Any, Any],
    *,
    encoder: Encoder | None = None,
    tracker: Tracker | None = None,
    gyro: Gyro | None = None,
    seed: Seed | None = None,
) -> Drive | list[Drive]:
    """Measure a simulated drive: wheel angles by an encoder, true poses by a tracker, turns by a gyro.

    Args:
        recording: of one run or many.
        encoder: of both wheels, whose counters start at a random phase; None for ideal wheel angles.
        tracker: of the true pose; None for every recorded pose as it is.
        gyro: on the robot; None for none.
        seed: of the randomness, needed where something is random. Each run draws from streams of its own, one for each
            sensor: neither more runs nor another tracker change what an encoder reads.

    Returns:
        The drive, named after the robot; of a recording with many runs a list of drives, one a run.

    Raises:
        InvalidType: not a recording, an encoder, a tracker, or a seed.
        InvalidValue: randomness without a seed, or a recording too short for two readings.

    Example:
        >>> robot = dd.Robot.load("matched")
        >>> recording = dd.simulate(robot, dd.maneuvers.spin(robot, turns=0.05), sample_rate=50.0)
        >>> tracker = dd.Tracker(sample_rate=10.0, position_noise=1e-3, heading_noise=1e-3)
        >>> encoder = dd.Encoder(robot, sample_rate=50.0)
        >>> drive = dd.sensors.measure(recording, encoder=encoder, tracker=tracker, seed=0)
        >>> len(drive.t), len(drive.clock)
        (82, 17)
    """
    checks.instance("recording", recording, Recording)
    if encoder is not None:
        checks.instance("encoder", encoder, Encoder)
    if gyro is not None:
        checks.instance("gyro", gyro, Gyro)
    tracker = Tracker() if tracker is None else checks.instance("tracker", tracker, Tracker)
    random = {
        "the phase of the encoder's counters": encoder is not None,
        "the tracker's noise": tracker.is_random,
        "the gyro's noise": gyro is not None and gyro.is_random,
    }
    if seed is None and any(random.values()):
        what = next(name for name, is_random in random.items() if is_random)
        raise InvalidValue(f"seed = None: must be given, such as seed=0, since {what} is random")
    runs = recording.runs
    generators = _generator(0 if seed is None else seed).spawn(2 * len(runs))
    many = isinstance(recording.robot, tuple)
    drives = []
    for k, run in enumerate(runs):
        name = f"{run.robot.name}, run {k + 1}" if many else run.robot.name
        drives.append(_measured(run, name, encoder, tracker, gyro, *generators[2 * k : 2 * k + 2]))
    return drives if many else drives[0]


def _generator(seed: Seed) -> np.random.Generator:
    if isinstance(seed, (np.random.SeedSequence, np.random.Generator)):
        return np.random.default_rng(seed)
    if not isinstance(seed, (int, np.integer)):
        raise InvalidType(
            f"seed = {shown(seed)}: must be a whole number, a SeedSequence or a Generator of numpy.random"
        )
    return np.random.default_rng(checks.whole("seed", seed, least=0))


def _measured(
    run: Recording,
    name: str,
    encoder: Encoder | None,
    tracker: Tracker,
    gyro: Gyro | None,
    of_encoder: np.random.Generator,
    of_tracker: np.random.Generator,
) -> Drive:
    t, angles = run.t, run.wheel_angles
    if encoder is not None:
        readings = encoder.read(t, angles, of_encoder, phase="random")
        t, angles = readings.t, encoder.to_angles(readings.counts)
    track = tracker.read(run.t, run.truth, of_tracker)
    # The gyro's stream is drawn from the encoder's, so that the other two are what they were without a gyro.
    log = None if gyro is None else gyro.read(run.t, run.truth, of_encoder.spawn(1)[0], attitude=run.attitude)
    return Drive(t, angles, track.poses, track.t, name, warnings=() if log is None else log.warnings, gyro=log)
