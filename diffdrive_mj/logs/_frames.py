"""Poses from transforms between frames: one of them, or a chain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from diffdrive_mj import se2
from diffdrive_mj._checks import Array
from diffdrive_mj._text import listed
from diffdrive_mj.errors import InvalidValue
from diffdrive_mj.logs._bag import Handler, Stamped, seven
from diffdrive_mj.pose_log import PoseLog
from diffdrive_mj.sensors._sampling import poses_between

Pair = tuple[str, str]


class Transforms:
    """Keeps the transforms that the messages of a bag hold, each pair of frames by itself.

    Args:
        path: of the bag.
        frame: the parent whose child's poses are wanted; None where there is only one that fits.
        child: that child; None where there is only one that fits.
        stamps: which count, as for `Stamped`.
    """

    def __init__(self, path: Path, frame: str | None, child: str | None, stamps: str) -> None:
        self._path, self._frame, self._child, self._stamps = path, frame, child, stamps
        self._seen: dict[Pair, Stamped] = {}
        self._static: dict[Pair, bool] = {}
        self.what = ""

    def handler(self, topic: str, static: bool) -> Handler:
        """What keeps the messages of a topic, of transforms that move or of static ones."""

        def handler(message: Any, stamp: int, number: int) -> None:
            for each in message.transforms:
                pair = (each.header.frame_id, each.child_frame_id)
                if pair not in self._seen:
                    self._seen[pair] = Stamped(self._path, f"{topic}, {pair[0]} -> {pair[1]}", 7, self._stamps)
                    self._static[pair] = static
                numbers = seven(each.transform.translation, each.transform.rotation)
                self._seen[pair].add(each.header.stamp, stamp, number, numbers)

        return handler

    def log(self) -> PoseLog:
        """The poses of the child frame in the parent."""
        edges: list[Edge] = []
        warnings: list[str] = []
        way = chain(self._static, self._frame, self._child, self._path)
        self.what = f"{way[0][0]} -> {way[-1][1]}"
        for pair in way:
            seen = self._seen[pair]
            # A static transform holds at all times; the last counts: it is published again where it was wrong.
            t, poses, said = seen.last().poses(least=1) if self._static[pair] else seen.poses(least=1)
            edges.append(Edge(t, poses))
            warnings += said
        t, poses = composed(edges, self._path)
        return PoseLog(t, poses, str(self._path), tuple(warnings))


@dataclass(frozen=True)
class Edge:
    """The transform of a child frame in its parent: poses (N, 3) at times (N,) [s], or one for all times."""

    t: Array
    poses: Array


def chain(pairs: Mapping[Pair, bool], frame: str | None, child: str | None, path: Path) -> list[Pair]:
    """The transforms from a frame to a child of it, the frame's first.

    Args:
        pairs: parent and child of every transform, and whether it is static.
        frame: the parent; None where there is only one that fits.
        child: the child; None where there is only one that fits.
        path: of the log, for the message.

    Raises:
        InvalidValue: several that fit, none, or no chain of them.
    """
    if frame is not None and child is not None:
        if found := _upwards(list(pairs), child, frame, ()):
            return found
        raise InvalidValue(f"{path}: no transforms from {frame!r} to {child!r}: there are {_listed(list(pairs))}")
    if not pairs:
        raise InvalidValue(f"{path}: its messages hold no transforms")
    moving = [pair for pair, static in pairs.items() if not static]
    fit = [pair for pair in moving if frame in (None, pair[0]) and child in (None, pair[1])]
    if len(fit) == 1:
        return fit
    what = "none" if not fit else "several"
    raise InvalidValue(
        f"{path}: {what} of the transforms {_listed(fit or list(pairs))} may be meant: name two frames, as in "
        "Topics(frame='odom', child_frame='base_link')"
    )


def _upwards(pairs: list[Pair], child: str, frame: str, seen: tuple[str, ...]) -> list[Pair]:
    """The way from a child up to a frame, as `chain` returns it; nothing if there is none."""
    for parent, below in pairs:
        if below == child and parent not in seen:
            if parent == frame:
                return [(parent, below)]
            if above := _upwards(pairs, parent, frame, (*seen, child)):
                return [*above, (parent, below)]
    return []


def composed(edges: list[Edge], path: Path) -> tuple[Array, Array]:
    """The poses along a chain, at the times of whichever of its transforms has the most.

    Returns:
        Times (N,) [s] at which all of them are known, and poses (N, 3).

    Raises:
        InvalidValue: nothing in it moves, or at no time all are known.
    """
    moving = [edge for edge in edges if len(edge.t) > 1]
    if not moving:
        raise InvalidValue(f"{path}: nothing between these frames moves")
    t = max((edge.t for edge in moving), key=len)
    first, last = max(edge.t[0] for edge in moving), min(edge.t[-1] for edge in moving)
    t = t[(t >= first) & (t <= last)]
    if len(t) < 2:
        raise InvalidValue(f"{path}: at {len(t)} times all transforms between these frames are known: must be two")
    poses = np.zeros((len(t), 3))
    for edge in edges:
        here = edge.poses[0] if len(edge.t) == 1 else poses_between(edge.t, edge.poses, t)
        poses = se2.compose(poses, here)
    return t, poses


def _listed(pairs: list[Pair]) -> str:
    return listed([f"{parent} -> {child}" for parent, child in pairs])
