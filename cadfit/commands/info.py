"""`cadfit info`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cadfit.commands.options import InUnit, Unit
from cadfit.commands.terminal import about, busy, report


def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Points, curves or a mesh.", show_default=False)],
    unit: InUnit = Unit.mm,
) -> None:
    """Say what is in a file of points, curves or a mesh."""
    from cadfit.files import read
    from cadfit.files.facts import facts

    with busy(f"reading {file}", quiet=False) as progress, about(file):
        found = facts(read(file, unit.value, progress))
    report(str(file), found, [], quiet=False)
