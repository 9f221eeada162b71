"""Rotation-minimizing frames, against slow transport, closed forms and laws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cadfit import BSpline, Frames, cardinal_spline, frames


def helix(turns=10, points=4001, radius=3.0, rise=1.0):
    t = np.linspace(0.0, 2.0 * np.pi * turns, points)
    return cardinal_spline(np.column_stack([radius * np.cos(t), radius * np.sin(t), rise * t]), curvature=1.0)


def trefoil(points=600):
    t = np.linspace(0.0, 2.0 * np.pi, points, endpoint=False)
    knot = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    return cardinal_spline(knot, curvature=1.0, closed=True)


def projected(path, first, steps=100_000):
    """Carry a normal along the path by projecting it out of each next tangent: first order, but plainly right."""
    u = np.linspace(*path.domain, steps + 1)
    tangents = path.derivative(u)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    normal = first
    for t in tangents:
        normal = normal - (normal @ t) * t
        normal = normal / np.sqrt(normal @ normal)
    return normal


def angle_about(axis, start, end):
    return np.arctan2(np.cross(start, end) @ axis, start @ end)


def right_handed(f, tolerance=1e-12):
    axes = np.stack([f.tangents, f.normals, f.binormals], axis=1)
    return np.isfinite(axes).all() and (
        np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max() < tolerance
        and np.abs(np.linalg.det(axes) - 1.0).max() < tolerance
    )


def random_path(seed, n=12, scale=1.0):
    return cardinal_spline(scale * np.random.default_rng(seed).normal(size=(n, 3)), curvature=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("path", [helix(1, 60), random_path(1), random_path(2)], ids=["helix", "random", "random2"])
def test_transport_by_tiny_projections(path):
    f = frames(path, np.linspace(*path.domain, 400))
    # Projection is first order: the reference itself is the limit of two step sizes.
    coarse, fine = (projected(path, f.normals[0], steps) for steps in (40_000, 80_000))
    off = [angle_about(f.tangents[-1], f.normals[-1], reference) for reference in (coarse, fine)]
    assert abs(2 * off[1] - off[0]) < 1e-5
    assert abs(off[1]) < 0.6 * abs(off[0]) + 1e-9


def test_helix_to_1e_8_of_the_closed_form():
    """The exact normal turns back against the Frenet normal by the integral of the torsion."""
    radius, rise, turns = 3.0, 1.0, 10
    from scipy.interpolate import make_interp_spline

    t = np.linspace(0.0, 2.0 * np.pi * turns, 4001)
    ends = [(1, [0.0, radius, rise])]
    fine = make_interp_spline(
        t, np.column_stack([radius * np.cos(t), radius * np.sin(t), rise * t]), k=3, bc_type=(ends, ends)
    )
    u = np.linspace(t[0], t[-1], 400)
    f = frames(BSpline(fine.c, fine.t), u)
    inward = -np.column_stack([np.cos(u), np.sin(u), 0.0 * u])
    across = np.cross(f.tangents, inward)
    angle = np.unwrap(np.arctan2(np.sum(f.normals * across, axis=1), np.sum(f.normals * inward, axis=1)))
    exact = -rise / np.hypot(radius, rise) * u  # torsion times length
    assert np.abs(angle - angle[0] - exact).max() < 1e-8


def test_the_half_steps_are_what_makes_it_sixth_order():
    """On one cubic, so that no knot adds steps: halving the step divides the error by 64, not by 16."""
    path = BSpline([[0, 0, 0], [2, 0, 0], [2, 2, 1], [0, 2, 3]], [0, 0, 0, 0, 1, 1, 1, 1])

    def end(count):
        f = frames(path, np.linspace(0.0, 1.0, count + 1))
        return f.normals[-1]

    best = end(512)
    errors = [np.linalg.norm(end(count) - best) for count in (4, 8, 16, 32)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders[-1] > 5.5
    assert errors[-1] < 1e-8


def test_trefoil_closes_and_its_holonomy_is_known():
    path = trefoil()
    f = frames(path, path.distinct_knots)
    assert np.degrees(f.holonomy) == pytest.approx(-127.485438, abs=2e-6)
    assert np.abs(f.normals[0] - f.normals[-1]).max() < np.radians(1e-9)
    assert np.abs(f.binormals[0] - f.binormals[-1]).max() < np.radians(1e-9)
    carried = projected(path, f.normals[0])
    assert angle_about(f.tangents[0], f.normals[0], carried) == pytest.approx(f.holonomy, abs=1e-3)


def test_holonomy_is_spread_evenly_along_the_length():
    path = trefoil(200)
    f = frames(path, path.distinct_knots)
    opened = path.split(0.5 * path.domain[1])[0]
    g = frames(opened, opened.distinct_knots)
    turn = [angle_about(f.tangents[k], g.normals[k], f.normals[k]) for k in range(len(opened.distinct_knots))]
    assert g.holonomy == 0.0
    assert np.abs(np.unwrap(turn) + f.holonomy * g.lengths / path.length()).max() < 1e-8


def test_lengths():
    for path in (helix(1, 60), trefoil(60), random_path(3)):
        f = frames(path, np.linspace(*path.domain, 2000))
        assert f.lengths[0] == 0.0
        assert f.lengths[-1] == pytest.approx(path.length(), rel=1e-7)


def test_a_planar_path_keeps_its_binormal():
    t = np.linspace(0.0, 6.0, 30)
    path = cardinal_spline(np.column_stack([t, np.sin(3.0 * t)]), curvature=1.0)
    f = frames(path, np.linspace(*path.domain, 300))
    assert f.origins.shape == (300, 3)
    assert np.abs(f.binormals - [0.0, 0.0, 1.0]).max() < 1e-13


@pytest.mark.parametrize("axis", [*np.eye(3), *-np.eye(3)], ids=["x", "y", "z", "-x", "-y", "-z"])
def test_straight_along_each_axis(axis):
    path = BSpline(np.outer([0.0, 1.0, 2.0, 3.0], axis), [0, 0, 0, 0, 1, 1, 1, 1])
    f = frames(path, np.linspace(0.0, 1.0, 9))
    assert right_handed(f)
    assert np.abs(f.tangents - axis).max() < 1e-15
    assert np.abs(f.normals - f.normals[0]).max() < 1e-15


@pytest.mark.parametrize("axis", [[0, 0, -1], [0, 0, 1], [1, 0, 0]])
def test_wobble_about_an_axis_does_not_spin(axis):
    """Tangents that circle close to a pole of the sphere, where spherical angles turn by full circles."""
    t = np.linspace(0.0, 20.0 * np.pi, 400)
    wobble = np.column_stack([0.01 * np.cos(t), 0.01 * np.sin(t), t])
    turned = np.roll(wobble, axis.index(next(filter(None, axis))) - 2, axis=1) * (1 if sum(axis) > 0 else -1)
    path = cardinal_spline(turned, curvature=1.0)
    f = frames(path, np.linspace(*path.domain, 3000))
    # The area that the tangents enclose on the sphere, 10 loops of pi 0.01^2, is all the turn there is.
    assert np.arccos(np.clip(f.normals @ f.normals[0], -1, 1)).max() < 0.02


KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]


@pytest.mark.parametrize(
    ("poles", "u", "expected"),
    [
        ([[0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 1, 0]], 0.0, [1, 0, 0]),  # starts from rest
        ([[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 2, 0]], 0.0, [0, 1, 0]),
        ([[0, 0, 0], [1, 0, 0], [2, 2, 2], [2, 2, 2]], 1.0, [1 / 3, 2 / 3, 2 / 3]),  # comes to rest
        ([[0, 0, 0], [3, 3, 0], [0, 3, 0], [3, 0, 0]], 0.5, [0, -1, 0]),  # a cusp: leaves downward
    ],
)
def test_where_the_path_stands_still(poles, u, expected):
    f = frames(BSpline(poles, KNOTS), [0.0, 0.25, u, 0.75, 1.0])
    assert right_handed(f)
    assert np.abs(f.tangents[2] - expected).max() < 1e-12


def test_repeated_points_and_turning_straight_back():
    rests = cardinal_spline([[0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]])
    back = cardinal_spline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 0, 0], [0, 0, 0]])
    for path in (rests, back):
        assert right_handed(frames(path, np.linspace(*path.domain, 97)))


def test_order_and_repeats_of_the_parameters_do_not_matter():
    path = random_path(5)
    u = np.linspace(*path.domain, 11)
    f = frames(path, u)
    g = frames(path, np.concatenate([u[::-1], u[3:4]]))
    assert np.array_equal(f.normals[::-1], g.normals[:-1])
    assert np.array_equal(g.normals[-1], f.normals[3])
    assert len(g) == 12
    # Parameters as near as numbers are, beside knots too.
    knots = path.distinct_knots
    close = frames(path, np.concatenate([knots[:-1], np.nextafter(knots[:-1], knots[-1])]))
    assert np.abs(np.diff(close.normals.reshape(2, -1, 3), axis=0)).max() < 1e-12
    assert np.abs(np.diff(close.tangents.reshape(2, -1, 3), axis=0)).max() < 1e-12
    assert np.abs(frames(path, u[-1:]).normals[0] - f.normals[-1]).max() < 1e-3  # the knots alone already carry it


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("size", [2, 7, 64])
def test_blocks_of_any_size_give_the_same_frames(monkeypatch, closed, size):
    """Frames are carried on from block to block; pairs of parameters as near as numbers are stand at their ends too."""
    flat = cardinal_spline(np.random.default_rng(1).normal(size=(9, 2)), curvature=1.0, closed=closed)
    steep = cardinal_spline(np.random.default_rng(2).normal(size=(9, 3)) * [1, 1, 9], curvature=1.0, closed=closed)
    tilted = flat.transformed([[1, 0], [0, 1], [1e-17, -1e-17]])  # whose tangents are up or down by rounding alone
    for path in (trefoil(60), flat, steep, tilted):
        u = np.linspace(*path.domain, 101)
        u = np.sort(np.concatenate([u, np.nextafter(u[:-1], u[-1])]))
        whole = frames(path, u)
        with monkeypatch.context() as patch:
            patch.setattr("cadfit.sweeping.frames._BLOCK", size)
            parts = frames(path, u)
        for name in ("origins", "tangents", "normals", "binormals", "lengths"):
            assert np.abs(getattr(parts, name) - getattr(whole, name)).max() < 1e-11
        assert parts.holonomy == pytest.approx(whole.holonomy, abs=1e-11)
        assert parts.error == pytest.approx(whole.error, rel=1e-6, abs=1e-18)


def test_more_stations_than_a_block_holds():
    path = helix(1, 60)
    u = np.linspace(*path.domain, 30_001)
    f, g = frames(path, u), frames(path, u[::10_000])
    assert right_handed(f)
    assert f.error < 1e-15
    assert np.abs(f.normals[::10_000] - g.normals).max() < 1e-9
    assert np.abs(f.origins - path(u)).max() < 1e-13
    assert f.lengths[-1] == pytest.approx(path.length(), rel=1e-12)


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 10_000), scale=st.sampled_from([1e-6, 1.0, 1e6]))
def test_laws(seed, scale):
    path = random_path(seed, scale=scale)
    u = np.linspace(*path.domain, 150)
    f = frames(path, u)
    assert right_handed(f)
    # A rigid motion moves the frames with it, up to one constant turn of them all.
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    q *= np.linalg.det(q)
    g = frames(path.transformed(q, scale * np.array([1.0, -2.0, 3.0])), u)
    moved = f.normals @ q.T
    turn = [angle_about(g.tangents[k], moved[k], g.normals[k]) for k in range(len(u))]
    assert np.abs(np.exp(1j * np.array(turn)) - np.exp(1j * turn[0])).max() < 1e-7
    # Backward is the same transport.
    low, high = path.domain
    h = frames(path.reversed(), low + high - u[::-1])
    turn = [angle_about(f.tangents[k], f.normals[k], h.normals[::-1][k]) for k in range(len(u))]
    assert np.abs(np.exp(1j * np.array(turn)) - np.exp(1j * turn[0])).max() < 1e-6


def test_frames_are_values():
    f = frames(random_path(7), [0.0, 1.0])
    assert isinstance(f, Frames)
    with pytest.raises(ValueError, match="read-only"):
        f.normals[0, 0] = 2.0
    with pytest.raises(AttributeError):
        f.holonomy = 1.0


def test_what_is_refused():
    with pytest.raises(ValueError, match="2 or 3 dimensions, not 4"):
        frames(BSpline(np.eye(4), KNOTS), [0.0])
    with pytest.raises(TypeError, match=r"cadfit\.BSpline, not list"):
        frames([[0, 0, 0]], [0.0])
    with pytest.raises(ValueError, match="never moves"):
        frames(BSpline(np.ones((4, 3)), KNOTS), [0.0])
    with pytest.raises(ValueError, match="outside"):
        frames(random_path(1), [1e9])
    with pytest.raises(ValueError, match="NaN"):
        frames(random_path(1), [np.nan])


def test_the_reference_sees_a_wrong_frame():
    path = random_path(1)
    f = frames(path, np.linspace(*path.domain, 400))
    spun = np.cos(0.01) * f.normals[-1] + np.sin(0.01) * f.binormals[-1]
    assert abs(angle_about(f.tangents[-1], spun, projected(path, f.normals[0], 40_000))) > 5e-3


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e300])
def test_up_may_be_of_any_length(size):
    path = cardinal_spline([[0, 0, 0], [0, 1, 0], [0, 2, 1], [1, 3, 1]])
    expected = frames(path, [0.5, 1.5], up=[1, 0, 1]).normals
    assert np.allclose(frames(path, [0.5, 1.5], up=[size, 0, size]).normals, expected, rtol=0, atol=1e-15)
