"""`cadfit compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cadfit.commands.options import Closed, InUnit, Quiet, Unit
from cadfit.commands.terminal import Mistake, about, busy, check_page, say

if TYPE_CHECKING:
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
    closed: Closed = None,
    unit: InUnit = Unit.mm,
    quiet: Quiet = False,
) -> None:
    """Hold several curves of the same points, by methods or from files, against each other at one tolerance.

    Every method is run on every file of points (default: cadfit, fitpack, and occt where a CAD kernel is at hand);
    curves are held against the one file of points. All deviations are certified by cadfit.
    """
    import shlex

    from cadfit.files import Curves, read
    from cadfit.report import write
    from cadfit.report.compare import METHODS, by_method, of_curves, usual

    named = [each for each in what if each in METHODS and not Path(each).exists()]
    paths = [Path(each) for each in what if each not in named]
    check_page(output, paths)
    found: dict[Path, Any] = {}
    for path in paths:
        with about(path):
            found[path] = read(path, unit.value)
            if hasattr(found[path], "faces"):
                raise ValueError("holds a mesh: points and curves can be compared")
    curves = {path: each for path, each in found.items() if isinstance(each, Curves)}
    points = {path: each for path, each in found.items() if path not in curves}
    if not points:
        raise Mistake(f"{what[0]}: at least one file of points is needed, to hold the curves against")
    if curves and len(points) > 1:
        raise Mistake(f"{next(iter(curves))}: curves are held against one file of points, not {len(points)}")
    entries: list[Entry] = []
    for path, each in points.items():
        for method in named or usual(each.shape[1]):
            name = f"{path.stem}: {method}" if len(points) > 1 else method
            with busy(f"{method} of {path}", quiet), about(path):
                entry = by_method(method, each, tolerance, closed, name)
            if entry is None:
                say(f"{path}: {method} makes no curve of it")
            else:
                entries.append(entry)
        for other, held in curves.items():
            with busy(f"judging {other}", quiet), about(other):
                entries.append(of_curves(held.curves, each, tolerance, closed, other.name))
    if not entries:
        raise Mistake(f"{what[0]}: no curve to compare")
    if output is not None:
        title = ", ".join(path.name for path in points) + f" at {tolerance:g} {unit.value}"
        only = next(iter(points)) if len(points) == 1 else None
        write(entries, output, title, unit.value, [shlex.join(["cadfit", *context.obj])], only)
    if not quiet:
        _table(entries, tolerance)
        if output is not None:
            print(f"wrote {output}")


def _table(entries: list[Entry], tolerance: float) -> None:
    """Print the figures of all entries."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("", no_wrap=True, min_width=max(len(entry.name) for entry in entries))
    for name in ("points", "poles", "off", "/ tolerance", "between", "no wiggle", "time"):
        table.add_column(name, justify="right", no_wrap=True)
    for entry in entries:
        fit, far = entry.fit, entry.fit.deviation
        off = [f"{far.points:.4g}", f"{far.points / tolerance:.3g}", f"{far.between:.4g}"]
        wiggles = f"{entry.strays} stray" if entry.strays else "yes"
        took = f"{entry.seconds:.3g} s" if entry.seconds is not None else "–"
        broken = "red" if far.points > tolerance or entry.strays else ""
        counts = [str(len(fit.points)), str(fit.poles)]
        table.add_row(Text(entry.name), *counts, *off, wiggles, took, style=broken)
    Console(highlight=False).print(table)
