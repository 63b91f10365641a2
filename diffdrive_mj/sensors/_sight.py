"""What passive wheels cannot see: the motions that a linear law of their mountings maps to nothing, in words."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from diffdrive_mj._checks import Array

# What the law shows by less than this, of the motion or of the wheels' distance from the axle, it does not show: a
# mounting is no truer than that, and noise would come back a thousandfold.
_BLIND = 1e-3


def unseen(law: Array, spread: float, turn_known: bool, slides: bool) -> tuple[str, ...]:
    """The motions that wheels do not see.

    Args:
        law: (n, 3), how far each wheel rolls per motion ahead [m], to the left [m] and turn [rad].
        spread: the largest distance of a wheel from the axle's midpoint [m].
        turn_known: whether the turn is known otherwise.
        slides: whether the robot may move sideways.
    """
    straight, lever = law[:, : 1 + slides], law[:, 2]
    _, sizes, directions = np.linalg.svd(straight)
    sizes = np.pad(sizes, (0, len(directions) - len(sizes)))
    names = [_named(direction) for direction in directions[sizes < _BLIND]]
    if not turn_known:
        # The move that keeps the wheels still while the robot turns by one radian, if there is one.
        move, *_ = np.linalg.lstsq(straight, -lever, rcond=_BLIND)
        if np.abs(straight @ move + lever).max() <= _BLIND * spread:
            x, y = (-move[1] if slides else 0.0), move[0]
            names.append(f"a turn about ({_rounded(x):.3g}, {_rounded(y):.3g}) m")
    return tuple(names)


def cures(blind: Callable[[bool, bool], tuple[str, ...]], turn_known: bool, slides: bool) -> str:
    """What would let them see, one of several, where `blind(turn_known, slides)` names what they do not."""
    gyro, rigid = "the turn from a gyro (turn=...)", "slides=False for an axle that does not slide"
    helps = [cure for cure, known in ((gyro, (True, slides)), (rigid, (turn_known, False))) if not blind(*known)]
    if not helps and not blind(True, False):
        helps = [f"{gyro} with {rigid}"]
    return " or ".join([*helps, "a wheel mounted otherwise"])


def _named(direction: Array) -> str:
    """A straight move (1,) or (2,), which is the same backwards."""
    angle = math.degrees(math.atan2(direction[1], direction[0])) % 180 if len(direction) == 2 else 0.0
    if min(angle, 180 - angle) < 0.5:
        return "a move straight ahead"
    return "a slide to the side" if abs(angle - 90) < 0.5 else f"a slide along {angle:.3g} degrees to the left of ahead"


def _rounded(value: float) -> float:
    """Without the sign and the digits that rounding gives to zero."""
    return 0.0 if abs(value) < 1e-9 else float(value)
