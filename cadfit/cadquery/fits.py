"""Fits to points as CadQuery has them, and their options."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypedDict, Unpack

from cadquery.cq import VectorLike

from cadfit.cadquery.points import Points, as_array, in_one_space
from cadfit.fitting.approximate import Between, Corners, Effort, fit
from cadfit.fitting.result import Fit


class ProfileOptions(TypedDict, total=False):
    """The keywords of a closed profile; :meth:`Workplane.fitSpline` says what they do."""

    corners: Corners
    between: Between
    effort: Effort


class HowToFit(ProfileOptions, total=False):
    """Keywords that `cadfit.fit` and CadQuery's users call the same."""

    closed: bool | None


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


def fitted_profile(
    points: Points, tolerance: float, holes: Iterable[Points], **how: Unpack[ProfileOptions]
) -> tuple[Fit, ...]:
    """Return the closed fits to an outline and its holes; see :meth:`Workplane.fitProfile`."""
    found = [fit(as_array(points), tolerance, closed=True, **how)]
    for k, hole in enumerate(holes):
        try:
            found.append(fit(as_array(hole), tolerance, closed=True, **how))
        except ValueError as error:
            raise ValueError(f"hole {k}: {error}") from None
    return tuple(found)
