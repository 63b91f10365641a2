"""The checks of a study's fields: what is made of mappings, and what no study can have."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from diffdrive_mj import _checks as checks
from diffdrive_mj._text import shown
from diffdrive_mj.errors import InvalidType, InvalidValue, UnknownName
from diffdrive_mj.solver import Physics
from diffdrive_mj.sweeps import _varied
from diffdrive_mj.sweeps._assembly import made_trials
from diffdrive_mj.sweeps.choices import Choice, Grid
from diffdrive_mj.sweeps.distributions import Distribution, distribution

T = TypeVar("T")

# Settings of the physics by name.
PHYSICS = {
    "fast": Physics.fast(),
    "default": Physics(),
    "sliding": Physics.sliding(),
    "skidding": Physics.skidding(),
    "mujoco_defaults": Physics.mujoco_defaults(),
}
# What a file says for None, where None is not what is left out.
NONE = "none"


def made(kind: type[T], name: str, value: object, **beside: Any) -> T | None:
    """A description of some kind, as it is or of a mapping of its fields; None stays so."""
    if value is None:
        return None
    if not isinstance(value, Mapping):
        return checks.instance(name, value, kind)
    known = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]
    for key in value:
        if key not in known:
            raise UnknownName(f"{kind.__name__} field", key, known)
    return kind(**beside, **value)


def physics(name: str, value: object) -> Physics:
    """How the drives are solved: as it is, by the name of a setting, or by a mapping of its fields."""
    if isinstance(value, str):
        return checks.one_of("physics", value, PHYSICS)
    if isinstance(value, Mapping):
        value = {key: None if item == NONE else item for key, item in value.items()}
    return checks.instance(name, made(Physics, name, value), Physics)


def spreads(name: str, value: object) -> dict[str, Distribution]:
    """Distributions by what varies, in the order of the names; names may be nested, as TOML's dotted keys are."""
    if not isinstance(value, Mapping):
        raise InvalidType(f"{name} = {shown(value)}: must be a mapping from what varies to a distribution")
    return {key: distribution(f"{name}[{shown(key)}]", spread) for key, spread in sorted(_flat(value))}


def _flat(values: Mapping[str, Any], owner: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping) and "distribution" not in value:
            yield from _flat(value, f"{owner}{key}.")
        else:
            yield f"{owner}{key}", value


def refuse_trials(trials: int, design: str, grids: Mapping[str, int]) -> None:
    """Refuse a number of trials that the grids or the design do not divide."""
    each = math.prod(max(size, 1) for size in grids.values())
    what = f"the {each} combinations of the grids"
    if design == "saltelli":
        if not grids or any(grids.values()):
            raise InvalidValue(
                "Study.design = 'saltelli': needs something that varies, and no Grid; Choice takes its place"
            )
        each = len(grids) + 2
        what = f"D + 2 = {each}, where D = {len(grids)} numbers vary and the design is 'saltelli'"
    if trials % each:
        low = trials // each * each
        near = f"{low} or {low + each}" if low else f"{each}"
        raise InvalidValue(f"Study.trials = {trials}: must be a multiple of {what}, such as {near}")


def refuse_impossible(owners: Mapping[str, Any], vary: Mapping[str, Distribution]) -> None:
    """Refuse what cannot vary, and what varies about something or takes a listed value that cannot be."""
    owners["maneuver"].commands(owners["believed"])
    for name in vary:
        _refuse_unknown(name, owners)
    _refuse_twice(tuple(vary))
    middle = {name: spread.at([0.5])[0] for name, spread in vary.items()}
    listed = {name: spread.values for name, spread in vary.items() if isinstance(spread, Choice | Grid)}
    rows = [middle] + [{**middle, name: value} for name, values in listed.items() for value in values]
    drawn = {name: np.asarray([row[name] for row in rows]) for name in middle}
    for error in made_trials(owners, range(len(rows)), drawn)[1].values():
        if isinstance(error, UnknownName):
            raise error
        raise type(error)(f"Study.vary: {error}")


def _refuse_unknown(name: str, owners: Mapping[str, Any]) -> None:
    """Refuse what cannot vary, and say what can: of its owner, or by that name."""
    owner, known = name.split(".", maxsplit=1)[0], _varied.names(owners)
    if owners.get(owner, ...) is None:
        raise InvalidValue(f"Study.vary: {name}: the study has no {owner}; give it one")
    near = [each for each in known if each.startswith(f"{owner}.") or each.endswith(f".{name}")]
    if not near:  # as with "physics.timestep", which is the same in every trial
        raise UnknownName("owner of what varies", owner, owners)
    if name not in known:
        raise UnknownName("name of what varies", name, near)


def _refuse_twice(varied: Sequence[str]) -> None:
    """Refuse radii that vary in two ways at once."""
    for owner in ("robot", "believed"):
        sides, causes = (
            [f"{owner}.{field}" for field in pair if f"{owner}.{field}" in varied]
            for pair in (_varied.RADII, _varied.CAUSES)
        )
        if sides and causes:
            raise InvalidValue(
                f"Study.vary: {sides[0]} and {causes[0]}: must be the two radii, or their mean and their ratio"
            )
