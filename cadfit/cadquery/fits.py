"""Fits to points as CadQuery has them, and their options."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypedDict, Unpack

import cadquery as cq
import numpy as np
from cadquery.cq import VectorLike

from cadfit.bezier import Array
from cadfit.cadquery.points import Points, as_array, curve_of, in_one_space
from cadfit.fitting.approximate import Between, Corners, Effort, fit
from cadfit.fitting.result import Fit
from cadfit.occt import CONFUSION, simplify
from cadfit.stages import Progress, shares


class ProfileOptions(TypedDict, total=False):
    """The keywords of a closed profile; :meth:`Workplane.fitSpline` says what they do."""

    corners: Corners
    between: Between
    effort: Effort
    progress: Progress | None


class HowToFit(ProfileOptions, total=False):
    """Keywords that `cadfit.fit` and CadQuery's users call the same."""

    closed: bool | None


class FitOptions(HowToFit, total=False):
    """The keywords of a fit; :meth:`Workplane.fitSpline` says what they do."""

    tangents: Sequence[VectorLike] | None


def fitted(
    points: Points, tolerance: float, tangents: Sequence[VectorLike] | Array | None = None, **how: Unpack[HowToFit]
) -> Fit:
    """Return the fit to points, or to an edge or wire, as CadQuery has them; see :meth:`Workplane.fitSpline`."""
    if (shape := curve_of(points)) is not None:
        return _refitted(shape, tolerance, tangents, how)
    given, ends = as_array(points), None
    if tangents is not None:
        given, ends = in_one_space(given, as_array(tangents))
    elif how.get("closed") is None and 0.0 < float(np.linalg.norm(given[-1] - given[0])) <= CONFUSION:
        how["closed"] = True  # one point to the kernel: open, the ends of a tube would pass through each other
    return fit(given, tolerance, end_tangents=ends, **how)


def _refitted(shape: cq.Edge | cq.Wire, tolerance: float, tangents: object, how: HowToFit) -> Fit:
    """Return the fit to an edge or wire, which says itself where it closes and where its corners are."""
    given = {"tangents": tangents is not None}
    given["closed"] = how.get("closed") not in (None, shape.IsClosed())
    given["corners"] = not isinstance(how.get("corners", "auto"), str)
    given["between"] = how.get("between", "curve") != "curve"
    if any(given.values()):
        option = next(name for name, strange in given.items() if strange)
        raise ValueError(f"a {shape.ShapeType()} is refitted as it is, within the tolerance all along: no {option}")
    effort, progress = how.get("effort", "best"), how.get("progress")
    return simplify(shape.wrapped, tolerance, effort=effort, progress=progress)


def fitted_profile(
    points: Points, tolerance: float, holes: Iterable[Points], **how: Unpack[ProfileOptions]
) -> tuple[Fit, ...]:
    """Return the closed fits to an outline and its holes; see :meth:`Workplane.fitProfile`."""
    outlines = [*holes]
    how["progress"], *others = shares(how.get("progress"), 1 + len(outlines))
    found = [fitted(points, tolerance, closed=True, **how)]
    for k, (hole, how["progress"]) in enumerate(zip(outlines, others, strict=True)):
        try:
            found.append(fitted(hole, tolerance, closed=True, **how))
        except ValueError as error:
            raise ValueError(f"hole {k}: {error}") from None
    return tuple(found)
