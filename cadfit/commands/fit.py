"""`cadfit fit`."""

from __future__ import annotations

from cadfit.commands.options import (
    BetweenPoints,
    Closed,
    Corners,
    Curvature,
    Fraction,
    HowLong,
    HowTo,
    In,
    InUnit,
    Out,
    Quiet,
    SquareError,
    Tension,
    Unit,
    Within,
)
from cadfit.commands.terminal import about, busy, check, report, write_all


def fit(
    source: In,
    output: Out,
    tolerance: Within = None,
    between: BetweenPoints = None,
    corners: Corners = None,
    effort: HowLong = None,
    method: HowTo = None,
    tension: Tension = None,
    curvature: Curvature = None,
    fraction: Fraction = None,
    square_error: SquareError = None,
    closed: Closed = None,
    unit: InUnit = Unit.mm,
    quiet: Quiet = False,
) -> None:
    """Fit B-splines to points, within a tolerance or through all, and write them to .step .stp .brep .json .csv."""
    from cadfit.files import read
    from cadfit.methods import How, made

    how = How(method, closed, tension, curvature, tolerance, between, corners, effort, fraction, square_error)
    with busy(f"fitting {source}", quiet) as progress:
        check(source, output, "curves")
        with about(source):
            curves, said = made(read(source), how, progress)
        write_all(source, output, "curves", curves.dimension, curves, unit)
    report(str(source), said, output, quiet)
