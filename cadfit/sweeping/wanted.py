"""What is wanted of a sweep, checked, and how what it finds is told."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from cadfit.bspline import BSpline
from cadfit.joining import join
from cadfit.numbers import as_number, rounded_up
from cadfit.points.clean import LARGEST
from cadfit.stages import Progress, unheard
from cadfit.sweeping.frames import lifted
from cadfit.sweeping.selfintersection import Crossing, SelfIntersectionError, SelfIntersectionWarning

Caps = Literal["flat", "round", "none"]
OnSelfIntersection = Literal["raise", "warn", "repair"]

_FINEST = 64.0 * np.finfo(np.float64).eps  # of the largest coordinate: no tolerance can be finer


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is wanted of a sweep: see `sweep`. `what` is what messages call the reach."""

    tolerance: float
    caps: Caps
    on_self_intersection: OnSelfIntersection
    texture: bool = False
    what: str = "reach"
    progress: Progress = unheard

    def check(self, path: BSpline, reach: float) -> None:
        """Raise ValueError for choices there are not, and for a tolerance finer than the numbers are."""
        for name, choices in (("caps", Caps), ("on_self_intersection", OnSelfIntersection)):
            if getattr(self, name) not in get_args(choices):
                known = ", ".join(get_args(choices))
                raise ValueError(f"{name} must be one of {known}, not {getattr(self, name)!r}")
        least = _FINEST * (float(np.abs(path.poles).max()) + reach)
        if self.tolerance < least:
            raise ValueError(
                f"the tolerance {self.tolerance:g} is below what numbers of this size hold: {rounded_up(least)} or more"
            )

    def tell(self, found: list[Crossing]) -> None:
        """Raise or warn of crossings, or leave it to the repair."""
        if not found or self.on_self_intersection == "repair":
            return
        line = found[0].said(self.what) + (f" (and {len(found) - 1} more)" if found[1:] else "")
        if self.on_self_intersection == "raise":
            raise SelfIntersectionError(found, line)
        warnings.warn(SelfIntersectionWarning(line), stacklevel=4)


def path_of(path: Any) -> BSpline:
    """Return the path of a spline, a fit or several curves as one B-spline in three dimensions."""
    several = isinstance(path, (list, tuple)) or hasattr(path, "curves")
    return lifted(join(path) if several else path)


def positive(value: Any, name: str) -> float:
    """Return a number as a float; raises TypeError for what is none, ValueError unless it can be squared."""
    number = as_number(value, name)
    if not (math.isfinite(number) and number > 0.0):
        raise ValueError(f"the {name} must be finite and above zero, not {number:g}")
    if not 1.0 / LARGEST < number < LARGEST:  # squares and their products
        raise ValueError(f"the {name} must be between {1.0 / LARGEST:g} and {LARGEST:g}, not {number:g}")
    return number
