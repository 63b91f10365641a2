"""Wheels that were logged within one turn, in every format, and what must not be taken for them."""

import bags
import numpy as np
import pytest

from diffdrive_mj import logs
from diffdrive_mj.logs import Columns, Entries
from diffdrive_mj.logs._wheels import wrapped

T = np.arange(60) * 0.05
TURNED = np.stack([7 * T, -9 * T], axis=-1)
BOTH = tuple(f"the {side} wheel looks wrapped: its angle must go on past a turn, and jumps within one"
             for side in ("left", "right"))  # fmt: skip


def signed(angles):
    return np.arctan2(np.sin(angles), np.cos(angles))


def unsigned(angles):
    return np.mod(angles, 2 * np.pi)


def read_csv(tmp_path, angles, unit="radians"):
    rows = "".join(f"{t!r},{a!r},{b!r},{t!r},0,0\n" for t, (a, b) in zip(T.tolist(), angles.tolist(), strict=True))
    (tmp_path / "a.csv").write_text("t,left,right,x,y,theta\n" + rows)
    return logs.read(tmp_path / "a.csv", Columns(wheel_unit=unit))


def read_bag(tmp_path, angles):
    joints = [bags.joints(t, *both) for t, both in zip(T, angles, strict=True)]
    return logs.read(
        bags.write(tmp_path / f"{abs(angles).max():.0f}.mcap", {"/j": joints, "/gt": [bags.stamped(t, t) for t in T]})
    )


def read_data_log(tmp_path, angles):
    kinds = {"left": "double", "right": "double", "pose": "struct:Pose2d"}
    content = [row for k, (a, b) in enumerate(angles.tolist())
               for row in (("left", 50_000 * k, a), ("right", 50_000 * k, b),
                           ("pose", 50_000 * k, (1.0 * k, 0.0, 0.0)))]  # fmt: skip
    return logs.read(bags.wpilog(tmp_path / "a.wpilog", kinds, content), Entries())


@pytest.mark.parametrize("read", [read_csv, read_bag, read_data_log])
@pytest.mark.parametrize("wrap", [signed, unsigned])
def test_wrapped_wheels_are_reported_and_others_are_not(tmp_path, read, wrap):
    assert read(tmp_path, wrap(TURNED)).warnings == BOTH
    assert read(tmp_path, TURNED).warnings == ()


def test_units_and_sides(tmp_path):
    degrees = np.degrees(np.stack([unsigned(TURNED[:, 0]), TURNED[:, 1]], axis=-1))
    assert read_csv(tmp_path, degrees, "degrees").warnings == BOTH[:1]
    assert read_csv(tmp_path, degrees / 360, "rotations").warnings == BOTH[:1]
    # Ticks wrap at the counter's bits, which have an option; a metre is no turn.
    assert wrapped(unsigned(TURNED).T, "ticks") == wrapped(unsigned(TURNED).T, "metres") == ()


def test_a_few_sparse_samples_may_be_half_a_turn_apart():
    sparse = np.array([0.0, 3.5, 6.0, 2.0])
    assert wrapped((sparse, sparse), "radians") == ()
    swinging = 3.0 * np.sin(3 * T)
    assert wrapped((swinging, swinging), "radians") == ()
