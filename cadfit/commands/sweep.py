"""`cadfit sweep`."""

from __future__ import annotations

from pathlib import Path
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


def sweep(
    source: Source,
    output: Out,
    profile: Annotated[
        list[Path],
        typer.Option(help="Polygon or closed curves in 2D; again for each hole.", show_default=False),
    ],
    scale: Annotated[str, typer.Option(help="The profile's scale: a number, or a column of PATH, s or #4.")] = "1",
    twist: Annotated[float, typer.Option(help="The turn of the profile over the whole path, in degrees.")] = 0.0,
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
    """Sweep a profile along points or a curve, and write a mesh to .stl .3mf .ply .glb .obj, a solid to .step .brep."""
    import math

    from cadfit.methods import How
    from cadfit.stages import stage
    from cadfit.sweeping.profile import Profile
    from cadfit.sweeping.sweep import sweep as meshed

    with timed(verbose):
        swept = Swept.to(source, output, caps, on_self_intersection)
        loops = [_loop(path, unit.value) for path in profile]
        with about(profile[0]):
            shape = Profile.of(*loops)
        with about(source):
            size: Any = number_or_name(scale)
            how = How(method, closed, tension, curvature, fit)
            way = way_in(source, how, unit.value, quiet, None if isinstance(size, float) else size)
            size = size if isinstance(size, float) else way.values
        with busy(f"sweeping along {source}", quiet) as progress, about(source):
            like: dict[str, Any] = {"scale": size, "twist": math.radians(twist), "up": up_of(up), "caps": caps.value}
            like["progress"] = progress

            def mesh() -> Any:
                answer: Any = on_self_intersection.value
                return meshed(way.curve, shape, tolerance, texture=texture, on_self_intersection=answer, **like)

            def solid() -> Any:
                from cadfit.occt import sweep_solid

                return sweep_solid(way.curve, shape, tolerance, **like)

            with stage("sweeping"):
                made = swept.made(mesh, solid)
        said = swept.write(made, unit, quiet)
    report(str(source), way.said | {"profile": ", ".join(map(str, profile))} | said, output, quiet)


def _loop(path: Path, unit: str) -> Any:
    """Return a polygon (n, 2) or curves in two dimensions; those of a flat 3D file are laid down."""
    import numpy as np

    from cadfit.files import Curves, read

    with about(path):
        found = read(path, unit)
        if isinstance(found, Curves):
            poles = np.concatenate([curve.poles for curve in found.curves])
            if found.dimension == 3 and np.ptp(poles[:, 2]) == 0.0:
                return [curve.transformed(np.eye(2, 3)) for curve in found.curves]
            return list(found.curves)
        if not isinstance(found, np.ndarray):
            raise ValueError("holds a mesh, which is no profile")
        return found[:, :2] if found.shape[1] == 3 and np.ptp(found[:, 2]) == 0.0 else found
