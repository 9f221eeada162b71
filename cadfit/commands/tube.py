"""`cadfit tube`."""

from __future__ import annotations

from typing import Annotated

import typer

from cadfit.commands.along import (
    Answer,
    Caps,
    Ends,
    FitWithin,
    Meeting,
    MeshWithin,
    Source,
    Texture,
    Up,
    number_or_name,
    up_of,
    way_in,
)
from cadfit.commands.options import Closed, Curvature, HowTo, InUnit, Method, Out, Quiet, Tension, Unit, Verbose
from cadfit.commands.terminal import about, busy, check, report, timed, write_all


def tube(
    source: Source,
    output: Out,
    radius: Annotated[
        str, typer.Option(help="The tube's radius: a number, or a column of PATH, r or #4.", show_default=False)
    ],
    thickness: Annotated[float | None, typer.Option(help="Make it a pipe, with walls this thick inward.")] = None,
    caps: Ends = Caps.flat,
    up: Up = None,
    tolerance: MeshWithin = None,
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
    """Sweep a circle along points or a curve, and write the mesh to .stl .3mf .ply .glb .obj."""
    from cadfit.files.facts import facts
    from cadfit.methods import How
    from cadfit.stages import stage
    from cadfit.sweeping.tube import tube as swept

    with timed(verbose), busy(f"sweeping along {source}", quiet) as progress:
        check(source, output, "mesh")
        with about(source):
            if method in (Method.tolerance, Method.dominant):
                raise ValueError(f"--method {method} is for cadfit fit: write its curve to a .json, and sweep that")
            size = number_or_name(radius)
            how = How(method, closed, tension, curvature, fit)
            way = way_in(source, how, unit.value, None if isinstance(size, float) else size)
            with stage("sweeping"):
                mesh = swept(
                    way.curve,
                    size if isinstance(size, float) else way.values,
                    tolerance,
                    thickness=thickness,
                    up=up_of(up),
                    caps=caps.value,
                    on_self_intersection=on_self_intersection.value,
                    texture=texture,
                    progress=progress,
                )
        write_all(source, output, "mesh", 3, mesh, unit)
    of_mesh = facts(mesh)
    del of_mesh["kind"]
    report(str(source), way.said | of_mesh, output, quiet)
