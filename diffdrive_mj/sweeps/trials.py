"""What is known of the trials of a study: what varied, how each ended, and its figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diffdrive_mj._checks import Array

# How a trial ends: driven, tipped over, the physics broke down, or the robot cannot be.
OUTCOMES = ("ok", "fell", "diverged", "refused")


@dataclass(frozen=True, eq=False)
class Trials:
    """Hold the trials of a study, in their order.

    Attributes:
        index: (N,) of each trial in its study.
        drawn: what varied, by its name: (N,) numbers or strings.
        figures: what was kept, by its name: (N,) or (N, ...); not a number where the outcome is not "ok".
        outcome: (N,) "ok", "fell", "diverged" or "refused".
        why: (N,) what happened, in a line; empty where the outcome is "ok".

    Example:
        >>> Trials(np.arange(2), {}, {}, np.array(["ok", "fell"]), np.array(["", "it tipped over"]))
        Trials(2: 1 ok, 1 fell)
    """

    index: NDArray[np.int64]
    drawn: Mapping[str, NDArray[np.float64] | NDArray[np.str_]]
    figures: Mapping[str, Array]
    outcome: NDArray[np.str_]
    why: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.index)

    def __repr__(self) -> str:
        counted = {outcome: int((self.outcome == outcome).sum()) for outcome in OUTCOMES}
        return f"Trials({len(self)}: {', '.join(f'{count} {name}' for name, count in counted.items() if count)})"

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Which trials were driven to their end (N,)."""
        return self.outcome == "ok"


def joined(parts: Sequence[Trials]) -> Trials:
    """Put the trials of several chunks into one, in the order of their indices.

    Args:
        parts: at least one, of the same study.

    Example:
        >>> part = Trials(np.arange(2), {}, {}, np.array(["ok", "ok"]), np.array(["", ""]))
        >>> joined([part])
        Trials(2: 2 ok)
    """
    order = np.argsort(np.concatenate([part.index for part in parts]))

    def of(pick: str) -> NDArray[np.str_]:
        return np.concatenate([getattr(part, pick) for part in parts])[order]

    return Trials(
        np.concatenate([part.index for part in parts])[order],
        {name: np.concatenate([part.drawn[name] for part in parts])[order] for name in parts[0].drawn},
        {name: np.concatenate([part.figures[name] for part in parts])[order] for name in parts[0].figures},
        of("outcome"),
        of("why"),
    )
