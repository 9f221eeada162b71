"""A small controller for the tests: it runs a program of G-code and says where the tool was. No code of cadfit's.

What a program does is a list of events: ("move", key, points) for cutting moves, whose `key` is all that holds during
them (feed, spindle); and everything else in the order in which it came.
"""

import math
import re

import numpy as np
from scipy.spatial import cKDTree

PLANE = {17: "XYIJ", 18: "ZXKI", 19: "YZJK"}
MODAL = {0, 1, 2, 3, 5, 17, 18, 19, 20, 21, 90, 91, 90.1, 91.1}


class Fault(Exception):
    """What a controller stops at."""


def run(text, step=0.01):
    """Return the events of a program: cutting moves are sampled at most `step` apart."""
    at = dict.fromkeys("XYZE", 0.0)
    motion, plane, absolute, centres, extruder, unit = None, 17, True, False, True, 1.0
    feed = speed = None
    events = []
    for row, line in enumerate(text.splitlines(), 1):
        if "PO[" in line:
            motion = "POLY"
            start = np.array([at[axis] for axis in "XYZ"])
            poles = np.array([start] * 4)
            for axis, inside in re.findall(r"PO\[([XYZ])\]=\(([^)]*)\)", line):
                end, square, cube = (float(value) for value in inside.split(","))
                k, a = "XYZ".index(axis), at[axis]
                first = end - a - square - cube
                poles[1:, k] = a + first / 3, a + 2 * first / 3 + square / 3, end
                at[axis] = end
            feed = float(re.search(r"F([0-9.]+)", line).group(1)) if "F" in line else feed
            events.append(("move", (feed, speed, ()), bezier(poles, step / unit) * unit, 0.0))
            continue
        bare = re.sub(r"\(.*?\)", "", line.split(";")[0]).replace(" ", "").upper()
        comments = re.findall(r"\(.*?\)|;.*", line)
        if bare.startswith("%") or not bare:
            if bare or comments:
                events.append(("said", bare, tuple(comments)))
            continue
        words = re.findall(r"([A-Z])([-+]?[0-9.]+)", bare)
        if "".join(a + b for a, b in words) != bare:
            events.append(("other", bare))
            continue
        codes = [float(value) for letter, value in words if letter == "G"]
        named = {letter: float(value) for letter, value in words if letter not in "GMN"}
        for code in codes:
            if code in (0, 1, 2, 3, 5):
                motion = int(code)
            elif code in PLANE:
                plane = int(code)
            elif code in (20, 21):
                unit = 25.4 if code == 20 else 1.0
            elif code in (90, 91):
                absolute = extruder = code == 90
            elif code in (90.1, 91.1):
                centres = code == 90.1
            else:
                events.append(("code", code, tuple(sorted(named.items()))))
        if comments and not (motion in (1, 2, 3, 5) and set(named) & set("XYZIJKR")):
            events.append(("said", "", tuple(comments)))
        told = [float(value) for letter, value in words if letter == "M"]
        for code in told:
            if code in (82, 83):
                extruder = code == 82
            events.append(("told", code, named.get("P")))
        if "S" in named and named["S"] != speed:
            speed = named["S"]
            events.append(("speed", speed))
        if "T" in named:
            events.append(("tool", named["T"]))
        feed = named.get("F", feed)
        if 92 in codes:
            at.update({axis: named[axis] for axis in "XYZE" if axis in named})
            continue
        if any(code not in MODAL for code in codes) or not set(named) & set("XYZEIJKR"):
            continue
        before = dict(at)
        for axis in "XYZE":
            if axis in named:
                at[axis] = named[axis] + (0.0 if (absolute if axis != "E" else extruder) else before[axis])
        if motion == 0 or (all(before[axis] == at[axis] for axis in "XYZ") and motion == 1):
            if motion == 0 or before["E"] != at["E"]:
                events.append(
                    ("goes", motion, tuple(round(at[axis], 6) for axis in "XYZ"), round(at["E"] - before["E"], 4))
                )
            continue
        points = _path(row, motion, plane, before, at, named, centres, step, unit)
        events.append(("move", (feed, speed, tuple(comments)), points * unit, at["E"] - before["E"]))
    return events


def _path(row, motion, plane, before, at, named, centres, step, unit):
    start, end = (np.array([place[axis] for axis in "XYZ"]) for place in (before, at))
    if motion == 1:
        n = max(2, math.ceil(np.linalg.norm(end - start) * unit / step) + 1)
        return start + np.linspace(0, 1, n)[:, None] * (end - start)
    if motion == 5:
        poles = np.array([start, start, end, end])
        poles[1, :2] += named.get("I", 0.0), named.get("J", 0.0)
        poles[2, :2] += named["P"], named["Q"]
        return bezier(poles, step / unit)
    a, b, i, j = PLANE[plane]
    p, q = np.array([before[a], before[b]]), np.array([at[a], at[b]])
    if "R" in named:
        chord = q - p
        half = np.linalg.norm(chord) / 2
        up = math.sqrt(max(named["R"] ** 2 - half**2, 0.0)) * (1 if named["R"] > 0 else -1) * (1 if motion == 3 else -1)
        centre = (p + q) / 2 + up * np.array([-chord[1], chord[0]]) / (2 * half)
    else:
        centre = np.array([named.get(i, 0.0), named.get(j, 0.0)]) + (0.0 if centres else p)
    first, last = np.linalg.norm(p - centre), np.linalg.norm(q - centre)
    off = abs(first - last) * unit
    if off > 0.127 or (off > 0.00127 and off > 0.001 * max(first, last) * unit):
        raise Fault(f"line {row}: radius to end of arc differs from radius to start: {first} and {last}")
    angle = math.atan2(p[1] - centre[1], p[0] - centre[0])
    sweep = math.atan2(q[1] - centre[1], q[0] - centre[0]) - angle
    if motion == 3 and sweep <= 1e-12:
        sweep += 2 * math.pi
    elif motion == 2 and sweep >= -1e-12:
        sweep -= 2 * math.pi
    share = np.linspace(0, 1, max(2, math.ceil(abs(sweep) * first * unit / step) + 1))
    radius = first + share * (last - first)
    points = np.empty((len(share), 3))
    points[:, "XYZ".index(a)] = centre[0] + radius * np.cos(angle + share * sweep)
    points[:, "XYZ".index(b)] = centre[1] + radius * np.sin(angle + share * sweep)
    along = "XYZ".index(({*"XYZ"} - {a, b}).pop())
    points[:, along] = start[along] + share * (end - start)[along]
    return points


def bezier(poles, step):
    """Points of a cubic Bézier at most `step` apart."""
    n = max(2, math.ceil(np.linalg.norm(np.diff(poles, axis=0), axis=1).sum() * 3 / step) + 1)
    t = np.linspace(0, 1, n)[:, None]
    return (1 - t) ** 3 * poles[0] + 3 * t * (1 - t) ** 2 * poles[1] + 3 * t**2 * (1 - t) * poles[2] + t**3 * poles[3]


def together(events):
    """Join cutting moves that follow one another under one key: [("move", key, points, extruded) or another event]."""
    found = []
    for event in events:
        if event[0] == "move" and found and found[-1][0] == "move" and found[-1][1] == event[1]:
            _, key, points, extruded = found[-1]
            found[-1] = ("move", key, [*points, event[2]], extruded + event[3])
        else:
            found.append(("move", event[1], [event[2]], event[3]) if event[0] == "move" else event)
    return [(*e[:2], np.concatenate(e[2]), e[3]) if e[0] == "move" else e for e in found]


def farthest(first, second):
    """The largest distance from a vertex of either path (n, 3) to the other path, a polyline."""
    return max(_from(first, second), _from(second, first))


def _from(points, path):
    """The largest distance from points to a polyline: to the segments around the nearest vertex, which bounds it."""
    _, near = cKDTree(path).query(points)
    best = np.full(len(points), np.inf)
    for start in (near + k for k in range(-4, 4)):
        start = np.clip(start, 0, len(path) - 2)
        a, b = path[start], path[start + 1]
        along = b - a
        square = np.maximum((along**2).sum(axis=1), 1e-300)
        place = np.clip(((points - a) * along).sum(axis=1) / square, 0, 1)[:, None]
        best = np.minimum(best, np.linalg.norm(points - a - place * along, axis=1))
    return best.max()


def compare(before, after, step=0.01):
    """Hold two programs against each other; return the largest distance between their cutting paths.

    AssertionError where anything else differs: order, feeds, speeds, comments, rapids, codes, what is extruded.
    """
    worst = 0.0
    old, new = together(run(before, step)), together(run(after, step))
    assert [event[0] for event in old] == [event[0] for event in new]
    for a, b in zip(old, new, strict=True):
        if a[0] != "move":
            assert a == b
            continue
        assert a[1] == b[1]
        assert abs(a[3] - b[3]) < 2e-4
        assert np.abs(a[2][[0, -1]] - b[2][[0, -1]]).max() < 1e-6, "a run's ends moved"
        worst = max(worst, farthest(a[2], b[2]))
    return worst
