"""What a curve file holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cadfit.bspline import BSpline

if TYPE_CHECKING:
    from cadfit.fitting.deviation import Deviation


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """One curve, or several in order: `curves`, all of one dimension.

    `closed`: the last ends where the first starts. `deviation`: how far they are from the points they were made of,
    where the file says so. `names`: of their layers or elements in a drawing, one for each, or none. Raises ValueError
    when there are no curves, their dimensions differ, or there are not as many names.

    >>> line = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> Curves((line, line.reversed()), closed=True).dimension
    2
    """

    curves: tuple[BSpline, ...]
    closed: bool
    deviation: Deviation | None = None
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "curves", tuple(self.curves))
        if not self.curves:
            raise ValueError("at least one curve is needed")
        dimensions = sorted({curve.poles.shape[1] for curve in self.curves})
        if len(dimensions) > 1:
            raise ValueError(f"the curves must have one dimension, not {dimensions}")
        if self.names and len(self.names) != len(self.curves):
            raise ValueError(f"{len(self.curves)} curves need as many names or none, not {len(self.names)}")

    @property
    def dimension(self) -> int:
        """The number of coordinates."""
        return int(self.curves[0].poles.shape[1])
