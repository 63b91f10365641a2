"""The two joints of a JointState that are the wheels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from diffdrive_mj._text import listed
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.logs._bag import Stamped

_SIDES = ("left", "right")


class Joints:
    """Keeps the positions of the wheels' joints from the messages of one topic.

    Messages without them are passed over: other joints may be published on the same topic.

    Args:
        path: of the bag.
        topic: of the messages.
        left: the left wheel's joint; None to find it by its name.
        right: the right wheel's.
        stamps: which count, as for `Stamped`.
    """

    def __init__(self, path: Path, topic: str, left: str | None, right: str | None, stamps: str) -> None:
        self._names: list[str | None] = [left, right]
        self._seen = Stamped(path, topic, 2, stamps)
        self._others: dict[str, None] = {}
        # The last message's names, and where the wheels are among them.
        self._last: list[str] | None = None
        self._where: tuple[int, int] | None = None

    def add(self, message: Any, stamp: int, number: int) -> None:
        """Keep the positions that a message has."""
        if message.name != self._last:
            self._last, self._where = message.name, self._found(message.name)
        if self._where is None:
            return
        left, right = self._where
        if len(message.position) <= max(left, right):
            raise InvalidValue(
                f"{self._seen.label}, message {number}: {len(message.position)} positions for {len(message.name)} "
                "joints: the wheels' angles are needed"
            )
        self._seen.add(message.header.stamp, stamp, number, (message.position[left], message.position[right]))

    def seen(self) -> Stamped:
        """What was kept.

        Raises:
            InvalidValue: nothing.
        """
        if not len(self._seen):
            wanted = " and ".join(repr(name or side) for name, side in zip(self._names, _SIDES, strict=True))
            raise InvalidValue(
                f"{self._seen.label}: no message has the joints {wanted}: choose Topics.left and Topics.right from "
                f"{listed(list(self._others)) or 'none'}"
            )
        return self._seen

    def _found(self, names: list[str]) -> tuple[int, int] | None:
        """Where the wheels are among a message's joints, if they are."""
        found = [
            name or _guessed(side, names, self._seen.label) for name, side in zip(self._names, _SIDES, strict=True)
        ]
        left, right = found
        if left not in names or right not in names or left is None or right is None:
            self._others |= dict.fromkeys(names)
            return None
        self._names = found
        return names.index(left), names.index(right)


def _guessed(side: str, names: list[str], label: str) -> str | None:
    """The only joint whose name has a side in it, or the only one of them that says that it is a wheel."""
    fit = [name for name in names if side in name.lower()]
    if len(fit) > 1:
        fit = [name for name in fit if "wheel" in name.lower()] or fit
    if len(fit) > 1:
        raise InvalidValue(f"{label}: {listed(fit)} may be the {side} wheel: name one, as in Topics({side}={fit[0]!r})")
    return fit[0] if fit else None
