"""How long certifying takes: `cadfit.deviation` of 1e4 to 1e6 points, and how it grows."""

import numpy as np

import cadfit

from timing import interleaved

SIZES = (10_000, 100_000, 1_000_000)


def table() -> str:
    rows = [
        "| points | curve through every 1,000th part | noisy points, same curve | through all: local | cardinal |",
        "| ---: | ---: | ---: | ---: | ---: |",
    ]
    for n in SIZES:
        t = np.linspace(0.0, 60.0, n)
        points = np.column_stack([np.cos(t), np.sin(t), t / 9.0])
        noisy = points + 1e-3 * np.random.default_rng(0).normal(size=points.shape)
        coarse = cadfit.local_spline(points[np.linspace(0, n - 1, 1_000).astype(int)])
        local, cardinal = cadfit.local_spline(points), cadfit.cardinal_spline(points)
        pairs = [(coarse, points), (coarse, noisy), (local, points), (cardinal, points)]
        times = interleaved([lambda pair=pair: cadfit.deviation(*pair) for pair in pairs], 3)
        rows.append(f"| {n:,} | " + " | ".join(f"{seconds:.3f} s" for seconds in times) + " |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
