"""What a file of curves or a drawing holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cadfit.arcing.result import Arcs
from cadfit.bezier import Array
from cadfit.bspline import BSpline

if TYPE_CHECKING:
    from cadfit.fitting.deviation import Deviation


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """One curve, or several in order: `curves`, all of one dimension.

    `closed`: the last ends where the first starts. `deviation`: how far they are from the points they were made of,
    where the file says so. `names`: of their layers or elements in a drawing, one for each, or none. `vertices` (n, d):
    of a drawing that is one polyline. Raises ValueError when there are no curves, their dimensions differ, or there are
    not as many names.

    >>> line = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> Curves((line, line.reversed()), closed=True).dimension
    2
    """

    curves: tuple[BSpline, ...]
    closed: bool
    deviation: Deviation | None = None
    names: tuple[str, ...] = ()
    vertices: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "curves", tuple(self.curves))
        if not self.curves:
            raise ValueError("at least one curve is needed")
        dimensions = sorted({curve.poles.shape[1] for curve in self.curves})
        if len(dimensions) > 1:
            raise ValueError(f"the curves must have one dimension, not {dimensions}")
        _check_names(self.names, len(self.curves))

    @property
    def dimension(self) -> int:
        """The number of coordinates."""
        return int(self.curves[0].poles.shape[1])


@dataclass(frozen=True, slots=True, eq=False)
class ArcContours:
    """Contours of lines and arcs in order: `arcs`, all of one dimension, with `names` as of `Curves`.

    Raises ValueError when there are none, their dimensions differ, or there are not as many names.
    """

    arcs: tuple[Arcs, ...]
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "arcs", tuple(self.arcs))
        if not self.arcs:
            raise ValueError("at least one contour is needed")
        dimensions = sorted({each.starts.shape[1] for each in self.arcs})
        if len(dimensions) > 1:
            raise ValueError(f"the contours must have one dimension, not {dimensions}")
        _check_names(self.names, len(self.arcs))

    @property
    def dimension(self) -> int:
        """The number of coordinates."""
        return int(self.arcs[0].starts.shape[1])


def _check_names(names: tuple[str, ...], count: int) -> None:
    if names and len(names) != count:
        raise ValueError(f"{count} curves need as many names or none, not {len(names)}")
