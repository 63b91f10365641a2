"""From what was drawn to trials: the robots, worlds and sensors that are driven, or why they cannot be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from diffdrive_mj.commands import Commands
from diffdrive_mj.errors import DiffdriveError
from diffdrive_mj.robot import Robot
from diffdrive_mj.sweeps._varied import Drawn, variations
from diffdrive_mj.sweeps.making import Trial
from diffdrive_mj.sweeps.named_maneuvers import Maneuver


def made_trials(owners: Mapping[str, Any], index: range, drawn: Drawn) -> tuple[list[Trial], dict[int, DiffdriveError]]:
    """Make trials of what was drawn; what is equal in several of them is one object, and computed once.

    Args:
        owners: robot, believed robot, maneuver, world, encoder and gyro as designed, by these names.
        index: of the trials (N).
        drawn: the values (N,) of what varies, by its name.

    Returns:
        The trials that can be; and by index the errors that say why the others cannot.
    """
    varied = {owner: variations(owner, base, drawn, len(index)) for owner, base in owners.items()}
    commands: dict[tuple[int, int], Commands | DiffdriveError] = {}
    trials, refused = [], {}
    for k, number in enumerate(index):
        parts = {owner: values[k] for owner, values in varied.items()}
        wrong = next((part for part in parts.values() if isinstance(part, DiffdriveError)), None)
        if wrong is None:
            driver, believed = parts.pop("maneuver"), parts["believed"]
            if (id(driver), id(believed)) not in commands:
                commands[id(driver), id(believed)] = _told(driver, believed)
            told = commands[id(driver), id(believed)]
            if isinstance(told, Commands):
                trials.append(Trial(number, commands=told, **parts))
                continue
            wrong = told
        refused[number] = wrong
    return trials, refused


def _told(driver: Maneuver, believed: Robot) -> Commands | DiffdriveError:
    """The commands, or why there are none."""
    try:
        return driver.commands(believed)
    except DiffdriveError as error:
        return error
