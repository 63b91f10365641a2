"""How drives start: what is pinned to the truth is not a measurement, and what is not is found."""

import math

import numpy as np
import pytest
from hypothesis import given
from planted import BELIEVED, TRUE, ends, ideal, mixed, noisy, vector
from strategies import numbers

import diffdrive_mj as dd
from diffdrive_mj.calibration._cautions import speed_at_first
from diffdrive_mj.calibration._problem import Problem
from diffdrive_mj.calibration._start import FREE, by_first_pose, first_pose, from_first_pose
from diffdrive_mj.calibration.paths import from_fixes, least_squares
from diffdrive_mj.drive import Drive
from diffdrive_mj.estimation.derivatives import Trajectory, trajectory


def test_a_pinned_pose_is_not_a_measurement():
    """Of a drive with M true poses, and of one with its ends alone: what is counted, and what the scale is of."""
    rng = np.random.default_rng(0)
    drives = [noisy(ideal(TRUE, rate=0.1), 1e-3, rng), ends(ideal(TRUE), 900)]
    poses = sum(len(drive.truth) for drive in drives)
    for start, pinned in (("estimated", 0), ("position", 2), ("truth", 3)):
        for headings, width in ((True, 3), (False, 2)):
            found = least_squares(drives, BELIEVED, start=start, headings=headings, turning_gain=False)
            assert len(found.residuals) == width * poses - 2 * min(pinned, width)


@pytest.mark.parametrize(
    "start",
    ["truth", pytest.param("position", marks=pytest.mark.slow), pytest.param("estimated", marks=pytest.mark.slow)],
)
def test_twenty_pairs_of_poses_have_no_outliers_and_true_deviations(start):
    """Half of the poses are pinned: counted as perfect measurements they made outliers of all the others."""
    rng, ratios, driven = np.random.default_rng(1), [], ideal(TRUE, mixed(period=0.1))
    for _ in range(12):
        drives = [noisy(ends(driven, int(rng.integers(60, 340))), 2e-3, rng) for _ in range(20)]
        found = least_squares(drives, BELIEVED, start=start, turning_gain=False)
        assert not any("sigma off" in warning for warning in found.warnings)
        assert found.details["position_residual_m"] < 0.02
        ratios.append((found.values - vector(TRUE)[:3]) / found.std)
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.4


@given(turn=numbers(-0.3, 0.3))
def test_a_first_heading_that_is_off_does_not_matter_where_it_is_estimated(turn):
    """Positions decide: the parameters are the same whatever the headings are."""
    drive = ideal(TRUE, rate=0.05, start=(1.0, -2.0, 0.5))
    turned = Drive(drive.t, drive.wheel_angles, drive.truth + np.array([0, 0, turn]), drive.clock)
    for found in (from_fixes([turned], BELIEVED, start="position"), from_fixes([turned], BELIEVED)):
        assert found.values == pytest.approx(vector(TRUE)[:3], rel=1e-6)
    if abs(turn) > 0.05:
        pinned = from_fixes([turned], BELIEVED, start="truth", anyway=True)
        assert np.abs(pinned.values / vector(TRUE)[:3] - 1).max() > 1e-3


def test_a_path_from_its_first_pose_is_one_that_starts_there():
    """And so are its derivatives, by the differences of `between` itself."""
    drive = ideal(TRUE, start=(3.0, 4.0, 1.0))
    late = Drive(drive.t, drive.wheel_angles, drive.truth[40::25], drive.t[40::25] - 0.003)
    parameters = vector(TRUE)
    path = from_first_pose(trajectory(late, parameters, 0.001))
    assert path.poses[0] == pytest.approx([0, 0, 0], abs=1e-15)
    assert path.by_parameters[:, 0] == pytest.approx(np.zeros((4, 3)), abs=1e-15)

    def poses(shift, offset):
        of = trajectory(late, parameters + shift, 0.001 - offset).poses
        return dd.se2.between(of[0], of)

    for row, step in zip(path.by_parameters, 1e-6 * np.eye(4), strict=True):
        assert row == pytest.approx((poses(step, 0) - poses(-step, 0)) / 2e-6, rel=1e-6, abs=1e-5)
    # Within one interval of the encoder odometry is as smooth by time as it is by the parameters.
    assert path.velocity == pytest.approx((poses(0, 1e-6) - poses(0, -1e-6)) / 2e-6, rel=1e-6, abs=1e-5)


def test_the_derivatives_by_the_first_pose():
    path = Trajectory(np.array([[0, 0, 0], [1.0, 2.0, 0.4]]), np.zeros((4, 2, 3)), np.zeros((2, 3)))
    pose, step = np.array([0.3, -0.7, 1.1]), 1e-6
    for k in range(3):
        up, down = (dd.se2.compose(pose + d, path.poses) for d in (step * np.eye(3)[k], -step * np.eye(3)[k]))
        assert by_first_pose(path, pose)[..., k] == pytest.approx((up - down) / (2 * step), abs=1e-9)


def test_a_pinned_start_finds_a_clock_offset_too():
    drive = ideal(TRUE, rate=0.2)
    late = Drive(drive.t, drive.wheel_angles, drive.truth[40:-5], drive.clock[40:-5] + 0.03)
    for start in FREE:
        found = least_squares([late], BELIEVED, start=start, clock_offset=True)
        assert found.details["clock_offset_s"] == pytest.approx(0.03, abs=2e-4)
        assert found.values == pytest.approx(vector(TRUE)[:3], rel=1e-4)


def test_a_robot_that_rests_has_no_heading_to_be_found():
    """Its positions alone leave the heading open, which is not an error: it takes none of the parameters."""
    still = Drive(np.arange(30.0), np.zeros((30, 2)), np.zeros((30, 3)), name="still")
    drives = [noisy(ideal(TRUE, rate=0.2), 1e-3, np.random.default_rng(0)), still]
    problem = Problem(drives, BELIEVED, start="position", clock_offset=False, headings=False)
    assert np.isfinite(problem.jacobian(vector(TRUE))).all()
    found = from_fixes(drives, BELIEVED, start="position")
    assert found.values == pytest.approx(vector(TRUE)[:3], rel=2e-3)


def test_logs_that_begin_in_motion_are_reported():
    drive = ideal(TRUE, rate=0.2)
    begun = Drive(drive.t[150:], drive.wheel_angles[150:], drive.truth[30:], drive.t[150:][::5], name="begun")
    speed = np.abs(np.diff(begun.wheel_angles[:2], axis=0) * [0.1, 0.1]).mean() / (begun.t[1] - begun.t[0])
    assert speed_at_first(begun, BELIEVED) == pytest.approx(speed, rel=0.05)
    assert speed_at_first(drive, BELIEVED) == 0
    (said,) = [w for w in least_squares([drive, begun], BELIEVED, start="truth").warnings if "begins while" in w]
    assert said.startswith(f"begun: the log begins while the robot drives at {speed_at_first(begun, BELIEVED):.2g} m/s")
    assert "start = position" in said
    for start in ("position", "estimated"):
        assert not any("begins" in w for w in least_squares([begun], BELIEVED, start=start).warnings)


@pytest.mark.parametrize("poses", [2, 3, 6])
@pytest.mark.parametrize("start", list(FREE))
def test_headings_with_a_degree_of_noise_are_not_called_perfect(start, poses):
    """Few drives with their ends alone, as by tape measure: that some headings fit exactly does not make them so."""
    rng, found, driven = np.random.default_rng(poses), [], ideal(TRUE, mixed(period=0.1))
    for _ in range(8):
        drives = [ends(driven, int(rng.integers(80, 340))) for _ in range(poses)]
        drives = [noisy(drive, np.array([1e-3, 1e-3, math.radians(1)]), rng) for drive in drives]
        details = least_squares(drives, BELIEVED, start=start, turning_gain=False, anyway=True).details
        found.append(details["heading_residual_rad"])
    assert math.radians(0.3) < np.median(found) < math.radians(3)
    assert min(found) > 1e-4


@given(offset=numbers(-0.2, 0.2))
def test_a_planted_clock_offset_comes_back_with_its_sign(offset):
    """The tracker's time minus the encoder's, wherever it is planted and wherever it is found."""
    drive = ideal(TRUE, mixed(period=0.05))
    seen = dd.Tracker(clock_offset=offset, sample_rate=10.0).read(drive.t[10:-10], drive.truth[10:-10])
    late = Drive(drive.t, drive.wheel_angles, seen.poses, seen.t)
    found = least_squares([late], BELIEVED, clock_offset=True)
    assert found.details["clock_offset_s"] == pytest.approx(offset, abs=1e-3)
    path = from_first_pose(trajectory(late, vector(TRUE), offset)).poses
    assert path == pytest.approx(dd.se2.between(late.truth[0], late.truth), abs=1e-4)


def test_the_first_pose_is_the_true_one_or_has_the_heading_of_the_way():
    """Wherever it is, and however wrong the measured headings are."""
    drive = ideal(TRUE, rate=0.05, start=(30.0, -20.0, 2.0))
    path = from_first_pose(trajectory(drive, vector(TRUE), 0.0))
    truth = drive.truth + np.array([0.0, 0.0, 0.3])
    assert first_pose(truth, path, laid_over=False).tolist() == truth[0].tolist()
    assert first_pose(truth, path, laid_over=True) == pytest.approx([30.0, -20.0, 2.0], abs=1e-9)
