"""Points to test with: real curves where the corpus is at hand, a few of our own, and random splines.

The corpus is looked for at $CADFIT_CORPUS, then in ../shared/corpus beside the repository.
"""

import importlib.util
import os
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import strategies as st

from cadfit import BSpline, clean

BESIDE = Path(__file__).resolve().parents[2] / "shared" / "corpus"
FOLDER = Path(os.environ.get("CADFIT_CORPUS", BESIDE))


class Shape(NamedTuple):
    """Points without repeats, and whether they close."""

    points: np.ndarray
    closed: bool

    @property
    def size(self):
        return np.linalg.norm(np.ptp(self.points, axis=0))

    @property
    def reach(self):
        """The largest coordinate, which float64 rounding goes by."""
        return np.abs(self.points).max()


@cache
def _corpus():
    spec = importlib.util.spec_from_file_location("cadfit_corpus", FOLDER / "corpus.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


ABSENT = f"no corpus at {FOLDER} (CADFIT_CORPUS names another place)"
PRESENT = (FOLDER / "corpus.py").is_file()


@cache
def _family(name):
    return _corpus().load(family=name)


def with_corners(*families):
    """The corpus' curves of these families whose corners are known, and the rows of those."""
    if not PRESENT:
        pytest.skip(ABSENT)
    members = [curve for family in families for curve in _family(family)]
    return [(curve, np.array(curve.meta["corners"], dtype=int)) for curve in members if "corners" in curve.meta]


def curves(per_family=3, max_points=2000, families=None):
    """Parameters for pytest: `per_family` cleaned real curves of each family; without a corpus, one that is skipped.

    With CADFIT_QUICK=1 in the environment every second of them.
    """
    if not PRESENT:
        return [pytest.param(None, id="corpus", marks=pytest.mark.skip(reason=ABSENT))]
    found = []
    for family in families or _corpus().families():
        members = [curve for curve in _family(family) if max_points is None or len(curve.points) <= max_points]
        for k in np.unique(np.linspace(0, len(members) - 1, min(per_family, len(members))).astype(int)):
            cleaned = clean(members[k].points, closed=members[k].closed)
            found.append(pytest.param(Shape(cleaned.points, cleaned.closed), id=f"{family}-{members[k].name}"))
    return found[:: 2 if os.environ.get("CADFIT_QUICK") else 1]


OWN = {
    "two": Shape(np.array([[1.0, 2.0], [4.0, 6.0]]), False),
    "three": Shape(np.array([[0.0, 0.0, 1.0], [2.0, 1.0, 1.0], [3.0, -1.0, 0.5]]), False),
    "triangle": Shape(np.array([[0.0, 0.0], [4.0, 0.0], [1.0, 3.0]]), True),
    "hook": Shape(
        np.array([[0, 0], [3, 0.5], [6, 0], [8.5, -1.5], [9, -4], [7, -5.5], [4.5, -5], [4, -3.5], [5, -3]], float),
        False,
    ),
    "leaf": Shape(
        np.array([[10, 0], [7, 1.1], [4, 1.9], [2, 1.8], [0.5, 1], [0, 0], [0.6, -0.7], [3, -0.9], [6, -0.4]]), True
    ),
    "bent wire": Shape(
        np.array([[0, 0, 0], [0, 0, 5], [0.5, 0, 7], [2, 0, 8], [6, 0, 8], [7.5, 1, 8], [8, 3, 8], [8, 3, 2]], float),
        False,
    ),
    "there and back": Shape(np.array([[0.0, 0.0], [5.0, 0.0], [3.0, 0.0], [9.0, 1.0], [9.0, 4.0], [9.0, 2.0]]), False),
    "line in 1D": Shape(np.array([[0.0], [1.0], [3.0], [2.5], [7.0], [7.5]]), False),
    "crowded": Shape(
        np.array([[0, 0], [10, 0], [10.01, 0.01], [10.02, 0.03], [10.02, 8], [4, 8], [4, 8.004], [4, 12]], float), False
    ),
}


def own():
    return [pytest.param(shape, id=name) for name, shape in OWN.items()]


def shapes(per_family=2, max_points=2000):
    """Our own shapes, then the corpus' curves."""
    return own() + curves(per_family, max_points)


def turn(n, radius=1.0):
    """n points on a circle, the first at (radius, 0), not repeated."""
    angle = 2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@st.composite
def splines(draw, dimensions=(1, 2, 3, 4), spans=(1, 2, 3, 5, 8, 30), unevenness=(0, 1, 3)):
    """Valid splines: any multiplicities, spans differing by up to 10**(2 * unevenness), poles rough or on a grid."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    d = draw(st.sampled_from(dimensions))
    multiplicities = rng.integers(1, draw(st.integers(2, 4)), draw(st.sampled_from(spans)) - 1)
    spread = draw(st.sampled_from(unevenness))
    start = draw(st.sampled_from([0.0, -1.5, 100.0]))
    distinct = start + np.concatenate([[0.0], 10.0 ** rng.uniform(-spread, spread, len(multiplicities) + 1)]).cumsum()
    knots = np.repeat(distinct, [4, *multiplicities, 4])
    shape = (len(knots) - 4, d)
    on_grid = draw(st.booleans())  # equal poles, straight runs, cusps
    poles = rng.integers(-2, 3, shape).astype(float) if on_grid else rng.normal(size=shape)
    return BSpline(poles, knots)


@st.composite
def point_rows(draw, dimensions=(1, 2, 3, 4, 5, 6, 7, 8), least=2, most=14, rough=True):
    """Random points (n, d), neighbours (the last and the first, too) distinct; rough ones differ in spacing."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, d = draw(st.integers(least, most)), draw(st.sampled_from(dimensions))
    steps = rng.normal(size=(n, d))
    if rough and draw(st.booleans()):
        steps *= 10.0 ** rng.uniform(-2, 1, (n, 1))
    return steps.cumsum(axis=0)


def rotation(d, seed):
    """A random orthogonal matrix (d, d)."""
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(d, d)))[0]
