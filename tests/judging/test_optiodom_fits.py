"""How the real robot's recordings are fitted: from their first true poses, by positions alone, or with a gain too."""

import numpy as np
import pytest
from real_data import optiodom_folder

import diffdrive_mj as dd
from diffdrive_mj.judging import optiodom
from diffdrive_mj.judging.accuracy import mixed_drive

TRUE = dd.Robot.load("optiodom").replace(left_radius=0.0413, right_radius=0.0422, track_width=0.207, turning_gain=0.02)


@pytest.fixture(scope="module")
def drives():
    """Exact drives of a robot with a turning gain, whose headings are a degree off but for the first."""
    rng, found = np.random.default_rng(0), []
    commands = mixed_drive(TRUE)
    angles = np.cumsum(commands.wheel_rates * commands.period, axis=0)[::10]
    truth = dd.odometry.integrate(angles, TRUE)
    truth[1:, 2] += np.radians(1.0)
    for _ in range(2):
        noise = 1e-5 * rng.normal(size=truth.shape) * (1, 1, 0)
        found.append(dd.Drive(np.arange(len(angles)) * 10 * commands.period, angles, truth + noise))
    return found


def test_a_gain_is_found_where_it_is_asked_for_alone(drives):
    assert optiodom.fit(drives).turning_gain == 0
    robot = optiodom.fit_with_gain(drives)
    for name in ("left_radius", "right_radius", "track_width", "turning_gain"):
        assert getattr(robot, name) == pytest.approx(getattr(TRUE, name), rel=5e-3), name


def test_the_first_true_heading_counts_and_no_other(drives):
    """Turned at the start, the path is turned: with a start that is estimated it would make no difference."""
    exact = optiodom.fit(drives)
    turned = []
    for drive in drives:
        truth = drive.truth.copy()
        truth[0, 2] += 0.01
        turned.append(dd.Drive(drive.t, drive.wheel_angles, truth))
    off = optiodom.fit(turned)
    assert abs(off.track_width / exact.track_width - 1) + abs(off.radius_ratio / exact.radius_ratio - 1) > 1e-4


def test_headings_after_the_first_are_not_read(drives):
    rng, turned = np.random.default_rng(1), []
    for drive in drives:
        truth = drive.truth.copy()
        truth[1:, 2] += 0.1 * rng.normal(size=len(truth) - 1)
        turned.append(dd.Drive(drive.t, drive.wheel_angles, truth))
    assert optiodom.fit(turned) == optiodom.fit(drives)


def test_every_recording_is_read_from_its_folder():
    found = optiodom.read_recordings(optiodom_folder())
    assert list(found) == list(optiodom.FOLDERS)
    assert min(map(len, found.values())) > 0
