"""`cadfit toolpath`."""

from __future__ import annotations

from enum import StrEnum
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cadfit.commands.options import Effort, Quiet, Verbose
from cadfit.commands.terminal import Mistake, about, busy, check_places, report, timed

if TYPE_CHECKING:
    from cadfit.toolpaths import Summary


class Words(StrEnum):
    """What curved moves are written as."""

    arcs = "arcs"
    g5 = "g5"
    poly = "poly"
    spl = "spl"


def toolpath(
    source: Annotated[Path, typer.Argument(metavar="IN", help="G-code: .nc .gcode .ngc .tap", show_default=False)],
    output: Annotated[Path, typer.Option("-o", "--output", help="Where to.", show_default=False)],
    tolerance: Annotated[
        float, typer.Option("-t", "--tolerance", help="Millimetres the new path may be from the old: certified.")
    ],
    corner: Annotated[float, typer.Option(help="Turns sharper than this, in degrees, are kept.")] = 35.0,
    curves: Annotated[
        Words,
        typer.Option(
            help="arcs: G2 and G3; g5: cubic pieces of LinuxCNC (X and Y); poly: of Siemens; spl: of Heidenhain."
        ),
    ] = Words.arcs,
    effort: Annotated[Effort, typer.Option(help="fast, or best for somewhat fewer moves in more time.")] = Effort.fast,
    decimals: Annotated[int | None, typer.Option(help="Of coordinates.  [4, in inches 5]")] = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Refit the cutting moves of a G-code program with few lines and curves, and leave everything else as it is."""
    from cadfit.toolpaths import refit

    if output.exists() and source.exists() and output.samefile(source):
        raise Mistake(f"{output}: the output would replace the input")
    check_places([output])
    with timed(verbose), busy(f"refitting {source}", quiet) as progress, about(source):
        done = refit(
            source,
            output,
            tolerance,
            corner=radians(corner),
            decimals=decimals,
            curves=curves.value,
            effort=effort.value,
            progress=progress,
        )
    report(str(source), _said(done), [output], quiet)


def _said(done: Summary) -> dict[str, str]:
    """Name what was done, as the report prints it."""
    before, after = done.length
    said = {
        "lines": _change(done.lines),
        "bytes": _change(done.bytes),
        "cutting moves": _change(done.moves),
        "runs refitted": f"{done.runs[1]:,} of {done.runs[0]:,}",
        "largest deviation": f"{done.deviation:.4g} mm",
        "arcs": f"{done.arcs:,}",
    }
    if done.splines:
        said["cubic pieces"] = f"{done.splines:,}"
    if done.arcs:
        said["smallest radius"] = f"{done.smallest_radius:.4g} mm"
    if before:
        said["length"] = f"{before:.6g} to {after:.6g} mm ({100.0 * (after - before) / before:+.3f} %)"
    if done.kept:
        first = ", ".join(f"{word} in line {line}" for line, word in done.kept[:5])
        more = f" and {len(done.kept) - 5:,} more" if len(done.kept) > 5 else ""
        said["not understood"] = f"{first}{more}: left as they were"
    return said


def _change(pair: list[int]) -> str:
    before, after = pair
    return f"{before:,} to {after:,}" + (f" ({before / after:.3g} times fewer)" if 0 < after < before else "")
