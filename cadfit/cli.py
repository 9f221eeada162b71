"""The command line: `cadfit fit`, `cadfit tube`, `cadfit info`. The only place that prints.

What computes is imported inside the commands, so that `cadfit --help` answers at once.
"""

from __future__ import annotations

import io
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from cadfit.files import Kind


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
    with _busy(f"fitting {source}", quiet) as progress:
        _check(source, output, "curves")
        with _about(source):
            curves, said = made(read(source), how, progress)
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
    from cadfit.methods import How, made
    from cadfit.sweeping.mesh import tube as swept

    how = How(method, closed, tension, curvature)
    with _busy(f"sweeping along {source}", quiet):
        _check(source, output, "mesh")
        with _about(source):
            if method in (Method.tolerance, Method.dominant):
                raise ValueError(f"--method {method} is for cadfit fit: write its curve to a .json, and sweep that")
            found = read(source, unit.value)
            if isinstance(found, Curves):
                if how != How():
                    raise ValueError("holds curves: --method, --tension, --curvature and --closed are for points")
                curves, said = found, summary(found)
            else:
                curves, said = made(found, how)
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
def _busy(what: str, quiet: bool) -> Iterator[Callable[[float], None] | None]:
    """Show a bar on a terminal while the block runs; give what moves it, from 0 to 1. It pulses until that is used."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(escape(what), total=None)
        yield lambda part: progress.update(task, total=1.0, completed=part)


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
