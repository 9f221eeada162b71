"""What `hosts.py` asks of the hosts: for each operation its shape, and the size it should have.

Profiles are plane closed curves that do not cross themselves; all others are paths. What goes along a curve at a
distance (offset, fillet, sweep of a circle, tube) is asked for at half of its smallest radius, 0.2 at most; not where
that is below 0.005, a twentieth of the tolerance of the fit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

import cadfit
from cadfit.occt.measuring import volume_and_area
from cadfit.regions import meeting, polygon, signed_area
from cadfit.sweeping.chain import chain, tightest

SIZE, TOLERANCE = 100.0, 0.1
HEIGHT, AWAY, ABOVE, SHRUNK = (
    5.0,
    20.0,
    20.0,
    0.8,
)  # of extrusions; from the axis; of a profile's loft, its sections' ratio
WIDEST, LEAST = 0.2, 0.005
RIGHT = 0.01  # how far, of it, a size may be from what is right
DIGITS = 1e-12 * SIZE  # of coordinates in a host's STEP


class Wrong(Exception):
    """A result that is not valid, or not of the right size."""


@dataclass(frozen=True)
class Case:
    """A curve of the corpus and what is asked of it."""

    name: str
    fit: cadfit.Fit

    @cached_property
    def curve(self):
        """The parts joined."""
        return cadfit.join(self.fit.curves)

    @cached_property
    def length(self):
        """Of the curve."""
        return self.curve.length()

    @cached_property
    def area(self):
        """Within the curve."""
        return abs(signed_area(self.curve.pieces()))

    @cached_property
    def samples(self):
        """Places (n, 3) along the curve, as many in each span."""
        knots = self.curve.distinct_knots
        u = np.interp(np.linspace(0, len(knots) - 1, 40 * (len(knots) - 1) + 1), np.arange(len(knots)), knots)
        places = self.curve(u)
        return np.column_stack([places, np.zeros((len(u), 3 - places.shape[1]))])

    @cached_property
    def small(self):
        """A radius, or a distance, for what goes along the curve."""
        lifted = self.curve.transformed(np.eye(3, self.curve.poles.shape[1]))
        return 0.5 * min(2.0 * WIDEST, tightest(chain(lifted), 2.0 * WIDEST)[1])

    @cached_property
    def plane(self):
        """Whether it is in 2D."""
        return self.fit.points.shape[1] == 2

    @cached_property
    def kind(self):
        """What it is good for."""
        return "profile" if self.fit.closed and self.plane and meeting([self.curve.pieces()]) is None else "path"

    @property
    def operations(self):
        """What is asked of it, by name."""
        left_out = set(ALONG[self.kind]) if self.small < LEAST else set()
        if self.kind == "path" and (not self.plane or self.fit.closed or crosses(self.samples[:, :2])):
            left_out.add("offset")
        return {name: make for name, make in OPERATIONS[self.kind].items() if name not in left_out}


# Whether a shape is right


def judge(made, measures, wanted, share):
    """Raise Wrong unless a shape is valid and one of the ways to measure it says what is right.

    The kernel's ways err, each on shapes of another kind: by 20 % on extruded and revolved splines, by 10 % on meshes
    of its sweeps.
    """
    if not BRepCheck_Analyzer(made.wrapped).IsValid():
        raise Wrong("not valid")
    found = []
    for measure in measures:
        found.append(measure(made))
        if abs(found[-1] - wanted) <= share * abs(wanted):
            return
    raise Wrong(f"another size: {', '.join(f'{each / wanted:.3g}' for each in found)} of it")


def quick(properties, *options):
    def measure(shape):
        found = GProp_GProps()
        properties(shape.wrapped, found, *options)
        return abs(found.Mass())

    return measure


def by_gauss(shape):
    try:
        return volume_and_area(shape.wrapped)[1]
    except ValueError:  # a cut face
        return np.nan


def within_triangles(shape):
    places, triangles = shape.tessellate(0.05, 0.2)
    a, b, c = np.array([place.wrapped.Coord() for place in places])[np.array(triangles).T]
    return float(abs(np.einsum("nd,nd->", a, np.cross(b, c))) / 6.0)


lengths = (quick(BRepGProp.LinearProperties_s),)
areas = (quick(BRepGProp.SurfaceProperties_s), by_gauss, quick(BRepGProp.SurfaceProperties_s, 1e-4))
volumes = (
    quick(BRepGProp.VolumeProperties_s, 1e-6),
    quick(BRepGProp.VolumePropertiesGK_s, 1e-4, False, False, False, False, False),
    within_triangles,
)


# What each operation makes: the shape, how to measure it, what is right, and how far, of it, it may be from that.


def face(host, case):
    made = host.face(case.fit)
    outline = abs(signed_area(polygon(case.fit.points)))
    far = max(case.fit.deviation.points, case.fit.deviation.between)
    if abs(case.area - outline) > far * case.length:
        raise Wrong(f"another size: {case.area / outline:.3g} of its polygon's")
    return made, areas, case.area, 1e-3


def extrude(host, case):
    return host.extruded(host.face(case.fit), (0.0, 0.0, HEIGHT)), volumes, HEIGHT * case.area, RIGHT


def revolve(host, case):
    axis = case.curve.poles[:, 0].min() - AWAY
    around = 2.0 * np.pi * (middle(case)[0] - axis)
    return host.revolved(host.face(case.fit), axis), volumes, around * case.area, RIGHT


def offset(host, case):
    more = case.small * case.length + np.pi * case.small**2
    share = 0.1 * more / case.area  # of what is added; at a concave corner it is less
    return host.offset(host.wire(case.fit), case.small), areas, case.area + more, share


def fillet(host, case):
    solid = host.extruded(host.face(case.fit), (0.0, 0.0, HEIGHT))
    less = (1.0 - np.pi / 4.0) * case.small**2 * case.length
    return host.filleted(solid, HEIGHT, case.small), volumes, HEIGHT * case.area - less, RIGHT


def loft(host, case):
    above = [curve.transformed(SHRUNK * np.eye(3, 2), (0.0, 0.0, ABOVE)) for curve in case.fit.curves]
    made = host.lofted([host.wire(case.fit), host.wire(above)], True)
    return made, volumes, ABOVE / 3.0 * (1.0 + SHRUNK + SHRUNK**2) * case.area, RIGHT


def sweep(host, case):
    turn = np.linspace(0.0, 0.5, 9)
    spine = cadfit.fit(4.0 * SIZE * np.column_stack([1.0 - np.cos(turn), 0.0 * turn, np.sin(turn)]), 1e-4)
    centred = [curve.transformed(np.eye(2), -middle(case)) for curve in case.fit.curves]
    return host.swept(host.face(centred), host.wire(spine)), volumes, spine.spline.length() * case.area, RIGHT


def wire(host, case):
    made = host.wire(case.fit)
    if made.wrapped.Closed() != case.fit.closed:
        raise Wrong("not closed" if case.fit.closed else "closed")
    return made, lengths, case.length, 1e-3


def extrude_path(host, case):
    return host.extruded(host.wire(case.fit), across(case)), areas, strip(case, across(case)), RIGHT


def revolve_path(host, case):
    axis = case.curve.poles[:, 0].min() - AWAY
    return host.revolved(host.wire(case.fit), axis), areas, turned(case, axis), RIGHT


def offset_path(host, case):
    wanted = 2.0 * case.small * case.length + np.pi * case.small**2
    return host.offset(host.wire(case.fit), case.small), areas, wanted, 0.1


def loft_path(host, case):
    lifted = np.eye(3, case.curve.poles.shape[1])
    above = [curve.transformed(lifted, across(case)) for curve in case.fit.curves]
    return host.lofted([host.wire(case.fit), host.wire(above)], False), areas, strip(case, across(case)), RIGHT


def sweep_path(host, case):
    disc = host.disc(case.samples[0], case.samples[1] - case.samples[0], case.small)
    return host.swept(disc, host.wire(case.fit)), volumes, np.pi * case.small**2 * case.length, RIGHT


def tube(host, case):
    made = host.tube(case.fit, case.small, 0.05 * case.small)
    return made, volumes, np.pi * case.small**2 * case.length, RIGHT


def step(host, case):
    made = host.wire(case.fit)
    back = host.there_and_back(made)
    if len(back) != len(case.fit.curves):
        raise Wrong("other edges")
    for ours in case.fit.curves:
        poles = ours.transformed(np.eye(3, ours.poles.shape[1])).poles
        same = [each for each in back if len(each.poles) == len(poles)]
        if not any(np.abs(each.poles - poles).max() < DIGITS for each in same):
            raise Wrong("other poles")
    return made, lengths, case.length, 1e-3


OPERATIONS = {
    "profile": {
        "face": face, "extrude": extrude, "revolve": revolve, "offset": offset, "fillet": fillet, "loft": loft,
        "sweep": sweep, "STEP": step,
    },
    "path": {
        "wire": wire, "extrude": extrude_path, "revolve": revolve_path, "offset": offset_path, "loft": loft_path,
        "sweep": sweep_path, "tube": tube, "STEP": step,
    },
}  # fmt: skip


def middle(case):
    """Return the centroid (2,) of what a profile encloses."""
    a, b = case.samples[:, :2], np.roll(case.samples[:, :2], -1, axis=0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return ((a + b) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())


def crosses(places):
    """Whether segments of a chain of places (n, 2) that are not neighbours cross."""
    a, b = places[:-1], places[1:]
    for k in range(2, len(a)):
        p, q, step = a[: k - 1], b[: k - 1], b[k] - a[k]
        sides = [step[0] * (end - a[k])[:, 1] - step[1] * (end - a[k])[:, 0] for end in (p, q)]
        legs = q - p
        ours = [legs[:, 0] * (end - p)[:, 1] - legs[:, 1] * (end - p)[:, 0] for end in (a[k], b[k])]
        if ((sides[0] * sides[1] < 0.0) & (ours[0] * ours[1] < 0.0)).any():
            return True
    return False


def across(case):
    """Return where to extrude a path, or loft it to: out of its plane, or aslant."""
    return (0.0, 0.0, HEIGHT) if case.plane else (3.0, 4.0, 5.0)


def strip(case, across):
    """Return the area that a curve sweeps out across."""
    return float(np.linalg.norm(np.cross(np.diff(case.samples, axis=0), across), axis=1).sum())


def turned(case, axis):
    """Return the area of a curve turned about the line x = axis, z = 0."""
    legs, middles = np.diff(case.samples, axis=0), 0.5 * (case.samples[1:] + case.samples[:-1])
    radial = np.hypot(middles[:, 0] - axis, middles[:, 2])
    rate = ((middles[:, 0] - axis) * legs[:, 0] + middles[:, 2] * legs[:, 2]) / radial
    return float(2 * np.pi * (radial * np.hypot(rate, legs[:, 1])).sum())


ALONG = {"profile": ("offset", "fillet"), "path": ("offset", "sweep", "tube")}  # at the distance `small`
