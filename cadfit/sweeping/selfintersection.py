"""What is said of a sweep that passes through itself: bends tighter than the profile, corners, parts that touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from cadfit.bezier import Array


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """A place where a sweep passes through itself.

    `kind`: "bend" (the path bends more tightly than the profile reaches), "cusp" (it turns on the spot), "corner" (a
    leg is too short for its mitres) or "near" (distant parts touch). `parameter` and `position` (3,) are on the path.
    `reach`: how far the profile reaches there, a tube's radius; `largest`: the reach that would do, 0.0 where none
    does. `other`: the parameter of the other part that touches, or of the leg's end.
    """

    kind: Literal["bend", "cusp", "corner", "near"]
    parameter: float
    position: Array
    reach: float
    largest: float
    other: float | None = None

    def said(self, what: str) -> str:
        """Return the line to say of it, where `what` is what the reach is called: "radius" or "reach"."""
        place = ", ".join(f"{value:g}" for value in np.round(self.position, 12) + 0.0)
        why = {
            "bend": f"the path bends there with a radius of {self.largest:.4g}, below the {what} of {self.reach:g}",
            "cusp": f"the path turns there on the spot, with a radius of 0, below the {what} of {self.reach:g}",
            "corner": f"the leg that starts there is too short for its mitres at a {what} of {self.reach:g}",
            "near": f"the part at the parameter {self.other or 0.0:g} is too near for a {what} of {self.reach:g}",
        }[self.kind]
        remedy = f"a {what} below {self.largest:.4g} would do" if self.largest > 0.0 else f"so no {what} would do"
        return f"it passes through itself at the parameter {self.parameter:g}, near ({place}): {why}; {remedy}"


class SelfIntersectionError(ValueError):
    """A sweep passes through itself and was asked to say so: `crossings` are where."""

    def __init__(self, crossings: list[Crossing], line: str) -> None:
        super().__init__(line)
        self.crossings = crossings


class SelfIntersectionWarning(UserWarning):
    """A sweep passes through itself; the mesh is as asked for, closed, and wrong there."""
