"""The paper's search: add a dominant point where the error is largest, drop one where it is smallest, while it helps.

Every dominant point's cost of being dropped is kept, and computed anew only near a swap; a heap and a tree hold the
orders. So a swap costs the evaluation of the pieces near it and a few steps per doubling of the number of points.
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.chain import padded, piece_errors, pieces_of, points_inside, square_distances, window_errors

_LEAST = 1e-12  # the part of the error by which a swap must lower it: less is rounding


def swapped(columns: Array, indices: Ints, turns: Array, closed: bool) -> tuple[Ints, list[float]]:
    """Return the dominant points after the swaps, and the total error before the first and after each.

    A swap adds the point farthest from its piece in the piece of the largest error, and drops an end of a piece of the
    smallest error: where pieces have none, the first of all their ends, by turn angle, then by row, with which the
    total error falls. The search ends where none of them does. Equal errors count in the order of rows.
    `columns` (d, n): the points; `turns` (n,): their turn angles.
    """
    chain = _Chain(columns, indices, turns, closed)
    while chain.swap():
        pass
    return chain.indices(), chain.history


class _First:
    """Numbers in a fixed order, infinite at first; finds the first one below a bound: a tree of minima."""

    def __init__(self, count: int) -> None:
        self.size = 1 << max(count - 1, 1).bit_length()
        self.least = [np.inf] * (2 * self.size)

    def __setitem__(self, place: int, value: float) -> None:
        least, node = self.least, place + self.size
        least[node] = value
        while node > 1:
            other = least[node ^ 1]
            value = value if value < other else other
            node >>= 1
            if least[node] == value:
                break
            least[node] = value

    def below(self, bound: float, place: int = 0) -> int:
        """Return the first place, from `place` on, whose number is below the bound; -1 if there is none."""
        least, node = self.least, place + self.size
        while least[node] >= bound:
            while node & 1:  # up, past the right children
                node >>= 1
            if node == 0:
                return -1
            node += 1
        while node < self.size:
            node *= 2
            if least[node] >= bound:
                node += 1
        return node - self.size


class _Chain:
    """Dominant points as a linked list, with the errors of the pieces (by their starts) and the costs of dropping."""

    def __init__(self, columns: Array, indices: Ints, turns: Array, closed: bool) -> None:
        self.columns, self.n = columns, columns.shape[1]
        self.least = _LEAST, (16.0 * np.finfo(np.float64).eps * float(np.abs(columns).max())) ** 2
        order = np.lexsort((np.arange(self.n), turns))
        self.row_at = order.tolist()
        self.place = np.argsort(order).tolist()  # of each row, by turn angle
        self.before, self.after = [-1] * self.n, [-1] * self.n
        rows = indices.tolist()
        self.first = rows[0]
        for left, right in zip(rows, rows[1:], strict=False):
            self.before[right], self.after[left] = left, right
        self.before[rows[0]], self.after[rows[-1]] = (rows[-1], rows[0]) if closed else (rows[0], rows[-1])
        self.fixed = set() if closed else {rows[0], rows[-1]}
        self.error = [0.0] * self.n
        pieces = pieces_of(indices, closed)
        for start, error in zip(pieces[:, 1].tolist(), piece_errors(columns, pieces).tolist(), strict=True):
            self.error[start] = error
        self.total = sum(self.error)
        self.history = [self.total]
        self.largest = [(-self.error[row], row) for row in rows]
        heapify(self.largest)
        self.smallest = [(error, row) for _, row in self.largest if (error := self.error[row])]
        heapify(self.smallest)
        self.cost = [0.0] * self.n  # of dropping each dominant point
        self.free = _First(self.n)  # those costs at the ends of pieces without error
        self.price(padded(indices, closed, 3).tolist())

    def indices(self) -> Ints:
        """Return the dominant points, rising."""
        rows, row = [self.first], self.after[self.first]
        while row not in (rows[0], rows[-1]):
            rows.append(row)
            row = self.after[row]
        return np.sort(np.array(rows, dtype=np.intp))

    def insert(self, row: int, left: int, right: int) -> None:
        self.before[row], self.after[row] = left, right
        self.after[left] = self.before[right] = row

    def remove(self, row: int) -> tuple[int, int]:
        """Take a row out, and return its neighbours."""
        left, right = self.before[row], self.after[row]
        self.after[left], self.before[right] = right, left
        self.before[row] = self.after[row] = -1
        return left, right

    def walk(self, row: int, back: int, ahead: int) -> list[int]:
        """Return the dominant points so many steps before and after one, itself in the middle."""
        left, right = [row], [row]
        for _ in range(back):
            left.append(self.before[left[-1]])
        for _ in range(ahead):
            right.append(self.after[right[-1]])
        return left[:0:-1] + right

    def price(self, *runs: list[int]) -> None:
        """Compute the costs of dropping the dominant points of each run but three at either end, and queue them."""
        windows = [run[k - 3 : k + 4] for run in runs for k in range(3, len(run) - 3) if run[k] not in self.fixed]
        if not windows:
            return
        errors = window_errors(self.columns, np.array(windows, dtype=np.intp)[:, [0, 1, 2, 4, 5, 6]]).tolist()
        for window, error in zip(windows, errors, strict=True):
            row = window[3]
            self.cost[row] = error - sum(self.error[start] for start in set(window[1:5]))
            self.queue(row)

    def queue(self, row: int) -> None:
        free = self.error[row] == 0.0 or self.error[self.before[row]] == 0.0
        self.free[self.place[row]] = self.cost[row] if free else np.inf

    def changed(self, starts: set[int]) -> tuple[list[int], list[float]]:
        """Return starts of pieces and the errors they have as the list stands."""
        rows = sorted(starts)
        pieces = np.array([self.walk(row, 1, 2) for row in rows], dtype=np.intp)
        return rows, piece_errors(self.columns, pieces).tolist()

    def swap(self) -> bool:
        """Make one swap, and return whether one was found."""
        largest, left = self.top(self.largest, -1.0)
        if largest == 0.0:
            return False
        right = self.after[left]
        piece = np.array([self.walk(left, 1, 2)], dtype=np.intp)
        squares = square_distances(self.columns, piece, points_inside(self.n, piece))[1]
        added = (left + 1 + int(np.argmax(squares))) % self.n
        near = {*self.walk(left, 4, 5)} - self.fixed
        free = [row for row in near if self.free.least[self.place[row] + self.free.size] < np.inf]
        for row in free:  # what dropping costs is not known here, but by trying
            self.free[self.place[row]] = -np.inf
        ends = self.smallest_ends()
        self.insert(added, left, right)
        starts = {*self.walk(added, 2, 1)}
        gain = sum(self.error[row] for row in starts) - sum(self.changed(starts)[1])
        needed = self.least[0] * self.total + self.least[1]
        found = any(self.drop(added, row, starts, needed) for row in ends) or self.drop_free(
            added, starts, gain, needed
        )
        if not found:
            self.remove(added)
        for row in free:
            if self.after[row] >= 0:
                self.queue(row)
        return found

    def top(self, heap: list[tuple[float, int]], sign: float) -> tuple[float, int]:
        """Return the piece (error, start) at the top of a heap, entries that no longer hold thrown away."""
        while self.after[heap[0][1]] < 0 or sign * heap[0][0] != self.error[heap[0][1]]:
            heappop(heap)
        return sign * heap[0][0], heap[0][1]

    def smallest_ends(self) -> list[int]:
        """Return the ends of the piece of the smallest error, where all have some, in the order to try them."""
        if self.free.least[1] < np.inf:
            return []
        _, start = self.top(self.smallest, 1.0)
        ends = {start, self.after[start]} - self.fixed
        return sorted(ends, key=lambda row: self.place[row])

    def drop_free(self, added: int, starts: set[int], gain: float, needed: float) -> bool:
        """Drop the first end of a piece without error that lowers the total, and return whether there is one."""
        place = self.free.below(gain - needed)
        while place >= 0:
            if self.drop(added, self.row_at[place], starts, needed):
                return True
            place = self.free.below(gain - needed, place + 1) if place + 1 < self.n else -1
        return False

    def drop(self, added: int, row: int, starts: set[int], needed: float) -> bool:
        """Drop a dominant point if with the one added that lowers the total, and return whether it does."""
        left, right = self.remove(row)
        rows, errors = self.changed((starts - {row}) | {self.before[left], left, right})
        fall = self.error[row] + sum(self.error[start] for start in rows) - sum(errors)
        if not fall > needed:
            self.insert(row, left, right)
            return False
        self.free[self.place[row]] = np.inf
        self.error[row] = 0.0
        for start, error in zip(rows, errors, strict=True):
            self.error[start] = error
            heappush(self.largest, (-error, start))
            if error:
                heappush(self.smallest, (error, start))
        if self.first == row:
            self.first = added
        self.total -= fall
        self.history.append(self.total)
        self.price(self.walk(added, 7, 7), self.walk(left, 5, 6))
        return True
