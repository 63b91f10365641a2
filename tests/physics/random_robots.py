"""Robots of all sizes that nobody has chosen."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

import diffdrive_mj as dd
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.physics.model import compile_model


def random_robots(
    count: int, seed: int, *, ratios: tuple[float, float] = (0.8, 1.25), axles: Sequence[str] = ()
) -> list[dd.Robot]:
    """Robots of 0.3 to 80 kg, wheels of 2 to 25 cm, that stand; on independent axles if not said otherwise."""
    generator = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(math.log(low), math.log(high))))

    found: list[dd.Robot] = []
    while len(found) < count:
        radius, ratio, track = between(0.02, 0.25), generator.uniform(*ratios), between(0.08, 1.2)
        mean = radius * (1 + ratio) / 2
        caster = -generator.uniform(0.3, 0.7) * track
        axle = {"axle": str(generator.choice(axles))} if axles else {}
        try:
            robot = dd.Robot(
                left_radius=radius,
                right_radius=radius * ratio,
                track_width=track,
                **axle,
                body_mass=between(0.3, 80.0),
                center_of_mass_x=caster * generator.uniform(0.15, 0.6),
                center_of_mass_height=mean * generator.uniform(0.5, 1.2),
                caster={"x": caster, "radius": 0.25 * mean},
            )
            compile_model(robot)
        except DiffdriveError:
            continue
        found.append(robot)
    return found
