"""cadfit in CadQuery: fitted splines on workplanes and in sketches, edges, wires and faces from curves and back.

Works with CadQuery 2.7 and newer. Importing this module without it is an ImportError that names the extra.

Example::

    import cadquery as cq
    import cadfit.cadquery

    cadfit.cadquery.register()  # adds Workplane.fitSpline and the others; importing never does
    wing = cq.Workplane("XZ").fitSpline(points, 0.02).close().extrude(300)

    outline = cadfit.cadquery.fit_spline(points, 0.02)  # the same without register, and with the report of the fit
    wing = cq.Workplane("XZ").invoke(outline).close().extrude(300)
    print(outline.fit.deviation.points)
"""

try:
    import cadquery  # noqa: F401
except ImportError as error:
    raise ImportError("cadfit.cadquery needs CadQuery: pip install 'cadfit[cadquery]'") from error

from cadfit.cadquery.free import fit_edge, fit_face, fit_tube, fit_wire, simplify
from cadfit.cadquery.plugins import draw, fit_profile, fit_spline, register
from cadfit.cadquery.shapes import from_edge, to_edge, to_face, to_wire
from cadfit.cadquery.sketch import Sketch
from cadfit.cadquery.workplane import Workplane

__all__ = [
    "Sketch",
    "Workplane",
    "draw",
    "fit_edge",
    "fit_face",
    "fit_profile",
    "fit_spline",
    "fit_tube",
    "fit_wire",
    "from_edge",
    "register",
    "simplify",
    "to_edge",
    "to_face",
    "to_wire",
]
