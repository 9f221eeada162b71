"""How much memory a fit takes: the largest resident size of a process of its own, over that before the fit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

import cadfit


def synthetic(n, noise):
    """An open space curve of size 50, and Gaussian noise on it."""
    t = np.linspace(0.0, 1.0, n)
    points = np.column_stack([np.cos(9 * t) * (1 + t) * 10, np.sin(7 * t) * 10, 5 * np.sin(23 * t)])
    return points + np.random.default_rng(1).normal(scale=noise, size=points.shape) if noise else points


def memory(n, noise, tolerance):
    """The poles of a fit of so many points, and how many bytes it takes besides them."""
    call = [sys.executable, __file__, str(n), str(noise), str(tolerance)]
    poles, grown = subprocess.run(call, capture_output=True, check=True).stdout.split()
    return int(poles), int(grown)


def main(n, noise, tolerance):
    """Print the same for this process."""
    points = synthetic(n, noise)
    cadfit.fit(points[:: n // 50], 10 * tolerance, effort="fast")  # imports
    before = largest()
    fit = cadfit.fit(points, tolerance, effort="fast")
    print(fit.poles, largest() - before)


def largest():
    """The largest resident size so far, in bytes; Linux's own account, for getrusage's starts at the parent's."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return 1024 * int(line.split()[1])


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]))
