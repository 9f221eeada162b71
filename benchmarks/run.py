"""All tables the README quotes: python benchmarks/run.py, with a host's kernel installed."""

import curves
import deviations
import edges
import tubes

if __name__ == "__main__":
    for part in (curves, tubes, edges, deviations):
        print(f"\n{part.__doc__}\n")
        print(part.table(), flush=True)
