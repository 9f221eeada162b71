import numpy as np
import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

import cadfit
from cadfit.occt.approximating import approximate
from cadfit.report.compare import by_method

X = np.linspace(0, 9, 60)
SPACE = np.column_stack([X, np.sin(X), np.cos(X)])


@pytest.mark.parametrize("points", [SPACE, SPACE[:, :2]], ids=["3D", "2D"])
def test_the_kernels_own_fit(points):
    spline = approximate(points, 0.01)
    assert spline.poles.shape[1] == points.shape[1]
    assert spline.multiplicities[1:-1].max(initial=1) == 1
    entry = by_method("occt", points, 0.01)
    assert entry.fit.spline.isclose(spline, 0.0)
    assert entry.fit.deviation.points == cadfit.deviation(spline, points).points < 0.02
    assert entry.seconds > 0


def test_other_dimensions_are_refused():
    with pytest.raises(ValueError, match="not in 5D"):
        approximate(np.random.default_rng(0).normal(size=(9, 5)), 0.1)
