"""Where results come from: the command, its options, the versions that computed them, and when."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from os import PathLike, fspath
from typing import Any

from diffdrive_mj import __version__
from diffdrive_mj import _checks as checks

# What the numbers of a result depend on.
_PACKAGES = ("mujoco", "numpy", "scipy")


def provenance(command: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """What it takes to get a result again, as `metrics.json` holds it.

    Args:
        command: as one types it; "" where none is known.
        options: by name.

    Raises:
        InvalidType: a command that is not a string.
    """
    return {
        "command": checks.string("command", command),
        "options": {
            str(name): fspath(value) if isinstance(value, PathLike) else value for name, value in options.items()
        },
        "versions": {"diffdrive_mj": __version__, **_versions(), "python": platform.python_version()},
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _versions() -> dict[str, str]:
    found = {}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # vendored, without its metadata
            found[package] = "unknown"
    return found
