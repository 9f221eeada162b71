"""Lines and arcs with the decimals of a controller."""

from __future__ import annotations

from itertools import product

import numpy as np

from cadfit.arcing.stretch import Chain
from cadfit.bezier import Array, Ints

_AROUND = np.array(list(product(range(-2, 3), repeat=2)), dtype=np.float64)  # steps from the exact centre


def rounded(chain: Chain, first: Ints, decimals: int) -> tuple[Chain, Ints]:
    """Return the chain with joints and centres rounded to `decimals`, and the rows at which its stretches begin then.

    Of the centres near the exact one the one is taken for which the radii at both ends differ least. Lines and arcs
    whose ends become one are left out.
    """
    joints = np.round(chain.joints, decimals) + 0.0
    apart = (np.diff(joints, axis=0) != 0.0).any(axis=1)
    if not apart.any():
        raise ValueError(f"with {decimals} decimals nothing is left of the curve")
    keep = np.append(apart, True)
    # The last joint of all stays where it is; one before it that equals it goes, not it.
    starts, at = joints[keep], chain.at[keep]
    at[0] = chain.at[0]
    sweeps = chain.sweeps[apart]
    centres = _centres(starts, sweeps, 10.0**-decimals, decimals)
    arms = (starts[:-1] - centres, starts[1:] - centres)
    cross = arms[0][:, 0] * arms[1][:, 1] - arms[0][:, 1] * arms[1][:, 0]
    angle = np.arctan2(cross, np.einsum("md,md->m", *arms))
    angle = np.where(angle * sweeps < 0.0, np.sign(sweeps) * (2.0 * np.pi - np.abs(angle)), angle)
    begin = np.cumsum(np.concatenate([[0], apart]))[first]
    return Chain(starts, at, centres, np.where(sweeps == 0.0, 0.0, angle)), begin


def _centres(joints: Array, sweeps: Array, step: float, decimals: int) -> Array:
    """Return the rounded centres (m, 2) of arcs of these sweeps between joints (m + 1, 2); not finite for lines."""
    chord = np.diff(joints, axis=0)
    line = sweeps == 0.0
    height = np.where(line, np.nan, 1.0 / np.where(line, 1.0, 2.0 * np.tan(0.5 * sweeps)))
    exact = 0.5 * (joints[:-1] + joints[1:]) + height[:, None] * np.column_stack([-chord[:, 1], chord[:, 0]])
    choice = np.round(exact[:, None] + step * _AROUND, decimals) + 0.0
    radii = [np.linalg.norm(choice - end[:, None], axis=2) for end in (joints[:-1], joints[1:])]
    uneven = np.where(line[:, None], 0.0, np.abs(radii[1] - radii[0]))
    return np.asarray(choice[np.arange(len(choice)), np.argmin(uneven, axis=1)])
