"""The command line: `cadfit fit`, `cadfit tube`, `cadfit info`. The only place that prints.

What computes is imported inside the commands, so that `cadfit --help` answers at once.
"""

from __future__ import annotations

import io
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from cadfit.bezier import Array
    from cadfit.bspline import BSpline
    from cadfit.files import Curves, Kind


class Method(StrEnum):
    """How a curve is put through the points."""

    cardinal = "cardinal"
    local = "local"
    interpolate = "interpolate"
    dominant = "dominant"


class Unit(StrEnum):
    """The unit of length of the coordinates."""

    mm = "mm"
    m = "m"
    inch = "inch"


Fraction = Annotated[float | None, typer.Option(help="dominant: the part of the points to put the curve through.")]
SquareError = Annotated[
    float | None,
    typer.Option(help="dominant: instead, the most that the other points' squared distances sum to."),
]
In = Annotated[
    Path, typer.Argument(metavar="IN", help="Points: .csv .txt .xyz .dat .npy .npz .json", show_default=False)
]
Out = Annotated[list[Path], typer.Option("-o", "--output", help="Where to; may be given several times.")]
HowTo = Annotated[
    Method | None,
    typer.Option("--method", help="Default: local; cardinal where --tension or --curvature is given."),
]
Tension = Annotated[float | None, typer.Option(help="cardinal: length of the tangents.  [default: 0.5]")]
Curvature = Annotated[
    float | None, typer.Option(help="cardinal: part of the curvature kept at the points, 0 to 1.  [default: 0]")
]
Closed = Annotated[
    bool | None,
    typer.Option("--closed/--open", help="Default: closed where the last point repeats the first.", show_default=False),
]
InUnit = Annotated[Unit, typer.Option(help="The unit of the coordinates, for STEP.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors and warnings.")]

app = typer.Typer(
    name="cadfit",
    help="Ordered points to B-splines a CAD program can trust.",
    add_completion=False,
    rich_markup_mode=None,  # rich would double the time of --help
    pretty_exceptions_enable=False,
)


class _Mistake(Exception):
    """A mistake of the user's, said in one line that begins with the file."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line (default: `sys.argv`) and return the exit status: 0, 2 for a mistake, 130 for Ctrl-C."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files the terminal has no letters for
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("default", category=UserWarning)
            warnings.showwarning = _warn
            return app(arguments, prog_name="cadfit", standalone_mode=False) or 0
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except OSError as error:
        line = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    except (_Mistake, ValueError, ImportError) as error:
        line = str(error)
    except Exception as error:
        if not hasattr(error, "format_message"):  # how the usage errors of typer and click are known
            raise
        line = f"{error.format_message()} (see cadfit --help)"
    _say(line)
    return 2


def _warn(message: Warning | str, *_: object, **__: object) -> None:
    _say(f"warning: {message}")


def _say(line: str) -> None:
    print("cadfit:", " ".join(line.split()), file=sys.stderr)


@app.callback(invoke_without_command=True)
def _top(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    if version:
        from cadfit import __version__

        print(__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())


@app.command()
def fit(
    source: In,
    output: Out,
    method: HowTo = None,
    tension: Tension = None,
    curvature: Curvature = None,
    fraction: Fraction = None,
    square_error: SquareError = None,
    closed: Closed = None,
    unit: InUnit = Unit.mm,
    quiet: Quiet = False,
) -> None:
    """Fit a B-spline through points, and write it to .step .stp .brep .json .csv."""
    from cadfit.files import read

    with _busy(f"fitting {source}", quiet):
        _check(source, output, "curves")
        with _about(source):
            if method is Method.dominant or fraction is not None or square_error is not None:
                if method is not Method.dominant or tension is not None:
                    raise ValueError("--fraction and --square-error go with --method dominant, --tension does not")
                curves, said = _dominant(read(source), fraction, square_error, curvature, closed)
            else:
                curves, said = _fitted(read(source), method, tension, curvature, closed)
        _write(source, output, "curves", curves.dimension, curves, unit)
    _report(str(source), said, output, quiet)


@app.command()
def tube(
    source: Annotated[Path, typer.Argument(metavar="IN", help="A point file, or a curve: .json .step .stp .brep")],
    output: Out,
    radius: Annotated[float, typer.Option(help="The tube's radius.", show_default=False)],
    tolerance: Annotated[float | None, typer.Option(help="How far the mesh may be from the tube.")] = None,
    method: HowTo = None,
    tension: Tension = None,
    curvature: Curvature = None,
    closed: Closed = None,
    unit: InUnit = Unit.mm,
    quiet: Quiet = False,
) -> None:
    """Sweep a circle along points or a curve, and write the mesh to .stl .3mf .ply .glb .obj."""
    from cadfit.files import Curves, read
    from cadfit.files.facts import facts, summary
    from cadfit.joining import join
    from cadfit.sweeping.mesh import tube as swept

    how = (method, tension, curvature, closed)
    with _busy(f"sweeping along {source}", quiet):
        _check(source, output, "mesh")
        with _about(source):
            found = read(source, unit.value)
            if isinstance(found, Curves):
                if any(given is not None for given in how):
                    raise ValueError("holds curves: --method, --tension, --curvature and --closed are for points")
                curves, said = found, summary(found)
            else:
                curves, said = _fitted(found, *how)
            mesh = swept(join(curves.curves), radius, tolerance)
        _write(source, output, "mesh", 3, mesh, unit)
    of_mesh = facts(mesh)
    del of_mesh["kind"]
    _report(str(source), said | of_mesh, output, quiet)


@app.command()
def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Points, curves or a mesh.", show_default=False)],
    unit: InUnit = Unit.mm,
) -> None:
    """Say what is in a file of points, curves or a mesh."""
    from cadfit.files import read
    from cadfit.files.facts import facts

    with _busy(f"reading {file}", quiet=False), _about(file):
        found = facts(read(file, unit.value))
    _report(str(file), found, [], quiet=False)


def _fitted(
    found: Any, method: Method | None, tension: float | None, curvature: float | None, closed: bool | None
) -> tuple[Curves, dict[str, str]]:
    """Return the curve through what a file of points holds, and what to report of it."""
    import numpy as np

    from cadfit.files import Curves
    from cadfit.files.facts import summary
    from cadfit.fitting.deviation import deviation
    from cadfit.points.clean import clean

    cardinal = tension is not None or curvature is not None
    method = method or (Method.cardinal if cardinal else Method.local)
    if method is Method.dominant:
        raise ValueError("--method dominant is for cadfit fit: write its curve to a .json and sweep that")
    if cardinal and method is not Method.cardinal:
        raise ValueError(f"--tension and --curvature go with --method cardinal, not {method.value}")
    if not isinstance(found, np.ndarray):
        raise ValueError(f"points are needed, and it holds {'curves' if isinstance(found, Curves) else 'a mesh'}")
    points = clean(found, closed)
    if closed is None and points.closed:
        _warn_of_corner_at_seam(points.points)
    spline = _through(points.points, method, tension, curvature, points.closed)
    curves = Curves((spline,), points.closed, deviation(spline, points.points, points.closed))
    read_in = {"points read": str(len(found)), "repeats dropped": str(len(points.dropped)), "method": method.value}
    return curves, read_in | summary(curves)


def _dominant(
    found: Any, fraction: float | None, square_error: float | None, curvature: float | None, closed: bool | None
) -> tuple[Curves, dict[str, str]]:
    """Return the curve through the dominant points of what a file of points holds, and what to report of it."""
    import numpy as np

    import cadfit
    from cadfit.files import Curves
    from cadfit.files.facts import summary

    if not isinstance(found, np.ndarray):
        raise ValueError(f"points are needed, and it holds {'curves' if isinstance(found, Curves) else 'a mesh'}")
    if (fraction is None) == (square_error is None):
        raise ValueError("--method dominant needs one of --fraction and --square-error")
    fit = cadfit.fit_dominant(
        found, None, fraction, square_error, closed=closed, curvature=1.0 if curvature is None else curvature
    )
    if closed is None and fit.closed:
        _warn_of_corner_at_seam(fit.points)
    curves = Curves(fit.curves, fit.closed, fit.deviation)
    dominant = (len(fit.spline.distinct_knots) + (-1 if fit.closed else 4)) // 3
    read_in = {"points read": str(len(found)), "repeats dropped": str(len(fit.cleaned)), "dominant": str(dominant)}
    return curves, read_in | summary(curves)


def _warn_of_corner_at_seam(points: Array) -> None:
    """Say so where a contour taken for closed turns sharply at its seam, as an airfoil does at its trailing edge."""
    import numpy as np

    before, after = points[0] - points[-1], points[1] - points[0]
    turn = np.degrees(np.arccos(np.clip(before @ after / np.sqrt((before @ before) * (after @ after)), -1.0, 1.0)))
    if turn > 60.0:
        warnings.warn(
            f"the last row repeats the first, so the curve is closed and smooth there, though the points turn by "
            f"{turn:.0f} degrees; --open keeps that corner sharp, --closed says it is meant",
            stacklevel=2,
        )


def _through(points: Array, method: Method, tension: float | None, curvature: float | None, closed: bool) -> BSpline:
    import cadfit

    if method is Method.cardinal:
        return cadfit.cardinal_spline(points, 0.5 if tension is None else tension, curvature or 0.0, closed)
    if method is Method.local:
        return cadfit.local_spline(points, closed)
    return cadfit.interpolate(points, closed=closed)


def _check(source: Path, outputs: list[Path], kind: Kind, dimension: int | None = None) -> None:
    """Refuse what cannot be written, before any work is done."""
    from cadfit.files import check

    for path in outputs:
        check(path, kind, dimension)
        if path.exists() and source.exists() and path.samefile(source):
            raise _Mistake(f"{path}: the output would replace the input")


def _write(source: Path, outputs: list[Path], kind: Kind, dimension: int, result: Any, unit: Unit) -> None:
    from cadfit.files import write

    _check(source, outputs, kind, dimension)
    for path in outputs:
        with _about(path):
            write(path, result, unit.value)


@contextmanager
def _about(path: Path) -> Iterator[None]:
    """Name the file in what goes wrong in the block."""
    try:
        yield
    except Exception as error:
        kernel = sys.modules.get("cadfit.occt")
        if not isinstance(error, (ValueError, kernel.KernelError) if kernel else ValueError):
            raise
        named = str(error).startswith(str(path))
        raise _Mistake(str(error) if named else f"{path}: {error}") from error


@contextmanager
def _busy(what: str, quiet: bool) -> Iterator[None]:
    """Turn a spinner on a terminal while the block runs."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status(escape(what)):
        yield


def _report(title: str, facts: dict[str, str], written: list[Path], quiet: bool) -> None:
    if quiet:
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False, soft_wrap=True)
    console.print(Text(title, style="bold"))
    width = max(map(len, facts))
    for name, value in facts.items():
        console.print(Text.assemble((name.ljust(width), "dim"), "  ", value))
    for path in written:
        console.print(Text(f"wrote {path}"))


if __name__ == "__main__":
    sys.exit(main())
