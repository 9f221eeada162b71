"""The tables the README quotes: python benchmarks/run.py [name ...], with build123d's kernel installed; all by default.

Together they take about an hour, most of it promise, literature and poles.
"""

import sys
from importlib import import_module

PARTS = (
    "curves",
    "tubes",
    "edges",
    "deviations",
    "fits",
    "poles",
    "chart",
    "literature",
    "promise",
    "batch",
    "toolpaths",
)

if __name__ == "__main__":
    for name in sys.argv[1:] or PARTS:
        part = import_module(name)
        print(f"\n{part.__doc__}\n")
        print(part.table(), flush=True)
