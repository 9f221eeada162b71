"""What the commands share that sweep something along a path: their options, and the path in a file."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cadfit.commands.terminal import busy, check, check_places, write_all

if TYPE_CHECKING:
    from collections.abc import Callable

    from cadfit.bspline import BSpline
    from cadfit.commands.options import Unit
    from cadfit.files import Kind
    from cadfit.methods import How

_SOLID = (".step", ".stp", ".brep")


class Caps(StrEnum):
    """How open ends are closed."""

    flat = "flat"
    round = "round"
    none = "none"


class Answer(StrEnum):
    """What is done about a sweep that would pass through itself."""

    warn = "warn"
    refuse = "raise"
    repair = "repair"


Source = Annotated[
    Path,
    typer.Argument(metavar="PATH", help="A point file, or curves: .json .step .stp .brep", show_default=False),
]
Within = Annotated[float | None, typer.Option(help="How far the mesh, or the solid, may be from the exact surface.")]
FitWithin = Annotated[
    float | None, typer.Option("--fit", help="Fit the path to the points within this first, corners kept.")
]
Ends = Annotated[Caps, typer.Option(help="How open ends are closed.")]
Up = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="Keep the profile's y toward this direction: no banking.")
]
Meeting = Annotated[
    Answer, typer.Option("--on-self-intersection", help="What to do about a sweep that would pass through itself.")
]
Texture = Annotated[bool, typer.Option("--texture", help="Texture coordinates, in .glb and .obj.")]


@dataclass(frozen=True)
class Way:
    """A path to sweep along: its `curve`, what to report of it, and a column's values along it, (n, 2) or None."""

    curve: BSpline
    said: dict[str, str]
    values: Any


def way_in(source: Path, how: How, unit: str, quiet: bool, column: str | None = None) -> Way:
    """Return the path in a file of points or curves.

    `column` is the name or the number ("#4") of a column of a point file that is no coordinate: its values come with
    the parameters they stand at.

    Raises ValueError for methods of `cadfit fit` alone, options that do not go with curves, and a column there is not.
    """
    import numpy as np

    import cadfit
    from cadfit.files import Curves, read
    from cadfit.files.facts import summary
    from cadfit.fitting.matching import match
    from cadfit.joining import join
    from cadfit.methods import How, made

    if how.method in ("tolerance", "dominant"):
        raise ValueError(f"--method {how.method} is for cadfit fit: write its curve to a .json, and sweep that")
    with busy(f"reading {source}", quiet) as progress:
        found = read(source, unit, progress)
    if isinstance(found, Curves):
        if how != How():
            raise ValueError("holds curves: --fit, --method, --tension, --curvature and --closed are for points")
        if column is not None:
            raise ValueError(f"holds curves, which have no column {column!r}")
        return Way(join(found.curves), summary(found), None)
    points, values = found, None
    if column is not None:
        at = _column(source, found, column)
        points, values = np.delete(found, at, axis=1), found[:, at]
    with busy(f"fitting {source}", quiet) as progress:
        curves, said = made(points, how, progress)
    curve = join(curves.curves)
    if values is None:
        return Way(curve, said, None)
    cleaned = cadfit.clean(points, how.closed)
    return Way(curve, said, np.column_stack([match(curve, cleaned.points)[0], values[cleaned.kept]]))


@dataclass(frozen=True)
class Swept:
    """The files that a sweep is written to, as a `mesh` or as a `solid`."""

    source: Path
    mesh: list[Path]
    solid: list[Path]

    @classmethod
    def to(cls, source: Path, output: list[Path], caps: Caps, answer: Answer) -> Swept:
        """Return the outputs sorted by their suffixes; refuse what cannot be written before any work is done."""
        solid = [path for path in output if path.suffix.lower() in _SOLID]
        mesh = [path for path in output if path not in solid]
        check(source, mesh, "mesh")
        check(source, solid, "solid")
        check_places(output)
        if solid and caps is Caps.none:
            raise ValueError("--caps none leaves the ends open, and encloses no solid: flat or round")
        if solid and answer is Answer.repair:
            raise ValueError("--on-self-intersection repair is for meshes: a solid is refused where it meets itself")
        return cls(source, mesh, solid)

    def made(self, mesh: Callable[[], Any], solid: Callable[[], Any]) -> dict[Kind, Any]:
        """Return the mesh and the solid, those that are written."""
        wanted: list[tuple[Kind, list[Path], Callable[[], Any]]] = [
            ("solid", self.solid, solid),
            ("mesh", self.mesh, mesh),
        ]
        return {kind: make() for kind, paths, make in wanted if paths}

    def write(self, made: dict[Kind, Any], unit: Unit, quiet: bool) -> dict[str, str]:
        """Write the mesh and the solid, and return what to report of them."""
        from cadfit.files.facts import facts

        said: dict[str, str] = {}
        for kind, result in made.items():
            write_all(self.source, self.solid if kind == "solid" else self.mesh, kind, 3, result, unit, quiet)
            if kind == "solid":
                from cadfit.occt import faces, volume

                said["solid"] = f"{len(faces(result))} faces, volume {volume(result):.7g}, valid"
            else:
                said |= facts(result)
                del said["kind"]
        return said


def up_of(text: str | None) -> list[float] | None:
    """Return the direction written as three numbers with commas; raises ValueError for anything else.

    >>> up_of("0,0,1")
    [0.0, 0.0, 1.0]
    """
    if text is None:
        return None
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise ValueError(f"--up must be three numbers with commas (0,0,1), not {text!r}") from None
    return [x, y, z]


def number_or_name(text: str) -> float | str:
    """Return a number where the text is one, else the text.

    >>> number_or_name("2.5"), number_or_name("r"), number_or_name("#4")
    (2.5, 'r', '#4')
    """
    try:
        return float(text)
    except ValueError:
        return text


def _column(source: Path, found: Any, name: str) -> int:
    """Return the number, from 0, of a column of a point file."""
    from cadfit.files.text import names

    if not hasattr(found, "shape"):
        raise ValueError("points are needed, and it holds a mesh")
    count = found.shape[1]
    if name.startswith("#") and name[1:].isdecimal():
        if not 1 <= int(name[1:]) <= count:
            raise ValueError(f"has {count} columns, and no column {name}")
        return int(name[1:]) - 1
    known = names(source) if source.suffix.lower() in (".csv", ".txt", ".xyz") else []
    if name not in known:
        have = f"its columns are {', '.join(known)}" if known else "its columns have no names"
        raise ValueError(f"has no column {name!r}: {have}; #4 is the fourth")
    return known.index(name)
