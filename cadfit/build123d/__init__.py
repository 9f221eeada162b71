"""cadfit in build123d: fitted splines as line, sketch and part objects, edges, wires and faces from curves and back.

Works with build123d 0.12 and newer, in builders on any plane, in algebra mode and with every `Mode`. Importing this
module without build123d is an ImportError that names the extra.

Example::

    from build123d import BuildLine, BuildPart, BuildSketch, Plane, extrude, make_face
    from cadfit.build123d import FitSpline

    with BuildPart() as wing:
        with BuildSketch(Plane.XZ):
            with BuildLine():
                outline = FitSpline(points, tolerance=0.02, closed=True)
            make_face()
        extrude(amount=300)
    print(outline.fit.deviation.points, outline.fit.poles)
"""

try:
    import build123d  # noqa: F401
except ModuleNotFoundError as error:
    if error.name != "build123d":  # it is there, and what it needs is not
        raise
    raise ImportError("cadfit.build123d needs build123d: pip install 'cadfit[build123d]'") from error

from cadfit.build123d.lines import CardinalSpline, FitSpline, LocalSpline
from cadfit.build123d.shapes import from_edge, simplify, to_edge, to_face, to_wire
from cadfit.build123d.solids import FitProfile, FitTube

__all__ = [
    "CardinalSpline",
    "FitProfile",
    "FitSpline",
    "FitTube",
    "LocalSpline",
    "from_edge",
    "simplify",
    "to_edge",
    "to_face",
    "to_wire",
]
