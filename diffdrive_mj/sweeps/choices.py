"""Distributions over a few values: chosen at random, or run through one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from diffdrive_mj import _checks as checks
from diffdrive_mj._described import checked, described
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue
from diffdrive_mj.sweeps._shares import shares

Value = float | str | bool


def _values(name: str, values: Any) -> tuple[Value, ...]:
    """Numbers, strings or booleans, not some of each."""
    if isinstance(values, (str, dict)):
        raise InvalidType(f"{name} = {shown(values)}: must be a list of values")
    found = [value.item() if isinstance(value, np.generic) else value for value in checks.several(name, values)]
    if not found:
        raise InvalidValue(f"{name} is empty: must have at least one value")
    if any(isinstance(value, int) and abs(value) >= 2**63 for value in found):
        raise InvalidValue(f"{name} = {shown(values)}: whole numbers must be below 2^63 in size")
    if any(all(type(value) is kind for value in found) for kind in (bool, str, int)):
        return tuple(found)
    if any(isinstance(value, (bool, str)) for value in found):
        raise InvalidType(f"{name} = {shown(values)}: must be all numbers, all strings, or all True or False")
    return tuple(checks.number(name, value) for value in found)


def _weights(name: str, weights: Any) -> tuple[float, ...] | None:
    return None if weights is None else tuple(checks.positive(name, w) for w in checks.several(name, weights))


@described()
@dataclass(frozen=True, kw_only=True)
class Choice:
    """Choose one of a few values at random.

    Args:
        values: numbers, strings or booleans.
        weights: how often each is chosen, as parts of their sum; None for equally often.

    Raises:
        InvalidValue: no values, weights that are not positive, or another number of them.
        InvalidType: values of several kinds.
        UnknownName: a field that the distribution does not have.

    Example:
        A batch in which every fourth robot has the old tyres:

        >>> tyres = dd.sweeps.Choice(values=("crowned", "cylinder"), weights=(3, 1))
        >>> tyres.at([0.1, 0.7, 0.8]).tolist()
        ['crowned', 'crowned', 'cylinder']
    """

    values: Sequence[Value] = field(metadata=checked(_values))
    weights: Sequence[float] | None = field(default=None, metadata=checked(_weights))

    def __post_init__(self) -> None:
        if self.weights is not None and len(self.weights) != len(self.values):
            raise InvalidValue(f"Choice: {len(self.weights)} weights of {len(self.values)} values: must be as many")

    def at(self, share: ArrayLike) -> NDArray[Any]:
        """Return the values (...) at shares (...) from zero to one, in the order in which they were given."""
        up_to = np.cumsum(np.ones(len(self.values)) if self.weights is None else self.weights)
        return _picked(self.values, np.searchsorted(up_to / up_to[-1], shares(share), side="right"))


@described()
@dataclass(frozen=True, kw_only=True)
class Grid:
    """Run through some values, one after the other; of several grids a study drives every combination equally often.

    Args:
        values: numbers, strings or booleans.

    Raises:
        InvalidValue: no values.
        InvalidType: values of several kinds.
        UnknownName: a field that the distribution does not have.

    Example:
        >>> dd.sweeps.Grid(values=(20.0, 50.0, 100.0)).at([0.1, 0.5, 0.9]).tolist()
        [20.0, 50.0, 100.0]
    """

    values: Sequence[Value] = field(metadata=checked(_values))

    def at(self, share: ArrayLike) -> NDArray[Any]:
        """Return the values (...) at shares (...) from zero to one, each of them over an equal part."""
        return _picked(self.values, np.floor(shares(share) * len(self.values)).astype(int))


def _picked(values: Sequence[Value], place: NDArray[np.intp]) -> NDArray[Any]:
    """The values at some places; a share of one is the last."""
    return np.asarray(values)[np.clip(place, 0, len(values) - 1)]
