import numpy as np
import pytest
from numpy.testing import assert_allclose

import cadfit
from cadfit.fitting.along import off_chords, off_points
from cadfit.fitting.judging import judged, straying

T = np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
RING = np.column_stack([3.0 * np.cos(T), 2.0 * np.sin(T)])
OPEN = np.column_stack([t := np.linspace(0, 9, 120), np.sin(t)])


@pytest.mark.parametrize("turned", [0, 30, 89])
def test_a_closed_curve_may_start_anywhere(turned):
    fit = cadfit.fit(RING, 0.01, closed=True)
    found = judged(fit.curves, np.roll(RING, turned, axis=0), closed=True, tolerance=0.01)
    assert found.closed
    assert found.deviation.points == pytest.approx(fit.deviation.points, rel=1e-3)
    off = np.linalg.norm(off_points(found), axis=1)
    assert off.max() <= found.deviation.points * (1.0 + 1e-12)
    assert off.max() >= found.deviation.points * 0.99
    assert off_chords(found)[1].max() <= found.deviation.between * (1.0 + 1e-12)
    assert np.count_nonzero(np.diff(found.parameters) < 0.0) <= 1


def test_an_open_curve_round_a_contour_ends_at_the_first_point():
    curve = cadfit.fit(np.append(RING, RING[:1], axis=0), 0.01, closed=False).spline
    short = curve.split(0.999 * curve.domain[1])[0]
    found = judged(short, RING, closed=True)
    assert not found.closed
    assert len(found.points) == 91
    assert found.deviation.points == pytest.approx(np.linalg.norm(short.poles[-1] - RING[0]), rel=1e-3)


def test_what_strays_between_points():
    assert len(straying(judged(cadfit.fit(OPEN, 1e-3).curves, OPEN), 1e-3)) == 0
    assert len(straying(judged(cadfit.fit(RING, 1e-3, closed=True).curves, RING, closed=True), 1e-3)) == 0
    spline = cadfit.interpolate(OPEN)
    bumped = spline.poles.copy()
    bumped[50] += [0.0, 0.05]  # one pole: a few chords about it
    bump = judged(cadfit.BSpline(bumped, spline.knots), OPEN)
    rows = straying(bump, 1e-3)
    assert 1 <= len(rows) <= 8
    assert_allclose(rows, 49, atol=6)


def test_repeats_are_dropped_and_counted():
    found = judged(cadfit.interpolate(OPEN), np.repeat(OPEN, 2, axis=0), call="by hand")
    assert (len(found.points), len(found.cleaned), found.call) == (120, 120, "by hand")
    assert found.deviation.points < 1e-12
