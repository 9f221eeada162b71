"""Spline to kernel edge: `cadfit.occt.to_edge` against filling the kernel's arrays with a plain loop."""

from __future__ import annotations

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Pnt

from cadfit import BSpline
from cadfit.occt import to_edge
from cadfit.occt.kernel import Integers, Points, Reals

from timing import interleaved

SIZES = (1_000, 10_000, 100_000)
REPEATS = 9


def plain_edge(spline: BSpline) -> object:
    """Return the edge as the kernel's examples build it: one SetValue for each pole, knot and multiplicity."""
    poles = Points(1, len(spline.poles))
    for i, (x, y, z) in enumerate(spline.poles.tolist(), 1):
        poles.SetValue(i, gp_Pnt(x, y, z))
    distinct, often = spline.distinct_knots.tolist(), spline.multiplicities.tolist()
    knots, multiplicities = Reals(1, len(distinct)), Integers(1, len(distinct))
    for i, (knot, count) in enumerate(zip(distinct, often, strict=True), 1):
        knots.SetValue(i, knot)
        multiplicities.SetValue(i, count)
    return BRepBuilderAPI_MakeEdge(Geom_BSplineCurve(poles, knots, multiplicities, 3)).Edge()


def walk(n: int) -> BSpline:
    """Return a random walk of n poles."""
    poles = np.cumsum(np.random.default_rng(1).normal(size=(n, 3)), axis=0)
    return BSpline(poles, np.concatenate([[0.0] * 3, np.arange(n - 2), [n - 3.0] * 3]))


def table() -> str:
    """Return the comparison as a Markdown table."""
    lines = ["| poles | `to_edge` | plain `SetValue` loop | ratio |", "| ---: | ---: | ---: | ---: |"]
    for n in SIZES:
        spline = walk(n)
        calls = [lambda spline=spline: to_edge(spline), lambda spline=spline: plain_edge(spline)]
        ours, plain = interleaved(calls, REPEATS)
        lines.append(f"| {n:,} | {ours * 1e3:.2f} ms | {plain * 1e3:.2f} ms | {ours / plain:.2f} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
