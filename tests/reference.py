"""Slow, obvious versions of what cadfit computes, each straight from its definition."""

from fractions import Fraction
from itertools import pairwise

import numpy as np

EPS = np.finfo(float).eps


def basis(i, k, t, u):
    """The Cox-de Boor function N_{i,k}(u) of order k (degree k - 1), right-continuous, but closed at the last knot."""
    if k == 1:
        return int(t[i] <= u < t[i + 1] or (t[i] < u == t[i + 1] == t[-1]))
    total = 0
    if t[i + k - 1] > t[i]:
        total = total + (u - t[i]) / (t[i + k - 1] - t[i]) * basis(i, k - 1, t, u)
    if t[i + k] > t[i + 1]:
        total = total + (t[i + k] - u) / (t[i + k] - t[i + 1]) * basis(i + 1, k - 1, t, u)
    return total


def basis_derivative(i, k, t, u, order, sign=-1):
    """The derivative of N_{i,k} by its recurrence; with sign=+1 all terms add up, which bounds the rounding."""
    if order == 0:
        return basis(i, k, t, u)
    total = 0
    if t[i + k - 1] > t[i]:
        total = total + (k - 1) / (t[i + k - 1] - t[i]) * basis_derivative(i, k - 1, t, u, order - 1, sign)
    if t[i + k] > t[i + 1]:
        total = total + sign * (k - 1) / (t[i + k] - t[i + 1]) * basis_derivative(i + 1, k - 1, t, u, order - 1, sign)
    return total


def weighted(values, knots, u, order, sign=-1):
    """The sum of values and basis functions at u; a function is nought outside its four spans."""
    t, u = [float(knot) for knot in knots], float(u)
    inside = [i for i in range(len(values)) if t[i] <= u <= t[i + 4]]
    return sum(basis_derivative(i, 4, t, u, order, sign) * values[i] for i in inside)


def curve(poles, knots, parameters, order=0):
    """The derivative of the cubic B-spline at each parameter, (len(parameters), d)."""
    return np.array([weighted(poles, knots, u, order) for u in parameters])


def rounding(poles, knots, parameters, order=0):
    """How large a few rounding errors in every term can make the error of `curve`, (len(parameters), 1)."""
    largest = np.abs(poles).max(axis=1)
    return 32 * EPS * np.array([[weighted(largest, knots, u, order, sign=1)] for u in parameters])


def exact_curve(poles, knots, u):
    """The point at u in rational arithmetic, rounded once."""
    t, u = [Fraction(float(knot)) for knot in knots], Fraction(float(u))
    weights = [basis(i, 4, t, u) for i in range(len(poles))]
    return [
        float(sum(w * Fraction(float(x)) for w, x in zip(weights, axis, strict=True))) for axis in np.transpose(poles)
    ]


def parameters_between_knots(spline, count=5):
    """Some parameters inside every span, ends included, rising and distinct."""
    inside = [np.linspace(a, b, count) for a, b in pairwise(np.unique(spline.knots))]
    return np.unique(np.concatenate(inside))


def top_speed(spline):
    """The largest leg of the derivative's control polygon, which bounds the speed."""
    spans = spline.knots[4:-1] - spline.knots[1:-4]
    return (3 * np.linalg.norm(np.diff(spline.poles, axis=0), axis=1) / spans).max()


def magnitude(spline):
    return np.abs(spline.poles).max()


def de_casteljau(piece, t):
    """The point at t of one Bézier piece (k, d)."""
    level = [np.asarray(pole, dtype=float) for pole in piece]
    while len(level) > 1:
        level = [(1 - t) * a + t * b for a, b in pairwise(level)]
    return level[0]


def sampled(piece, count):
    """The piece at `count` even steps, (count + 1, d)."""
    t = np.linspace(0.0, 1.0, count + 1)[:, None]
    return (1 - t) ** 3 * piece[0] + 3 * (1 - t) ** 2 * t * piece[1] + 3 * (1 - t) * t**2 * piece[2] + t**3 * piece[3]


def smooth_length(piece, count=256):
    """The length of a piece that does not stand still: polygons of `count`, 2 and 4 times as many, and Richardson."""
    polygon = [np.linalg.norm(np.diff(sampled(piece, count * k), axis=0), axis=1).sum() for k in (1, 2, 4)]
    once = [fine + (fine - coarse) / 3 for coarse, fine in pairwise(polygon)]
    return once[1] + (once[1] - once[0]) / 15


def travel(piece):
    """The length of a piece in one dimension, by the places where it turns: roots of a quadratic."""
    p0, p1, p2, p3 = np.ravel(piece) - np.ravel(piece)[0]
    a, b, c = p3 - 3 * p2 + 3 * p1 - p0, 2 * (p2 - 2 * p1 + p0), p1 - p0
    turns = [0.0, 1.0]
    if b * b > 4 * a * c:
        q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4 * a * c), b))
        turns += [r for r in ((q / a) if a else 0.0, (c / q) if q else 0.0) if 0 < r < 1]
    places = [de_casteljau([[p0], [p1], [p2], [p3]], t)[0] for t in sorted(turns)]
    return np.abs(np.diff(places)).sum()


def nearest_distance(pieces, point):
    """The distance from the point to the pieces: at ends, and where the way to the point is square to the curve."""
    best = np.inf
    for piece in pieces:
        p0, p1, p2, p3 = piece - point
        powers = np.array([p3 - 3 * p2 + 3 * p1 - p0, 3 * (p2 - 2 * p1 + p0), 3 * (p1 - p0), p0])  # t**3 first
        slopes = powers[:3] * np.array([[3], [2], [1]])
        square = sum(np.convolve(x, v) for x, v in zip(powers.T, slopes.T, strict=True))
        places = np.clip([0.0, 1.0, *np.roots(np.trim_zeros(square, "f")).real], 0, 1)
        best = min(best, *(np.linalg.norm(de_casteljau(piece - point, t)) for t in places))
    return best


def segment_distance(point, start, end):
    """The distance to a segment, in rational arithmetic up to the root."""
    p, a, b = ([Fraction(float(x)) for x in row] for row in (point, start, end))
    chord = [y - x for x, y in zip(a, b, strict=True)]
    square = sum(x * x for x in chord)
    along = sum((x - y) * z for x, y, z in zip(p, a, chord, strict=True))
    ratio = min(max(along / square, Fraction(0)), Fraction(1)) if square else Fraction(0)
    return float(sum((x - y - ratio * z) ** 2 for x, y, z in zip(p, a, chord, strict=True))) ** 0.5


# The paper, section 2.1: four points, the geometry matrix, one segment.


def geometry_matrix(tau):
    return np.array(
        [[-tau, 2 - tau, tau - 2, tau], [2 * tau, tau - 3, 3 - 2 * tau, -tau], [-tau, 0, tau, 0], [0, 1, 0, 0]]
    )


def cardinal_segments(points, tau, u, closed=False):
    """Every segment of the cardinal spline at u in [0, 1], (segments, d)."""
    rows = [*points]
    rows = [rows[-1], *rows, rows[0], rows[1]] if closed else [rows[0], *rows, rows[-1]]
    powers = np.array([u**3, u**2, u, 1.0])
    return np.array([powers @ geometry_matrix(tau) @ np.array(rows[k : k + 4]) for k in range(len(rows) - 3)])


# Section 2.2: the four control points of a segment, with the slip of one index in the first handle put right.


def cardinal_handles(points, tau):
    pieces = []
    for k in range(1, len(points)):
        before, after = points[max(k - 2, 0)], points[min(k + 1, len(points) - 1)]
        first = points[k - 1] + tau / 3 * (points[k] - before)
        second = points[k] - tau / 3 * (after - points[k - 1])
        pieces.append([points[k - 1], first, second, points[k]])
    return np.array(pieces)


# Section 2.3: the knots of n + 1 control points for order k.


def uniform_knots(n, k=4):
    return np.array([0.0 if i < k else float(i - k + 1) if i <= n else float(n - k + 2) for i in range(n + k + 1)])


# Section 2.9: the merge rule. Planar poles are (common coordinate, other coordinate).


def point_on_line(start, through, common):
    """The point of the line with that common coordinate."""
    return start[1] + (through[1] - start[1]) / (through[0] - start[0]) * (common - start[0])


def merge_r3(a, b):
    """One piece in R^3 as (x_k, x_j, x_l), from a piece in the plane (x_k, x_j) and one in (x_k, x_l)."""
    p = ((a[1][0] - a[0][0]) + (b[1][0] - b[0][0])) / 2
    q = ((a[2][0] - a[3][0]) + (b[2][0] - b[3][0])) / 2
    x1, x2 = p + a[0][0], q + a[3][0]
    return np.array(
        [
            [a[0][0], a[0][1], b[0][1]],
            [x1, point_on_line(a[0], a[1], x1), point_on_line(b[0], b[1], x1)],
            [x2, point_on_line(a[3], a[2], x2), point_on_line(b[3], b[2], x2)],
            [a[3][0], a[3][1], b[3][1]],
        ]
    )


def merge(pieces, common_axis):
    """One piece in R^n from n - 1 planar ones."""
    p = sum(piece[1][0] - piece[0][0] for piece in pieces) / len(pieces)
    q = sum(piece[2][0] - piece[3][0] for piece in pieces) / len(pieces)
    x1, x2 = p + pieces[0][0][0], q + pieces[0][3][0]
    columns = [[c[0][1], point_on_line(c[0], c[1], x1), point_on_line(c[3], c[2], x2), c[3][1]] for c in pieces]
    columns.insert(common_axis, [pieces[0][0][0], x1, x2, pieces[0][3][0]])
    return np.array(columns).T


# Interpolation.


def derivative_weights(u, at):
    """What the first and second derivative at `at` of the polynomial through u_i weigh each value by, exactly."""
    weights = []
    for i in range(len(u)):
        polynomial = [Fraction(1)]  # Lagrange's, in powers of (x - at), lowest first
        for j in range(len(u)):
            if j != i:
                scaled = [c / (u[i] - u[j]) for c in polynomial]
                polynomial = [x + (at - u[j]) * y for x, y in zip([0, *scaled], [*scaled, 0], strict=True)]
        polynomial += [Fraction(0)] * 2
        weights.append((polynomial[1], 2 * polynomial[2]))
    return list(zip(*weights, strict=True))


def neighbour_derivatives(points, steps, width=5):
    """First and second derivatives (2, d, n) from `width` neighbours, and the sums of all terms' sizes, likewise."""
    u = [sum((Fraction(float(step)) for step in steps[:k]), Fraction(0)) for k in range(len(steps) + 1)]
    n = len(u)
    width = min(width, n)
    values, sizes = np.zeros((2, 2, points.shape[1], n))
    for k in range(n):
        start = min(max(k - width // 2, 0), n - width)
        for order, weights in enumerate(derivative_weights(u[start : start + width], u[k])):
            terms = [
                [float(w * Fraction(float(x))) for x in row] for w, row in zip(weights, points[start:], strict=False)
            ]
            values[order, :, k], sizes[order, :, k] = np.sum(terms, axis=0), np.abs(terms).sum(axis=0)
    return values, sizes


def interpolant_poles(u, points, start, end):
    """Poles of the cubic spline with knots at u through the points and one derivative (order, value) at either end."""
    t = [u[0]] * 3 + list(u) + [u[-1]] * 3
    n = len(u) + 2

    def row(x, order):
        return [basis_derivative(i, 4, t, x, order) for i in range(n)]

    matrix = [row(u[0], start[0]), *(row(x, 0) for x in u), row(u[-1], end[0])]
    return np.linalg.solve(np.array(matrix, dtype=float), np.vstack([start[1], *points, end[1]])), np.array(t)


# Sections 2.4 to 2.7: dominant points. Sums run from left to right, so that equal errors are equal to the last bit.


def total(terms):
    result = 0.0
    for term in terms:
        result += term
    return result


def turn_angle(first, second, third):
    """The paper's angle, pi - acos(FS TS / (|FS| |TS|)); 0 where two points are equal."""
    fs, ts = np.subtract(first, second), np.subtract(third, second)
    if not fs.any() or not ts.any():
        return 0.0
    cosine = fs @ ts / (np.sqrt(fs @ fs) * np.sqrt(ts @ ts))
    return np.pi - np.arccos(min(max(cosine, -1.0), 1.0))


def piece_squares(points, before, start, end, after):
    """The squared distance of each point inside one piece, by projection on the chord."""
    n = len(points)
    w, a, b, c = (points[k].tolist() for k in (before, start, end, after))
    chord = [y - x for x, y in zip(a, b, strict=True)]
    length = total(x * x for x in chord)
    squares = []
    for k in range(1, max((end - start) % n, 1)):
        offset = [x - y for x, y in zip(points[(start + k) % n].tolist(), a, strict=True)]
        along = total(x * y for x, y in zip(offset, chord, strict=True))
        t = min(max(along / length, 0.0), 1.0) if length > 0 else 0.0
        s = 1.0 - t
        gaps = []
        for x, y, p, q, r in zip(offset, chord, w, c, zip(a, b, strict=True), strict=True):
            first, second = 0.5 / 3.0 * (r[1] - p), y - 0.5 / 3.0 * (q - r[0])  # the handles, from the start
            inner = 3.0 * s * t
            gaps.append(x - (inner * s) * first - (inner * t) * second - (t * t * t) * y)
        squares.append(total(gap * gap for gap in gaps))
    return squares


def dominant_pieces(indices, closed):
    """The rows before, at the start, at the end of and after each piece."""
    m = len(indices)
    if closed:
        return [tuple(indices[(k + j) % m] for j in (-1, 0, 1, 2)) for k in range(m)]
    rows = [indices[0], *indices, indices[-1]]
    return [tuple(rows[k : k + 4]) for k in range(m - 1)]


def dominant_error(points, indices, closed):
    return total(total(piece_squares(points, *piece)) for piece in dominant_pieces(indices, closed))


def initial_dominant_points(angles, count, closed):
    n = len(angles)
    order = sorted(range(n) if closed else range(1, n - 1), key=lambda k: (-angles[k], k))
    chosen = [] if closed else [0, n - 1]
    wanted = order[: count // 4]
    for k in order[: count // 4]:
        wanted += [(k - 1) % n, (k + 1) % n]
    for k in wanted + order:
        if len(chosen) < count and k not in chosen:
            chosen.append(k)
    return sorted(chosen)


def refined_dominant_points(points, angles, indices, closed):
    """Swaps, the whole error computed for each that is tried."""
    n = len(points)
    indices, error = list(indices), dominant_error(points, indices, closed)
    history = [error]
    rounding = (16 * EPS * np.abs(points).max()) ** 2
    while True:
        pieces = dominant_pieces(indices, closed)
        squares = [piece_squares(points, *piece) for piece in pieces]
        errors = [total(each) for each in squares]
        worst = errors.index(max(errors))
        if errors[worst] == 0.0:
            return indices, history
        added = (pieces[worst][1] + 1 + squares[worst].index(max(squares[worst]))) % n
        smallest = [k for k in range(len(pieces)) if errors[k] == min(errors)]
        if min(errors) > 0.0:
            smallest = [min(smallest, key=lambda k: pieces[k][1])]
        ends = {row for k in smallest for row in pieces[k][1:3]} - (set() if closed else {0, n - 1})
        for dropped in sorted(ends, key=lambda row: (angles[row], row)):
            tried = sorted({*indices, added} - {dropped})
            new = dominant_error(points, tried, closed)
            if error - new > 1e-12 * error + rounding:
                indices, error = tried, new
                history.append(new)
                break
        else:
            return indices, history
