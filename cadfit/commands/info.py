"""`cadfit info`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cadfit.commands.options import InUnit, Unit, Verbose
from cadfit.commands.terminal import about, busy, report, timed


def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Points, curves, a mesh or solids.", show_default=False)],
    unit: InUnit = Unit.mm,
    verbose: Verbose = False,
) -> None:
    """Say what is in a file of points, curves, a mesh or solids."""
    from cadfit.files import describe

    with timed(verbose), busy(f"reading {file}", quiet=False) as progress, about(file):
        found = describe(file, unit.value, progress)
    report(str(file), found, [], quiet=False)
