"""What a fit is: the curves, how far they are from the points, and what was done."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.deviation import Deviation
from cadfit.stages import Progress

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Fit:
    """Curves fitted to points: C2 splines with simple interior knots, joined end to end to the last bit.

    `curves`: one for each stretch between corners, their parameters running on from one to the next. `deviation`:
    certified upper bounds, in the caller's unit. `tolerance`: what was asked for; None where the number of poles was.
    `closed`: the last curve ends where the first starts. `points` (n, d): the points used. `parameters` (n,): their
    places on the curves; where closed, they start again at the start of the first curve where the points pass it.
    `corners`: rows of `points`, rising, where the curve may turn sharply; each lies on the curve exactly. `cleaned`:
    the caller's rows that repeated the row before them and were dropped. `between`: what the tolerance means between
    points, "curve" or "polyline"; None without one. `call`: the call that made the fit, the caller's points named
    `points`; empty where unknown.
    """

    curves: tuple[BSpline, ...]
    deviation: Deviation
    tolerance: float | None
    closed: bool
    points: Array
    parameters: Array
    corners: Ints
    cleaned: Ints
    between: str | None = None
    call: str = ""

    def __post_init__(self) -> None:
        for rows in (self.corners, self.cleaned):
            rows.setflags(write=False)

    def __repr__(self) -> str:
        far = max(self.deviation.points, self.deviation.between)
        kind = "closed" if self.closed else "open"
        curves = f"{len(self.curves)} curve{'s'[: len(self.curves) > 1]}"
        return f"Fit({kind}, {curves}, {self.poles} poles for {len(self.points)} points, deviation {far:.3g})"

    def _repr_html_(self) -> str:
        from cadfit.report.notebook import html_of_fit

        return html_of_fit(self)

    def __reduce__(self) -> tuple[Callable[..., Fit], tuple[Any, ...]]:
        return _again, tuple(getattr(self, field.name) for field in fields(self))

    @property
    def dimension(self) -> int:
        """The number of coordinates."""
        return int(self.points.shape[1])

    @property
    def poles(self) -> int:
        """The number of poles of all curves, each curve's ends counted with it."""
        return sum(len(curve.poles) for curve in self.curves)

    @property
    def spline(self) -> BSpline:
        """The one curve.

        Raises ValueError when corners made several: see `curves`, or `cadfit.join`, which makes one with triple knots.
        """
        if len(self.curves) > 1:
            raise ValueError(
                f"the fit has {len(self.curves)} curves, split at {len(self.corners)} corners: use .curves, "
                "cadfit.join(fit.curves), or corners=None"
            )
        return self.curves[0]

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw points, curves, poles and corners through matplotlib (see `cadfit.plotting.plot_fit`)."""
        from cadfit.plotting import plot_fit

        return plot_fit(self, ax, **options)

    def plot_deviation(self, ax: Axes | None = None, *, unit: str = "") -> Axes:
        """Draw how far the curve is from the points, along it (see `cadfit.plotting.plot_deviation`)."""
        from cadfit.plotting import plot_deviation

        return plot_deviation(self, ax, unit=unit)

    def plot_comb(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draw the curves and their curvature combs (see `cadfit.plotting.plot_comb`)."""
        from cadfit.plotting import plot_comb

        return plot_comb(self.curves, ax, **options)

    def report(
        self, path: str | os.PathLike[str], *, title: str = "", unit: str = "", progress: Progress | None = None
    ) -> None:
        """Write the fit as one HTML page to look at, which opens offline (see `cadfit.report.report`)."""
        from cadfit.report import report

        report(self, path, title=title, unit=unit, progress=progress)


def _again(*values: Any) -> Fit:
    """Return a fit from what was copied or pickled, its arrays read-only as before."""
    kept: list[Any] = [own(value) if isinstance(value, np.ndarray) else value for value in values]
    return Fit(*kept)


def written(function: str, *arguments: float, **options: Any) -> str:
    """Return a call of a public function on `points` as it is written; numbers in full, long arrays by their name.

    >>> written("fit", 0.01, closed=True, corners=np.array([3, 17]), weights=np.ones(100))
    'cadfit.fit(points, 0.01, closed=True, corners=[3, 17], weights=weights)'
    """
    named = [f"{name}={_written(name, value)}" for name, value in options.items()]
    return f"cadfit.{function}({', '.join(['points', *(repr(float(value)) for value in arguments), *named])})"


def _written(name: str, value: Any) -> str:
    if value is None or isinstance(value, str | bool):
        return repr(value)
    if isinstance(value, list | tuple) and any(each is None for each in value):
        return f"[{', '.join(_written(name, each) for each in value)}]"
    array = np.asarray(value)
    return name if array.size > 64 else repr(array.tolist())
