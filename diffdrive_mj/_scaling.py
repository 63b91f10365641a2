"""What a robot leaves out scales from the reference robot, whose numbers models/README.md gives with their sources.

A robot that is s times as long, wide and high gets s^3 of the masses and s^5 of the inertia.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from diffdrive_mj._described import filled
from diffdrive_mj.parts import Caster, Motor, SkidSteer, Tyres

# The reference robot.
RADIUS = (0.100 + 0.091) / 2
TRACK = 0.400
BODY_MASS, WHEEL_MASS = 4.0, 0.3


def completed(mean_radius: float, track_width: float, given: Mapping[str, Any]) -> dict[str, Any]:
    """The sizes, masses and parts of a robot, those that it was given among them.

    Args:
        mean_radius: of its wheels [m].
        track_width: [m].
        given: the fields that the robot was given.
    """
    radius, track = mean_radius / RADIUS, track_width / TRACK
    volume = radius**2 * track
    wheelbase = given.get("skid_steer", SkidSteer()).wheelbase
    # A robot with skid steer has no caster: the reference robot's place for it is where its body ends.
    behind = -wheelbase / 2 if wheelbase else -0.2 * track
    tyres = filled(given.get("tyres", Tyres()), {"width": 0.04 * radius, "mass": WHEEL_MASS * volume})
    caster = filled(given.get("caster", Caster()), {"x": behind, "radius": 0.025 * radius})
    body_mass = given.get("body_mass", BODY_MASS * volume)
    mass = (body_mass + (4 if wheelbase else 2) * tyres.mass) / (BODY_MASS + 2 * WHEEL_MASS)
    return {
        "tyres": tyres,
        "caster": caster,
        "motor": filled(given.get("motor", Motor()), {"rotor_inertia": 0.01 * mass * radius**2}),
        "body_mass": body_mass,
        "center_of_mass_x": given.get("center_of_mass_x", 0.0 if wheelbase else 0.3 * caster.x),
        "center_of_mass_height": given.get("center_of_mass_height", 0.08 * radius),
    }
