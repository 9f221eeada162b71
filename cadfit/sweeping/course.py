"""The course of a sweep: a path's legs between corners, and how the frames of each are turned so that they meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.sweeping.corners import carried_over, legs_between
from cadfit.sweeping.frames import Frames, frames


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A corner of a path: its `parameter`, and whether it is to be mitred; else the profile turns there on the spot."""

    parameter: float
    mitred: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A path's `legs` between its `joints`, with frames that run on from leg to leg.

    The frames of leg k are those of `cadfit.frames` (with `up`, where that is not None) turned by the angle `rolls[k]`
    and by `spread` for each unit of length; `started[k]` is the length of the path before it. `closed`: the path ends
    where it starts, in a corner if `seam_is_corner`.
    """

    legs: list[BSpline]
    joints: list[Joint]
    up: Array | None
    closed: bool
    seam_is_corner: bool
    rolls: list[float]
    spread: float
    started: Array

    @property
    def steady(self) -> bool:
        """Whether nothing turns but what the path's bends turn."""
        return self.up is None and not self.spread and not (self.closed and not self.joints)

    def at(self, leg: int, u: Array) -> tuple[Frames, Array]:
        """Return the frames of a leg at parameters u (n,), and the angles (n,) by which they are to be turned."""
        f = frames(self.legs[leg], u, self.up)
        return f, self.rolls[leg] + self.spread * f.lengths


def course_of(path: BSpline, joints: list[Joint], up: Array | None) -> Course:
    """Return the course of a path in three dimensions between its corners, rising.

    Raises ValueError where `up` (3,) or None, and a corner, ask for different frames, and as `frames` does.
    """
    legs = legs_between(path, np.array([joint.parameter for joint in joints]))
    seam_is_corner = bool(joints) and joints[-1].parameter == path.domain[1]
    along = [frames(leg, np.array(leg.domain), up) for leg in legs]
    rolls, spread = _rolls(along, path.closed, seam_is_corner, up)
    started = np.concatenate([[0.0], np.cumsum([f.lengths[-1] for f in along])])
    return Course(legs, joints, up, path.closed, seam_is_corner, rolls, spread, started)


def _rolls(along: list[Frames], closed: bool, seam_is_corner: bool, up: Array | None) -> tuple[list[float], float]:
    """Return the angle by which each leg's frames are to be turned, and the turn for each unit of length.

    The normal is carried over corners by the smallest turn. What a closed path with corners misses its start by is
    spread along it.
    """
    rolls = [0.0]  # the first leg's
    for before, after in zip(along[:-1], along[1:], strict=True):
        rolls.append(_roll_over(before, after, rolls[-1]))
    if up is not None:
        if np.abs(np.exp(1j * np.array(rolls)) - 1.0).max() > 1e-6:
            k = int(np.argmax(np.abs(np.exp(1j * np.array(rolls)) - 1.0) > 1e-6))
            x, y, z = along[k].origins[0]
            raise ValueError(
                f"with `up` the profile would roll by {np.degrees(rolls[k]):.4g} degrees at the corner near "
                f"({x:.6g}, {y:.6g}, {z:.6g}): no mitre joins that; leave `up` out or round the corner"
            )
        return [0.0] * len(along), 0.0
    if not closed or (len(along) == 1 and not seam_is_corner):
        return rolls, 0.0
    missed = _roll_over(along[-1], along[0], rolls[-1])
    missed = float(np.angle(np.exp(1j * missed)))
    total = sum(float(f.lengths[-1]) for f in along)
    spread, started = -missed / total, 0.0
    if abs(missed) < 1e-12:
        return rolls, 0.0
    for k, f in enumerate(along):
        rolls[k] += spread * started
        started += float(f.lengths[-1])
    return rolls, spread


def _roll_over(before: Frames, after: Frames, roll: float) -> float:
    """Return the angle from the normal of the next leg's start to the one carried over from a leg turned by `roll`."""
    normal = np.cos(roll) * before.normals[-1] + np.sin(roll) * before.binormals[-1]
    carried = carried_over(normal, before.tangents[-1], after.tangents[0])
    return float(np.arctan2(carried @ after.binormals[0], carried @ after.normals[0]))
