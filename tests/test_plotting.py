import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import cadfit
from cadfit import BSpline
from cadfit.plotting import curvature_comb, plot_comb, plot_deviation, plot_fit, plot_spline

matplotlib.use("agg")
from matplotlib import pyplot as plt

TURN = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
RING = cadfit.local_spline(5.0 * np.column_stack([np.cos(TURN), np.sin(TURN)]), closed=True)
T = np.linspace(0.0, 12.0, 80)
HELIX = cadfit.local_spline(np.column_stack([2.0 * np.cos(T), 2.0 * np.sin(T), 0.5 * T]))
WIGGLE = cadfit.local_spline([[0, 0], [1, 3], [1.1, 3], [9, -2], [9, 7], [40, 0]])
LINE = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])


@pytest.fixture(autouse=True)
def _no_figures_left():
    yield
    plt.close("all")


def drawn(ax, label):
    (line,) = [line for line in ax.get_lines() if line.get_label() == label]
    return np.column_stack(line.get_data_3d() if hasattr(ax, "get_zlim") else line.get_data())


def test_comb_of_a_circle_is_a_circle_outside():
    feet, tips = curvature_comb(RING, count=101, scale=10.0)
    assert_allclose(np.linalg.norm(feet, axis=1), 5.0, atol=1e-5)
    assert_allclose(np.linalg.norm(tips, axis=1), 5.0 + 10.0 / 5.0, atol=5e-3)
    assert_allclose(np.einsum("nd,nd->n", tips - feet, feet), 10.0, atol=3e-2)


def test_comb_in_space_stands_against_the_curvature_vector():
    feet, tips = curvature_comb(HELIX, count=200, scale=3.0)
    u, distance = HELIX.nearest(feet)
    assert distance.max() < 1e-6
    assert_allclose(tips - feet, -3.0 * HELIX.curvature(u), atol=1e-5)
    inner = slice(10, -10)  # the ends' estimates are one-sided
    assert_allclose(np.linalg.norm(tips - feet, axis=1)[inner], 3.0 * 2.0 / (2.0**2 + 0.5**2), rtol=1e-3)


@pytest.mark.parametrize("spline", [RING, HELIX, WIGGLE], ids=["ring", "helix", "wiggle"])
def test_feet_are_equally_far_apart_along_the_curve(spline):
    feet, _ = curvature_comb(spline, count=50)
    u, _ = spline.nearest(feet[1:-1])
    lengths = []
    rest, start = spline, 0.0
    for each in u:
        part, rest = rest.split(float(each))
        start = part.length()
        lengths.append(start)
    assert_allclose(lengths, spline.length() / 49, rtol=5e-3)
    assert_array_equal(feet[[0, -1]], spline(list(spline.domain)))


@pytest.mark.parametrize("spline", [RING, HELIX, WIGGLE], ids=["ring", "helix", "wiggle"])
def test_without_a_scale_the_longest_tooth_is_a_fifth_of_the_size(spline):
    feet, tips = curvature_comb(spline, count=5000)
    longest = np.linalg.norm(tips - feet, axis=1).max()
    assert 0.15 * spline.size < longest <= 0.2 * spline.size * (1 + 1e-3)


def test_a_line_has_no_teeth():
    feet, tips = curvature_comb(LINE)
    assert_array_equal(feet, tips)
    assert_allclose(np.diff(feet[:, 0]), 3.0 / 299)


@pytest.mark.parametrize("spline", [RING, HELIX, WIGGLE], ids=["ring", "helix", "wiggle"])
def test_what_is_drawn(spline):
    points = spline(np.linspace(*spline.domain, 7))
    ax = plot_spline(spline, points=points, scale=0.5)
    assert_array_equal(drawn(ax, "points"), points)
    assert_array_equal(drawn(ax, "poles"), spline.poles)
    curve, comb = drawn(ax, "curve"), drawn(ax, "curvature comb")
    # A certified bound: nowhere is the curve farther from the line drawn for it.
    assert cadfit.deviation(spline, curve).between < 1.1e-4 * spline.size
    assert_allclose(np.linalg.norm(comb - curve, axis=1)[1:-1].max(), 0.5 * _largest(spline), rtol=0.02)
    low, high = comb.min(axis=0), comb.max(axis=0)
    limits = np.array(
        [ax.get_xlim(), ax.get_ylim(), ax.get_zlim()] if spline is HELIX else [ax.get_xlim(), ax.get_ylim()]
    )
    assert np.all(limits[:, 0] <= low)
    assert np.all(limits[:, 1] >= high)


def _largest(spline):
    return np.linalg.norm(spline.curvature(np.linspace(*spline.domain, 100_001)), axis=1).max()


def test_one_unit_is_as_long_on_every_axis():
    ax = plot_spline(WIGGLE)
    ax.figure.canvas.draw()
    across, up = ax.transData.transform([[1, 0], [0, 1]]) - ax.transData.transform([0, 0])
    assert_allclose(across[0], up[1])
    ax = plot_spline(HELIX)
    ranges = [np.ptp(limits()) for limits in (ax.get_xlim, ax.get_ylim, ax.get_zlim)]
    shares = ax._box_aspect  # has no public name
    assert_allclose(np.divide(shares, ranges), shares[0] / ranges[0])


def test_parts_left_out_and_axes_given():
    _, ax = plt.subplots()
    assert plot_spline(RING, ax, poles=False, comb=False) is ax
    assert [line.get_label() for line in ax.get_lines()] == ["curve"]
    plot_spline(WIGGLE, ax, comb=False)
    assert [line.get_label() for line in ax.get_lines()] == ["curve", "curve", "poles"]


def test_many_spans_are_drawn_quickly_and_once():
    points = np.random.default_rng(1).normal(size=(20_000, 2)).cumsum(axis=0)
    spline = cadfit.local_spline(points)
    curve = drawn(plot_spline(spline, comb=False, poles=False), "curve")
    assert len(curve) == 8 * (len(spline.distinct_knots) - 1) + 1


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: plot_spline(BSpline(np.arange(4.0)[:, None], LINE.knots)), "not in 1D"),
        (lambda: plot_spline(BSpline(np.eye(4), LINE.knots)), "not in 4D"),
        (lambda: plot_spline(LINE, points=[[0, 0, 0]]), "the points have 3 coordinates, the curve 2"),
        (lambda: plot_spline(LINE, points=[[0, np.nan]]), "row 0 of the points is not finite"),
        (lambda: plot_spline(HELIX, plt.subplots()[1]), "a 3D spline needs 3D axes: .*projection"),
        (lambda: plot_spline(LINE, plt.subplots(subplot_kw={"projection": "3d"})[1]), "a 2D spline needs 2D axes"),
        (lambda: plot_spline(LINE, scale=np.inf), "must be finite, not inf"),
        (lambda: curvature_comb(LINE, count=1), "at least 2 teeth, not 1"),
    ],
)
def test_mistakes(call, message):
    with pytest.raises(ValueError, match=message):
        call()


SQUARE = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1.0]])
CORNERED = cadfit.fit(SQUARE, 0.01, closed=True)
SPACE = cadfit.fit(HELIX(np.linspace(*HELIX.domain, 200)), 0.02)


@pytest.mark.parametrize("fit", [CORNERED, SPACE], ids=["cornered", "in space"])
def test_a_fit_is_drawn_whole(fit):
    ax = fit.plot(comb=True, unit="mm")
    assert_array_equal(drawn(ax, "points"), fit.points)
    assert_array_equal(drawn(ax, "poles"), fit.curves[0].poles)
    curves = [line for line in ax.get_lines() if line.get_color() == "#0072B2"]
    assert len(curves) == len(fit.curves)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (mm)", "y (mm)")
    assert f"{fit.poles} poles for {len(fit.points)} points: off by at most" in ax.get_title()
    named = [text.get_text() for text in ax.get_legend().get_texts()]
    assert named == ["curvature comb", "curve", "poles", "points", *["corners"] * (fit is CORNERED)]
    if fit is CORNERED:
        assert_array_equal(drawn(ax, "corners"), fit.points[fit.corners])


def test_axes_given_are_named_but_not_titled():
    _, ax = plt.subplots()
    assert plot_fit(CORNERED, ax, points=False, poles=False) is ax
    assert (ax.get_title(), ax.get_legend(), ax.get_xlabel()) == ("", None, "x")


def test_deviation_is_drawn_with_the_tolerance_and_the_worst_point():
    ax = SPACE.plot_deviation(unit="mm")
    s, off = drawn(ax, "points").T
    assert len(off) == len(SPACE.points)
    assert off.max() == pytest.approx(SPACE.deviation.points, rel=1e-3)
    assert s[-1] == pytest.approx(SPACE.spline.length(), rel=1e-6)
    assert_allclose(drawn(ax, "tolerance 0.02")[:, 1], 0.02)
    (worst,) = drawn(ax, f"point {SPACE.deviation.worst}: {SPACE.deviation.points:.3g}")
    assert_array_equal(worst, [s[SPACE.deviation.worst], off[SPACE.deviation.worst]])
    assert ax.get_ylabel() == "deviation (mm)"
    dominant = cadfit.fit_dominant(SPACE.points, fraction=0.5)
    assert not [line for line in plot_deviation(dominant).get_lines() if "tolerance" in line.get_label()]


def test_combs_of_several_curves_are_on_one_scale():
    small, large = RING, RING.transformed(3.0 * np.eye(2))
    lines = [line.get_xydata() for line in plot_comb([small, large]).get_lines() if len(line.get_xydata()) == 900]
    teeth = [np.linalg.norm(each[1::3] - each[::3], axis=1).max() for each in lines]
    assert teeth[0] == pytest.approx(3.0 * teeth[1], rel=1e-6)
    assert teeth[0] == pytest.approx(0.2 * large.size, rel=1e-2)


def test_a_fit_in_other_dimensions_says_so():
    with pytest.raises(ValueError, match="not in 1D"):
        cadfit.fit([[0.0], [1.0], [3.0]], 0.1).plot()
    assert cadfit.fit([[0.0], [1.0], [3.0]], 0.1).plot_deviation().get_xlabel() == "length along the curve"


def test_without_matplotlib(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ImportError, match=r"cadfit\[plot\]"):
        SPACE.plot_deviation()
    with pytest.raises(ImportError, match=r"cadfit\[plot\]"):
        plot_spline(LINE)
    curvature_comb(LINE)  # numbers need no pictures


@pytest.mark.slow
def test_importing_it_imports_no_matplotlib():
    code = "import sys, cadfit.plotting; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
