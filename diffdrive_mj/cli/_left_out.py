"""Options that may be left out, as their help names them."""

from __future__ import annotations

from typing import Annotated

import tyro

from diffdrive_mj.world import World

Number = Annotated[float | None, tyro.conf.arg(metavar="FLOAT")]
Whole = Annotated[int | None, tyro.conf.arg(metavar="INT")]
Name = Annotated[str | None, tyro.conf.arg(metavar="NAME")]
WorldName = Annotated[str | None, tyro.conf.arg(metavar="WORLD")]


def floor(world: str | None, friction: float | None = None) -> World:
    """The world of a preset's name or of a TOML file, with another friction if that is given; ideal if neither is."""
    found = World() if world is None else World.load(world)
    return found if friction is None else found.replace(friction=friction)
