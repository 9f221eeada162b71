"""`cadfit tube`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cadfit.commands.options import Closed, Curvature, HowTo, InUnit, Method, Out, Quiet, Tension, Unit, Verbose
from cadfit.commands.terminal import about, busy, check, report, timed, write_all


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
    verbose: Verbose = False,
) -> None:
    """Sweep a circle along points or a curve, and write the mesh to .stl .3mf .ply .glb .obj."""
    from cadfit.files import Curves, read
    from cadfit.files.facts import facts, summary
    from cadfit.joining import join
    from cadfit.methods import How, made
    from cadfit.stages import stage
    from cadfit.sweeping.tube import tube as swept

    how = How(method, closed, tension, curvature)
    with timed(verbose), busy(f"sweeping along {source}", quiet) as progress:
        check(source, output, "mesh")
        with about(source):
            if method in (Method.tolerance, Method.dominant):
                raise ValueError(f"--method {method} is for cadfit fit: write its curve to a .json, and sweep that")
            found = read(source, unit.value)
            if isinstance(found, Curves):
                if how != How():
                    raise ValueError("holds curves: --method, --tension, --curvature and --closed are for points")
                curves, said = found, summary(found)
            else:
                curves, said = made(found, how)
            with stage("sweeping"):
                mesh = swept(join(curves.curves), radius, tolerance, progress=progress)
        write_all(source, output, "mesh", 3, mesh, unit)
    of_mesh = facts(mesh)
    del of_mesh["kind"]
    report(str(source), said | of_mesh, output, quiet)
