"""`cadfit tube`."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from cadfit.commands.along import (
    Answer,
    Caps,
    Ends,
    FitWithin,
    Meeting,
    Source,
    Swept,
    Texture,
    Up,
    Within,
    number_or_name,
    up_of,
    way_in,
)
from cadfit.commands.options import Closed, Curvature, HowTo, InUnit, Out, Quiet, Tension, Unit, Verbose
from cadfit.commands.terminal import about, busy, report, timed


def tube(
    source: Source,
    output: Out,
    radius: Annotated[
        str, typer.Option(help="The tube's radius: a number, or a column of PATH, r or #4.", show_default=False)
    ],
    thickness: Annotated[float | None, typer.Option(help="Make it a pipe, with walls this thick inward.")] = None,
    caps: Ends = Caps.flat,
    up: Up = None,
    tolerance: Within = None,
    fit: FitWithin = None,
    method: HowTo = None,
    tension: Tension = None,
    curvature: Curvature = None,
    closed: Closed = None,
    on_self_intersection: Meeting = Answer.warn,
    texture: Texture = False,
    unit: InUnit = Unit.mm,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Sweep a circle along points or a curve, and write a mesh to .stl .3mf .ply .glb .obj, a solid to .step .brep."""
    from cadfit.methods import How
    from cadfit.stages import stage
    from cadfit.sweeping.tube import tube as meshed

    with timed(verbose):
        swept = Swept.to(source, output, caps, on_self_intersection)
        with about(source):
            size: Any = number_or_name(radius)
            how = How(method, closed, tension, curvature, fit)
            way = way_in(source, how, unit.value, quiet, None if isinstance(size, float) else size)
            size = size if isinstance(size, float) else way.values
        with busy(f"sweeping along {source}", quiet) as progress, about(source):
            like: dict[str, Any] = {"thickness": thickness, "up": up_of(up), "caps": caps.value, "progress": progress}

            def mesh() -> Any:
                answer: Any = on_self_intersection.value
                return meshed(way.curve, size, tolerance, texture=texture, on_self_intersection=answer, **like)

            def solid() -> Any:
                from cadfit.occt import tube_solid

                return tube_solid(way.curve, size, tolerance, **like)

            with stage("sweeping"):
                made = swept.made(mesh, solid)
        said = swept.write(made, unit, quiet)
    report(str(source), way.said | said, output, quiet)
