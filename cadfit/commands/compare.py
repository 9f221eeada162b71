"""`cadfit compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cadfit.commands.options import Closed, InUnit, Quiet, Unit, Verbose
from cadfit.commands.terminal import Mistake, about, busy, check_page, timed

if TYPE_CHECKING:
    from cadfit.report.compare import Nothing
    from cadfit.report.data import Entry


def compare(
    context: typer.Context,
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="A B...",
            help="Files of points, files of curves, methods: cadfit fast fitpack occt.",
            show_default=False,
        ),
    ],
    tolerance: Annotated[float, typer.Option("-t", "--tolerance", help="The tolerance of all.", show_default=False)],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Where to write the page, as .html.")] = None,
    limit: Annotated[float, typer.Option(help="Seconds that fitpack and occt may take, each.", min=0.0)] = 60.0,
    closed: Closed = None,
    unit: InUnit = Unit.mm,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Hold several curves of the same points, by methods or from files, against each other at one tolerance.

    Every method is run on every file of points (default: cadfit, fitpack, and occt where a CAD kernel is at hand);
    curves are held against the one file of points. All deviations are certified by cadfit.
    """
    import shlex

    from cadfit.report import write
    from cadfit.report.compare import METHODS, Nothing, by_method, of_curves, usual

    named = [each for each in what if each in METHODS and not Path(each).exists()]
    paths = [Path(each) for each in what if each not in named]
    check_page(output, paths)
    with timed(verbose):
        points, curves = _read(paths, unit, quiet)
        if not points:
            raise Mistake(f"{what[0]}: at least one file of points is needed, to hold the curves against")
        if curves and len(points) > 1:
            raise Mistake(f"{next(iter(curves))}: curves are held against one file of points, not {len(points)}")
        found: list[Entry | Nothing] = []
        for path, each in points.items():
            for method in named or usual(each.shape[1]):
                name = f"{path.stem}: {method}" if len(points) > 1 else method
                with busy(f"{method} of {path}", quiet) as progress, about(path):
                    found.append(by_method(method, each, tolerance, closed, name, limit=limit, progress=progress))
            for other, held in curves.items():
                with busy(f"judging {other}", quiet), about(other):
                    found.append(of_curves(held.curves, each, tolerance, closed, other.name))
        entries = [each for each in found if not isinstance(each, Nothing)]
        without = [str(each) for each in found if isinstance(each, Nothing)]
        if not entries:
            raise Mistake(f"{what[0]}: no curve to compare: {'; '.join(without)}")
        if output is not None:
            title = ", ".join(path.name for path in points) + f" at {tolerance:g} {unit.value}"
            only = next(iter(points)) if len(points) == 1 else None
            with busy(f"writing {output}", quiet) as progress:
                call = [shlex.join(["cadfit", *context.obj])]
                write(entries, output, title, unit.value, call, only, without=without, progress=progress)
    if not quiet:
        _table(found, tolerance)
        if output is not None:
            print(f"wrote {output}")


def _read(paths: list[Path], unit: Unit, quiet: bool) -> tuple[dict[Path, Any], dict[Path, Any]]:
    """Return the points and the curves that files hold."""
    from cadfit.files import Curves, read

    found: dict[Path, Any] = {}
    for path in paths:
        with busy(f"reading {path}", quiet) as progress, about(path):
            found[path] = read(path, unit.value, progress)
            if hasattr(found[path], "faces"):
                raise ValueError("holds a mesh: points and curves can be compared")
    curves = {path: each for path, each in found.items() if isinstance(each, Curves)}
    return {path: each for path, each in found.items() if path not in curves}, curves


def _table(found: list[Entry | Nothing], tolerance: float) -> None:
    """Print the figures of all entries, and why there are none."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from cadfit.report.compare import Nothing

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("", no_wrap=True, min_width=max(len(each.name) for each in found))
    for name in ("points", "poles", "off", "/ tolerance", "between", "no wiggle", "time"):
        table.add_column(name, justify="right", no_wrap=True)
    for each in found:
        if isinstance(each, Nothing):
            table.add_row(Text(each.name), str(each.points), *["–"] * 5, Text(each.reason), style="red")
            continue
        fit, far = each.fit, each.fit.deviation
        off = [f"{far.points:.4g}", f"{far.points / tolerance:.3g}", f"{far.between:.4g}"]
        wiggles = f"{each.strays} stray" if each.strays else "yes"
        took = f"{each.seconds:.3g} s" if each.seconds is not None else "–"
        broken = "red" if far.points > tolerance or each.strays else ""
        counts = [str(len(fit.points)), str(fit.poles)]
        table.add_row(Text(each.name), *counts, *off, wiggles, took, style=broken)
    Console(highlight=False, width=1000).print(table)  # no figure is cut off at the terminal's edge
