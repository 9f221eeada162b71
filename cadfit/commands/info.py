"""`cadfit info`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cadfit.commands.options import InUnit, Unit, Verbose
from cadfit.commands.terminal import about, busy, report, timed


def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Points, curves or a mesh.", show_default=False)],
    unit: InUnit = Unit.mm,
    verbose: Verbose = False,
) -> None:
    """Say what is in a file of points, curves or a mesh."""
    from cadfit.files import read
    from cadfit.files.facts import facts
    from cadfit.stages import stage

    with timed(verbose), busy(f"reading {file}", quiet=False) as progress, about(file):
        held = read(file, unit.value, progress)
        with stage("measuring"):
            found = facts(held)
    report(str(file), found, [], quiet=False)
