"""The options that commands share, and what they may be."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class Method(StrEnum):
    """How curves are made from points: within a tolerance of them, through them all, or through the dominant ones."""

    tolerance = "tolerance"
    cardinal = "cardinal"
    local = "local"
    interpolate = "interpolate"
    dominant = "dominant"


class Between(StrEnum):
    """What the tolerance means between two points."""

    curve = "curve"
    polyline = "polyline"


class Effort(StrEnum):
    """How much time fewer poles are worth."""

    fast = "fast"
    best = "best"


class Unit(StrEnum):
    """The unit of length of the coordinates."""

    mm = "mm"
    m = "m"
    inch = "inch"


Fraction = Annotated[float | None, typer.Option(help="dominant: the part of the points to put the curve through.")]
SquareError = Annotated[
    float | None, typer.Option(help="dominant: instead, the most that the other points' squared distances sum to.")
]
In = Annotated[
    Path, typer.Argument(metavar="IN", help="Points: .csv .txt .xyz .dat .npy .npz .json", show_default=False)
]
Out = Annotated[list[Path], typer.Option("-o", "--output", help="Where to; may be given several times.")]
Ins = Annotated[
    list[Path],
    typer.Argument(metavar="IN...", help="Points: .csv .txt .xyz .dat .npy .npz .json; .dxf .svg", show_default=False),
]
Outs = Annotated[
    list[str] | None,
    typer.Option("-o", "--output", help="Where to: a file, or a folder (out/); may be given several times."),
]
Formats = Annotated[
    list[str] | None,
    typer.Option("--format", help="In a folder: the files' suffix; may be given several times.  [step]"),
]
Jobs = Annotated[
    int | None, typer.Option("-j", "--jobs", min=1, help="Several files: how many at a time.  [the processors]")
]
Summary = Annotated[Path | None, typer.Option(help="Several files: where to write the table, as .csv.")]
Page = Annotated[
    Path | None,
    typer.Option("--report", help="One file: where to write a page to look at, as .html: curve, deviation, curvature."),
]
HowTo = Annotated[
    Method | None,
    typer.Option("--method", help="Default: what the other options ask for, else local: through all points."),
]
Within = Annotated[
    float | None,
    typer.Option("-t", "--tolerance", help="Fit with few poles, no point farther than this: certified."),
]
BetweenPoints = Annotated[
    Between | None,
    typer.Option("--between", help="tolerance: the points are samples of a curve, or the shape's vertices.  [curve]"),
]
Corners = Annotated[
    str | None, typer.Option(help="tolerance: auto, none, an angle in degrees, or rows (3,17 or 5,).  [auto]")
]
HowLong = Annotated[Effort | None, typer.Option("--effort", help="tolerance: fast, or fewer poles.  [best]")]
AsArcs = Annotated[
    bool, typer.Option("--arcs", help="tolerance: lines and arcs instead of splines, within it, for .dxf and .svg.")
]
Tension = Annotated[float | None, typer.Option(help="cardinal: length of the tangents.  [default: 0.5]")]
Curvature = Annotated[
    float | None,
    typer.Option(help="cardinal, dominant: part of the curvature kept at the points.  [default: 0, dominant 1]"),
]
Closed = Annotated[
    bool | None,
    typer.Option("--closed/--open", help="Default: closed where the last point repeats the first.", show_default=False),
]
InUnit = Annotated[Unit, typer.Option(help="The unit of the coordinates, for STEP.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors and warnings.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Print the stages and their times.")]
