"""Real paths swept: over 200 curves of the corpus (vessels' and neurons' centrelines, cable-like traces, race tracks,
tool paths, threads of our own), each as a tube and as a bar, and what is wrong with the result, counted.

A tube has a radius of 1/300 of the path's size, on neurons one that varies; a bar is 3 by 1 of these; the tolerance is
a fifth of it. Paths are cut to their first 80 points; each sweep has a limit of 30 seconds. Where cadfit says that a
sweep would pass through itself, that is counted as said, and the repaired mesh is looked at instead. Wrong is: an
exception, a mesh that is not watertight or wound both ways, a volume that is not above zero, a face without area in a
mesh that was not repaired, a volume off by more than 0.1 % of area times length where nothing was said, and no answer
within the limit.
"""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from pathlib import Path
from time import perf_counter

import manifold3d  # noqa: F401  here, or every process imports it again
import numpy as np
import trimesh  # noqa: F401

import cadfit
from cadfit.sweeping.selfintersection import SelfIntersectionError

from limited import limited

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import corpus_data

FAMILIES = {
    "neuron": 60,
    "tract": 40,
    "backbone": 11,
    "trajectory": 3,
    "flight": 11,
    "race_track": 40,
    "gps_track": 18,
    "toolpath_mill": 20,
    "cad_edge": 20,
}
THREADS = 10
LIMIT = 30.0  # seconds for a sweep


def paths() -> list[tuple[str, cadfit.BSpline]]:
    """Return family and path: fits within 1/1000 of the size of at most 80 points, and thread helices."""
    found = []
    for family, count in FAMILIES.items():
        members = corpus_data._corpus().load(family=family)
        for k in np.unique(np.linspace(0, len(members) - 1, count).astype(int)):
            points = members[k].points[:80]
            points = points - points.mean(axis=0)
            size = float(np.linalg.norm(np.ptp(points, axis=0)))
            if len(points) < 4 or size == 0.0 or points.shape[1] not in (2, 3):
                continue
            closed = members[k].closed and len(points) == len(members[k].points)
            found.append((family, cadfit.join(cadfit.fit(points, 1e-3 * size, closed=closed, effort="fast").curves)))
    for k in range(THREADS):
        t = np.linspace(0.0, 2.0 * np.pi * (4 + k), 40 * (4 + k))
        thread = np.column_stack([(3 + k) * np.cos(t), (3 + k) * np.sin(t), (0.5 + 0.1 * k) * t])
        found.append(("thread", cadfit.local_spline(thread)))
    return found


def judged(call: object, area: float, path: cadfit.BSpline) -> tuple[str, bool]:
    """Return what is wrong with a sweep, "" for nothing, and whether it was said to pass through itself."""
    said = False
    try:
        try:
            mesh = call("raise")  # type: ignore[operator]
        except SelfIntersectionError:
            said = True
            mesh = call("repair")  # type: ignore[operator]
    except Exception as error:
        return f"{type(error).__name__}: {error}", said
    if not (mesh.is_watertight and mesh.is_winding_consistent):
        return "not watertight", said
    if not mesh.volume > 0.0:
        return "no volume", said
    if not said and not mesh.area_faces.min() > 0.0:
        return "a face without area", said
    if not said and area and abs(mesh.volume / (area * path.length()) - 1.0) > 1e-3:
        return f"volume off by {100 * (mesh.volume / (area * path.length()) - 1.0):.2f} %", said
    return "", said


def table() -> str:
    counts: dict[str, Counter[str]] = {}
    wrong = []
    start = perf_counter()
    for family, path in paths():
        radius = path.size / 300.0
        bar = radius * np.array([[-1.5, -0.5], [1.5, -0.5], [1.5, 0.5], [-1.5, 0.5]])
        size: object = radius
        if family == "neuron":
            low, high = path.domain
            size = lambda u, r=radius, a=low, b=high: r * (1.2 - 0.7 * (u - a) / (b - a))  # noqa: E731
        sweeps = {
            "tube": (
                lambda way, p=path, r=size, t=0.2 * radius: cadfit.tube(p, r, t, on_self_intersection=way),
                0.0 if callable(size) else np.pi * radius**2,
            ),
            "bar": (
                lambda way, p=path, b=bar, t=0.2 * radius: cadfit.sweep(p, b, t, on_self_intersection=way),
                3.0 * radius**2,
            ),
        }
        count = counts.setdefault(family, Counter())
        count["paths"] += 1
        for name, (call, area) in sweeps.items():
            answer, _ = limited(LIMIT, judged, call, area, path)
            bad, said = answer or (f"no answer in {LIMIT:g} s", False)
            count["said"] += said
            if bad:
                count["wrong"] += 1
                wrong.append(f"{family} {count['paths']}, {name}: {bad}")
    rows = [
        "| family | paths | tubes and bars | said to meet themselves, repaired | wrong |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    whole: Counter[str] = sum(counts.values(), Counter())
    for family, count in [*counts.items(), ("all", whole)]:
        rows.append(f"| {family} | {count['paths']} | {2 * count['paths']} | {count['said']} | {count['wrong']} |")
    return "\n".join([*rows, "", f"In {perf_counter() - start:.0f} s.", *wrong])


if __name__ == "__main__":
    warnings.simplefilter("error")
    print(table())
