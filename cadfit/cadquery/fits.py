"""Fits to points as CadQuery has them, and their options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict, Unpack

from cadquery.cq import VectorLike

from cadfit.cadquery.points import Points, as_array, in_one_space
from cadfit.fitting.approximate import Between, Corners, Effort, fit
from cadfit.fitting.result import Fit


class HowToFit(TypedDict, total=False):
    """Keywords that `cadfit.fit` and CadQuery's users call the same."""

    closed: bool | None
    corners: Corners
    between: Between
    effort: Effort


class FitOptions(HowToFit, total=False):
    """The keywords of a fit; :meth:`Workplane.fitSpline` says what they do."""

    tangents: Sequence[VectorLike] | None


def fitted(
    points: Points, tolerance: float, tangents: Sequence[VectorLike] | None = None, **how: Unpack[HowToFit]
) -> Fit:
    """Return the fit to points as CadQuery has them; see :meth:`Workplane.fitSpline`."""
    if tangents is None:
        return fit(as_array(points), tolerance, **how)
    given, ends = in_one_space(as_array(points), as_array(tangents))
    return fit(given, tolerance, end_tangents=ends, **how)
