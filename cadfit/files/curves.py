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
    where the file says so. Raises ValueError when there are no curves or their dimensions differ.

    >>> line = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> Curves((line, line.reversed()), closed=True).dimension
    2
    """

    curves: tuple[BSpline, ...]
    closed: bool
    deviation: Deviation | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "curves", tuple(self.curves))
        if not self.curves:
            raise ValueError("at least one curve is needed")
        dimensions = sorted({curve.poles.shape[1] for curve in self.curves})
        if len(dimensions) > 1:
            raise ValueError(f"the curves must have one dimension, not {dimensions}")

    @property
    def dimension(self) -> int:
        """The number of coordinates."""
        return int(self.curves[0].poles.shape[1])
