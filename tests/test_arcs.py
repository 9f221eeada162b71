"""Lines and arcs within a tolerance of curves: held to samples both ways, and to a slow greedy search."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import cadfit
from cadfit.arcing.stretch import cut
from cadfit.arcing.within import bounds

import corpus_data
from made import Made


def around(n=600):
    return np.linspace(0, 2 * np.pi, n, endpoint=False)


def flower():
    r = 30 + 6 * np.cos(5 * around())
    return cadfit.fit(np.column_stack([r * np.cos(around()), r * np.sin(around())]), 1e-4, closed=True, effort="fast")


def wave():
    x = np.linspace(0, 1, 300)
    return cadfit.fit(np.column_stack([40 * x, 15 * np.sin(2 * np.pi * x)]), 1e-4, effort="fast")


def spiral():
    a = np.linspace(0, 6 * np.pi, 600)
    return cadfit.fit(np.column_stack([a * np.cos(a), a * np.sin(a)]) + 2 * a[:, None], 1e-4, effort="fast")


def plate():
    """A square with one rounded corner: three corners, lines, and a quarter of a circle."""
    t = np.linspace(0, np.pi / 2, 40)
    arc = np.column_stack([30 + 10 * np.cos(t), 30 + 10 * np.sin(t)])
    points = np.concatenate([[[0, 0]], np.column_stack([np.linspace(0, 40, 30), np.zeros(30)])[1:], arc, [[0, 40]]])
    return cadfit.fit(points, 1e-4, closed=True, between="polyline", effort="fast")


CURVES = Made(flower=flower, wave=wave, spiral=spiral, plate=plate)


def sampled(arcs, most=0.02):
    """Points of the arcs, close together."""
    return np.concatenate([
        arcs(k, np.linspace(0, 1, 2 + int(arcs.lengths[k] / most))) for k in range(len(arcs))
    ])  # fmt: skip


def distance(curves, arcs):
    """The larger of both one-sided distances, from samples: never above the truth by more than their spacing."""
    points = sampled(arcs)
    there = np.min([curve.nearest(sampled(arcs, 0.4))[1] for curve in curves], axis=0).max()
    on_curve = np.concatenate([curve(np.linspace(*curve.domain, 4000)) for curve in curves])
    radial = cKDTree(points).query(on_curve)[0].max()
    return there, radial


def directions(arcs):
    """The directions at the starts and the ends."""
    found = []
    for end in (arcs.starts, arcs.ends):
        arm = arcs.flat(end) - arcs.centres
        turned = np.column_stack([-arm[:, 1], arm[:, 0]]) * np.sign(arcs.sweeps)[:, None]
        along = np.where(arcs.is_line[:, None], arcs.flat(arcs.ends - arcs.starts), turned)
        found.append(np.arctan2(along[:, 1], along[:, 0]))
    return found


def turns(arcs):
    """How much the direction jumps at the start of each."""
    begin, end = directions(arcs)
    jump = begin - np.roll(end, 1)
    return np.abs((jump + np.pi) % (2 * np.pi) - np.pi)


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("tolerance", [0.1, pytest.param(0.01, marks=pytest.mark.slow)])
def test_within_the_tolerance_both_ways_joined_and_smooth(name, tolerance):
    fit = CURVES[name]
    arcs = cadfit.arcs(fit, tolerance)
    there, back = distance(fit.curves, arcs)
    assert there <= arcs.deviation <= tolerance
    assert back <= np.hypot(arcs.deviation, 0.01)
    assert arcs.deviation <= 1.02 * max(there, back), "the bound is near a distance that occurs"
    assert np.array_equal(arcs.ends[:-1], arcs.starts[1:])
    assert arcs.closed == fit.closed == np.array_equal(arcs.ends[-1], arcs.starts[0])
    smooth = np.setdiff1d(np.arange(not arcs.closed, len(arcs)), arcs.corners)
    lines = np.flatnonzero(arcs.is_line)
    free = np.setdiff1d(smooth, np.concatenate([lines, lines + 1]))
    assert turns(arcs)[free].max(initial=0.0) < 1e-9
    assert np.all(np.abs(arcs.sweeps) <= np.pi + 1e-12)
    away = np.linalg.norm(arcs.ends - arcs.centres, axis=1)[~arcs.is_line]
    assert away == pytest.approx(arcs.radii[~arcs.is_line], rel=1e-9)


def test_a_seam_from_which_no_chain_closes_is_moved():
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    ellipse = cadfit.fit(np.column_stack([10 * np.cos(turn), 3 * np.sin(turn)]), 1e-4, closed=True)
    arcs = cadfit.arcs(ellipse, 0.009)  # the seam is where it bends most
    there, back = distance(ellipse.curves, arcs)
    assert there <= arcs.deviation <= 0.009
    assert back <= np.hypot(arcs.deviation, 0.01)
    assert arcs.closed
    assert np.array_equal(arcs.ends, np.roll(arcs.starts, -1, axis=0))
    assert turns(arcs).max() < 1e-9
    assert len(arcs) <= 18


def test_corners_are_kept():
    fit = CURVES["plate"]
    arcs = cadfit.arcs(fit, 0.01)
    assert len(fit.corners) == 3
    assert len(arcs) <= 7
    corners = {tuple(np.round(fit.points[k], 9)) for k in fit.corners}
    assert {tuple(np.round(arcs.starts[k], 9)) for k in arcs.corners} == corners
    straight = cadfit.arcs(cadfit.fit([[0, 0], [3, 0], [3, 2]], 1e-3, between="polyline"), 1e-3)
    assert straight.is_line.all()
    assert straight.starts.tolist() == [[0, 0], [3, 0]]
    assert straight.deviation < 1e-12
    assert repr(straight).startswith("Arcs(open, 0 arcs and 2 lines, deviation ")


def greedy(curve, tolerance, n=900):
    """The number of arcs of biarcs through points and tangents of the curve, each the longest that samples allow."""
    u = np.linspace(*curve.domain, n)
    points, along = curve(u), curve.derivative(u)
    along /= np.linalg.norm(along, axis=1)[:, None]

    def off(i, j):
        """The largest distance of the samples between from the biarc with tangents of equal length."""
        chord = points[j] - points[i]
        both = along[i] + along[j]
        square, dot, quad = chord @ chord, chord @ both, 2 - 2 * along[i] @ along[j]
        d = square / (2 * dot) if quad < 1e-14 else (-dot + np.sqrt(dot * dot + quad * square)) / quad
        joint = 0.5 * (points[i] + points[j] + d * (along[i] - along[j]))
        inner = points[i : j + 1]
        side = (inner - joint) @ (points[j] - points[i]) > 0
        worst = 0.0
        for start, tangent, end, rows in ((points[i], along[i], joint, ~side), (points[j], -along[j], joint, side)):
            normal, reach = np.array([-tangent[1], tangent[0]]), end - start
            k = 2 * (reach @ normal) / (reach @ reach)
            gap = inner[rows] - start
            q = gap @ normal - 0.5 * k * np.einsum("nd,nd->n", gap, gap)
            worst = max(worst, np.abs(2 * q / (1 + np.sqrt(np.maximum(1 - 2 * k * q, 0)))).max(initial=0.0))
        return worst

    i, count = 0, 0
    while i < n - 1:
        j, step = i + 1, 1
        while j + 1 < n and step < 400 and off(i, j + 1) <= tolerance:
            j, step = j + 1, step + 1
        i, count = j, count + 2
    return count


@pytest.mark.parametrize("name", ["flower", "wave", "spiral"])
@pytest.mark.parametrize("tolerance", [0.1, 0.01])
def test_fewer_than_a_greedy_search_over_biarcs(name, tolerance):
    assert len(cadfit.arcs(CURVES[name], tolerance)) <= 0.9 * greedy(CURVES[name].spline, tolerance)


def test_as_few_as_theory_allows():
    """Where curvature changes evenly (a clothoid) the best quadratic spline's arcs are (124.7 e / c)^(1/3) long."""
    s = np.linspace(0, 10, 1001)
    heading = 0.1 * s**2 / 2
    step = np.column_stack([np.cos(heading), np.sin(heading)])
    points = np.concatenate([[[0, 0]], np.cumsum((step[1:] + step[:-1]) / 2, axis=0) * 0.01])
    clothoid = cadfit.fit(points, 1e-6, effort="fast")
    for tolerance in (1e-3, 1e-4, 1e-5):
        ideal = 10 / (124.7 * tolerance / 0.1) ** (1 / 3)
        assert len(cadfit.arcs(clothoid, tolerance)) <= np.ceil(1.04 * ideal) + 1


@st.composite
def near_arcs(draw):
    """A Bézier piece near an arc of any radius, and that arc, a little moved."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    sweep, radius = rng.uniform(0.05, 2.5) * rng.choice([-1, 1]), 10.0 ** rng.uniform(-1, 5)
    h = 4 / 3 * np.tan(sweep / 4)
    piece = radius * np.array([[1, 0], [1, h], [np.cos(sweep) + h * np.sin(sweep), np.sin(sweep) - h * np.cos(sweep)],
                               [np.cos(sweep), np.sin(sweep)]])  # fmt: skip
    piece += rng.normal(size=(4, 2)) * 10.0 ** rng.uniform(-6, -1) * radius * abs(sweep)
    start, end = piece[[0, 3]] + rng.normal(size=(2, 2)) * 10.0 ** rng.uniform(-9, -3) * radius * abs(sweep)
    chord = end - start
    centre = 0.5 * (start + end) + np.array([-chord[1], chord[0]]) / (2 * np.tan(sweep / 2))
    return piece, start, end, centre, sweep


@given(near_arcs())
@settings(max_examples=60)
def test_bounds_are_never_below_what_samples_find(case):
    piece, start, end, centre, sweep = case
    parts, owner = cut(piece[None], np.array([0.0, 1.0]))
    (bound,) = bounds(parts, owner, start[None], end[None], centre[None], np.array([sweep]))
    t = np.linspace(0, 1, 400)[:, None]
    curve = (1 - t) ** 3 * piece[0] + 3 * (1 - t) ** 2 * t * piece[1] + 3 * (1 - t) * t**2 * piece[2] + t**3 * piece[3]
    arm = start - centre
    on_arc = centre + np.cos(sweep * t) * arm + np.sin(sweep * t) * np.array([-arm[1], arm[0]])
    apart = np.linalg.norm(curve[:, None] - on_arc, axis=2)
    spacing = max(np.linalg.norm(np.diff(p, axis=0), axis=1).max() for p in (curve, on_arc))
    found = max(apart.min(axis=0).max(), apart.min(axis=1).max())
    assert found <= bound + spacing
    radial = np.abs(np.linalg.norm(curve - centre, axis=1) - np.linalg.norm(arm)).max()
    assert radial <= bound * (1 + 1e-9)


def test_a_curve_that_goes_round_or_back_is_not_credited():
    """Near the circle all along, but it turns back, or goes round once more: no bound below the size of that."""
    quarter = cadfit.arcs(cadfit.BSpline([[1, 0], [1, 0.5523], [0.5523, 1], [0, 1]], [0] * 4 + [1] * 4), 0.01)
    there = np.array([[1, 0], [1, 0.5523], [0.5523, 1], [0, 1]])
    back = np.concatenate([there, there[::-1], there]).reshape(3, 4, 2)
    given_arc = (quarter.starts, quarter.ends, quarter.centres, quarter.sweeps)
    assert bounds(there[None], np.zeros(1, dtype=int), *given_arc)[0] < 0.001
    assert bounds(back, np.zeros(3, dtype=int), *given_arc)[0] > 1
    turned = [there @ np.array([[c, s], [-s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 0))]
    assert bounds(np.stack(turned), np.zeros(5, dtype=int), *given_arc)[0] > 1


@pytest.mark.parametrize("decimals", [3, 4])
@pytest.mark.parametrize("name", ["wave", "plate"])
def test_rounded_to_decimals(name, decimals):
    arcs = cadfit.arcs(CURVES[name], 0.02, decimals=decimals)
    finite = arcs.centres[~arcs.is_line]
    for numbers in (arcs.starts, arcs.ends, finite):
        assert np.array_equal(numbers, np.round(numbers, decimals))
    start, end = (np.linalg.norm(e[~arcs.is_line] - finite, axis=1) for e in (arcs.starts, arcs.ends))
    assert np.abs(start - end).max() <= 2 * 10.0**-decimals
    there, _ = distance(CURVES[name].curves, arcs)
    assert there - 10.0**-decimals <= arcs.deviation <= 0.02
    smooth = np.setdiff1d(np.arange(1, len(arcs)), arcs.corners)
    assert turns(arcs)[smooth].max(initial=0.0) <= 0.02
    with pytest.raises(ValueError, match="cannot be held with 1 decimals"):
        cadfit.arcs(CURVES[name], 0.02, decimals=1)


def test_large_radii_become_lines():
    flat = cadfit.BSpline([[0, 0], [10, 0.001], [20, 0.001], [30, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    (radius,) = cadfit.arcs(flat, 0.01, max_radius=1e9).radii
    assert 1e4 < radius < 1e9
    line = cadfit.arcs(flat, 0.01, max_radius=1e4)
    assert line.is_line.all()
    assert line.deviation == pytest.approx(0.00075, rel=0.02)
    arcs = cadfit.arcs(CURVES["wave"], 0.01, max_radius=50)
    assert arcs.radii[~arcs.is_line].max() <= 50
    assert arcs.is_line.any()
    lines = np.flatnonzero(arcs.is_line)
    jumps = turns(arcs)[np.intersect1d(np.concatenate([lines, lines + 1]), np.arange(1, len(arcs)))]
    assert jumps.max() <= arcs.lengths[lines].max() / 50


@pytest.mark.slow
def test_a_polyline():
    points = CURVES["flower"].points
    arcs = cadfit.arcs(points, 0.05, closed=True)
    assert arcs.closed
    again = np.concatenate([points, points[:1]])
    away = np.linalg.norm(sampled(arcs)[:, None] - again[None, ::1], axis=2).min(axis=1)
    assert away.max() <= 0.05 + np.linalg.norm(np.diff(again, axis=0), axis=1).max() / 2
    assert len(arcs) <= 1.2 * len(cadfit.arcs(CURVES["flower"], 0.05))


def test_planes_of_a_curve_in_3d():
    flat = CURVES["wave"].spline
    for plane, columns in (("xy", (0, 1)), ("zx", (2, 0)), ("yz", (1, 2))):
        matrix = np.zeros((3, 2))
        matrix[list(columns), [0, 1]] = 1
        height = np.full(3, 7.0)
        height[list(columns)] = 0
        arcs, same = cadfit.arcs(flat.transformed(matrix, height), 0.01, plane=plane), cadfit.arcs(flat, 0.01)
        assert np.array_equal(arcs.sweeps, same.sweeps)
        assert np.array_equal(arcs.flat(arcs.starts), same.starts)
        assert set(arcs.starts[:, 3 - sum(columns)]) == {7.0}
    tilted = flat.transformed([[1, 0], [0, 1], [0.1, 0]])
    with pytest.raises(ValueError, match="not lie in a plane parallel to xy: it rises by 4"):
        cadfit.arcs(tilted, 0.01)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"tolerance": 0.0}, "tolerance must be at least"),
        ({"tolerance": np.nan}, "tolerance must be at least"),
        ({"max_radius": -1.0}, "radius must be positive"),
        ({"plane": "zx"}, "arcs are for curves in 2D"),
    ],
)
def test_mistakes(change, expected):
    with pytest.raises(ValueError, match=expected):
        cadfit.arcs(**{"curve": CURVES["wave"], "tolerance": 0.01} | change)


def test_curves_that_do_not_follow_each_other():
    one = CURVES["wave"].spline
    with pytest.raises(ValueError, match="a gap of 40"):
        cadfit.arcs(SimpleNamespace(curves=[one, one], closed=False), 0.01)


KINDS = ["airfoil", "font_outline", "turbine_section", "wheel_rail", "literature"]


@pytest.mark.slow
@pytest.mark.parametrize("shape", corpus_data.curves(per_family=2, max_points=400, families=KINDS))
@pytest.mark.parametrize("share", [1e-3])
def test_real_curves(shape, share):
    if shape.points.shape[1] != 2:
        pytest.skip("in space")
    fit = cadfit.fit(shape.points, 0.2 * share * shape.size, closed=shape.closed, effort="fast")
    arcs = cadfit.arcs(fit, share * shape.size)
    assert arcs.deviation <= share * shape.size
    points = np.concatenate([arcs(k, np.linspace(0, 1, 20)) for k in range(len(arcs))])
    away = np.min([curve.nearest(points)[1] for curve in fit.curves], axis=0)
    assert away.max() <= arcs.deviation * (1 + 1e-9)
