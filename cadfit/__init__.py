"""cadfit: ordered points to B-splines a CAD program can trust.

The public names; each is imported from its module when first used, so `import cadfit` is quick and brings in
neither a CAD kernel nor a mesh or plotting library.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cadfit.arcing.approximate import arcs as arcs
    from cadfit.arcing.result import Arcs as Arcs
    from cadfit.batch import Batch as Batch
    from cadfit.batch import Failure as Failure
    from cadfit.batch import fit_many as fit_many
    from cadfit.bspline import BSpline as BSpline
    from cadfit.files import Curves as Curves
    from cadfit.files import read as read
    from cadfit.files import write as write
    from cadfit.fitting.approximate import fit as fit
    from cadfit.fitting.cardinal import c2_spline as c2_spline
    from cadfit.fitting.cardinal import cardinal_pieces as cardinal_pieces
    from cadfit.fitting.cardinal import cardinal_spline as cardinal_spline
    from cadfit.fitting.cardinal import pieces_to_spline as pieces_to_spline
    from cadfit.fitting.deviation import Deviation as Deviation
    from cadfit.fitting.deviation import deviation as deviation
    from cadfit.fitting.dominant import DominantPoints as DominantPoints
    from cadfit.fitting.dominant import dominant_points as dominant_points
    from cadfit.fitting.dominant_fit import fit_dominant as fit_dominant
    from cadfit.fitting.interpolate import interpolate as interpolate
    from cadfit.fitting.local import local_spline as local_spline
    from cadfit.fitting.planes import fit_planes as fit_planes
    from cadfit.fitting.planes import merge_planes as merge_planes
    from cadfit.fitting.result import Fit as Fit
    from cadfit.joining import join as join
    from cadfit.joining import periodic as periodic
    from cadfit.joining import polyline as polyline
    from cadfit.points.clean import clean as clean
    from cadfit.points.corners import find_corners as find_corners
    from cadfit.points.parametrize import parametrize as parametrize
    from cadfit.sweeping.frames import Frames as Frames
    from cadfit.sweeping.frames import frames as frames
    from cadfit.sweeping.frenet import frenet as frenet
    from cadfit.sweeping.profile import Profile as Profile
    from cadfit.sweeping.sweep import sweep as sweep
    from cadfit.sweeping.tube import tube as tube

_HOME = {
    "Arcs": "arcing.result",
    "BSpline": "bspline",
    "Batch": "batch",
    "Curves": "files",
    "Deviation": "fitting.deviation",
    "DominantPoints": "fitting.dominant",
    "Failure": "batch",
    "Fit": "fitting.result",
    "Frames": "sweeping.frames",
    "Profile": "sweeping.profile",
    "arcs": "arcing.approximate",
    "c2_spline": "fitting.cardinal",
    "cardinal_pieces": "fitting.cardinal",
    "cardinal_spline": "fitting.cardinal",
    "clean": "points.clean",
    "deviation": "fitting.deviation",
    "dominant_points": "fitting.dominant",
    "find_corners": "points.corners",
    "fit": "fitting.approximate",
    "fit_dominant": "fitting.dominant_fit",
    "fit_many": "batch",
    "fit_planes": "fitting.planes",
    "frames": "sweeping.frames",
    "frenet": "sweeping.frenet",
    "interpolate": "fitting.interpolate",
    "join": "joining",
    "local_spline": "fitting.local",
    "merge_planes": "fitting.planes",
    "parametrize": "points.parametrize",
    "periodic": "joining",
    "pieces_to_spline": "fitting.cardinal",
    "polyline": "joining",
    "read": "files",
    "sweep": "sweeping.sweep",
    "tube": "sweeping.tube",
    "write": "files",
}

__all__ = sorted(_HOME)
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name == "occt":
        return import_module("cadfit.occt")
    if name not in _HOME:
        raise AttributeError(f"module 'cadfit' has no attribute {name!r}")
    value = getattr(import_module(f"cadfit.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *_HOME, "occt"]
