"""The paper's search: add a dominant point where the error is largest, drop one where it is smallest, while it helps.

What dropping a dominant point costs is kept, and is computed anew only near a swap and when it is asked for; heaps and
a tree hold the orders. So a swap costs some pieces near it, in plain floats, and a few steps per doubling of the number
of points. Plain arrays instead of lists keep those steps within the processor's caches at many points.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from heapq import heapify, heappop, heappush
from math import inf

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.dominant_pieces import drop_costs, padded, piece_squares, square_distances, start_errors
from cadfit.stages import Progress, unheard

_LEAST = 1e-12  # the part of the error by which a swap must lower it: less is rounding
_REPORT = 1000  # swaps between two reports of progress
_KNOWN = 1 << 18  # pieces whose errors are remembered: some 40 MB
_FEW = 60  # points inside a piece that are summed in plain floats; with more, numpy's calls pay


def swapped(
    columns: Array, indices: Ints, turns: Array, closed: bool, progress: Progress = unheard
) -> tuple[Ints, list[float]]:
    """Return the dominant points after the swaps, and the total error before the first and after each.

    A swap adds the point farthest from its piece in the piece of the largest error, and drops an end of a piece of the
    smallest error: where pieces have none, the first of all their ends, by turn angle, then by row, with which the
    total error falls. The search ends where none of them does. Equal errors count in the order of rows.
    `columns` (d, n): the points; `turns` (n,): their turn angles. How many swaps there will be is not known: `progress`
    is half when there were as many as dominant points.
    """
    chain = _Chain(columns, indices, turns, closed)
    while chain.swap():
        if len(chain.history) % _REPORT == 0:
            progress(len(chain.history) / (len(chain.history) + len(indices)))
    return chain.indices(), chain.history


def _floats(numbers: Array) -> array[float]:
    return array("d", numbers.tobytes())


def _ints(numbers: Ints) -> array[int]:
    return array("q", numbers.astype(np.int64).tobytes())


class _First:
    """Numbers in a fixed order, some in doubt; finds the first below a bound: a tree of minima, a heap of doubts."""

    def __init__(self, numbers: Array) -> None:
        self.size = 1 << max(len(numbers) - 1, 1).bit_length()
        levels = [np.pad(numbers, (0, self.size - len(numbers)), constant_values=inf)]
        while len(levels[-1]) > 1:
            levels.append(levels[-1].reshape(-1, 2).min(axis=1))
        self.least = _floats(np.concatenate([[inf], *levels[::-1]]))
        self.doubtful, self.doubts = bytearray(self.size), list[int]()  # a heap, also of some that are settled

    def __getitem__(self, place: int) -> float:
        return self.least[place + self.size]

    def __setitem__(self, place: int, value: float) -> None:
        self.doubtful[place] = False
        least, node = self.least, place + self.size
        if least[node] == value:
            return
        least[node] = value
        while node > 1:
            other = least[node ^ 1]
            value = value if value < other else other
            node >>= 1
            if least[node] == value:
                break
            least[node] = value

    def __contains__(self, place: int) -> bool:
        """Return whether there is a number, known or in doubt: infinity is none."""
        return self.least[place + self.size] < inf or bool(self.doubtful[place])

    def doubt(self, place: int) -> None:
        """Have the number asked for anew: what there is holds no longer."""
        if not self.doubtful[place]:
            self.doubtful[place] = True
            heappush(self.doubts, place)

    def any(self) -> bool:
        """Return whether there is any number, known or in doubt."""
        return self.least[1] < inf or self.first_doubt() < self.size

    def first_doubt(self) -> int:
        """Return the first place whose number is in doubt; `size`: none is."""
        doubts = self.doubts
        while doubts and not self.doubtful[doubts[0]]:
            heappop(doubts)
        return doubts[0] if doubts else self.size

    def first_below(self, bound: float, place: int = 0) -> int:
        """Return the first place, from `place` on, whose number was below the bound when it was known; `size`: none."""
        least, node = self.least, place + self.size
        if place >= self.size:
            return self.size
        while least[node] >= bound:
            while node & 1:  # up, past the right children
                node >>= 1
            if node == 0:
                return self.size
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
        xyz = np.pad(columns, ((0, max(3 - len(columns), 0)), (0, 0)))[:3]
        self.xs, self.ys, self.zs = (_floats(axis) for axis in xyz)
        self.few = _FEW if len(columns) <= 3 else 0
        self.rounding = (16.0 * np.finfo(np.float64).eps * float(np.abs(columns).max())) ** 2
        order = np.lexsort((np.arange(self.n), turns))
        self.row_at, self.place = _ints(order), _ints(np.argsort(order))  # by turn angle
        self.fixed = set() if closed else {int(indices[0]), int(indices[-1])}
        links = np.full((2, self.n), -1)
        rows = padded(indices, closed, 1)
        links[:, indices] = rows[:-2], rows[2:]
        self.before, self.after = _ints(links[0]), _ints(links[1])
        errors, costs = np.zeros(self.n), np.full(self.n, inf)
        errors[indices] = ahead = start_errors(columns, indices, closed)
        free = (ahead == 0.0) | (np.roll(ahead, 1) == 0.0)
        costs[indices] = np.where(free, drop_costs(columns, indices, closed, ahead)[0], inf)
        self.error = _floats(errors)
        self.known: dict[tuple[int, ...], float] = {}  # errors of pieces: half are asked for again
        self.free = _First(costs[order])  # of the ends of pieces without error
        self.smallest = [(self.error[row], row) for row in np.flatnonzero(errors).tolist()]
        self.largest = [(-error, row) for error, row in self.smallest]
        heapify(self.largest)
        heapify(self.smallest)
        self.history = [sum(self.error)]
        self.summed = self.history[0]  # the last error that is a sum: what is taken off it adds up roundings

    def indices(self) -> Ints:
        """Return the dominant points, rising."""
        return np.flatnonzero(np.array(self.after) >= 0)

    def swap(self) -> bool:
        """Make one swap, and return whether there is one; where there is none, what is kept holds no longer."""
        largest, left = self.top(self.largest, -1.0)
        if largest == 0.0:
            return False
        right = self.after[left]
        squares = self.squares(self.before[left], left, right, self.after[right])
        added = (left + 1 + squares.index(max(squares))) % self.n
        ends = self.smallest_ends()
        near = self.walk(left, 2, 3)  # those whose cost of being dropped the added one changes
        for row in near:
            if self.place[row] in self.free:
                self.free.doubt(self.place[row])
        self.link(added, left, right)
        gain = self.update({self.before[left], left, added, right})
        needed = _LEAST * self.history[-1] + self.rounding
        for row, cost in self.costs(ends) if ends else self.free_costs(gain - needed):
            if gain - cost > needed:
                self.queue({row, added, *near, *self.drop(row)})
                self.history.append(self.lowered(gain - cost))
                return True
        self.unlink(added)
        return False

    def lowered(self, fall: float) -> float:
        """Return the total error that falls by so much, summed anew where it has halved since that was done."""
        total = self.history[-1] - fall
        if total >= 0.5 * self.summed:
            return total
        self.summed = sum(self.error)
        return self.summed if self.summed < self.history[-1] else total

    def smallest_ends(self) -> list[int]:
        """Return the ends of the piece of the smallest error, where all have some, in the order to try them."""
        if self.free.any():
            return []
        _, start = self.top(self.smallest, 1.0)
        return sorted({start, self.after[start]} - self.fixed, key=lambda row: self.place[row])

    def costs(self, rows: list[int]) -> Iterator[tuple[int, float]]:
        """Yield dominant points with what dropping each costs."""
        return ((row, self.cost(row)) for row in rows)

    def free_costs(self, bound: float) -> Iterator[tuple[int, float]]:
        """Yield the ends of pieces without error that may cost less than the bound, in order, and what each costs."""
        free, row_at = self.free, self.row_at
        known, doubt = free.first_below(bound), free.first_doubt()
        while min(known, doubt) < free.size:
            place = min(known, doubt)
            if place == doubt:
                free[place] = self.cost(row_at[place])
                doubt = free.first_doubt()
            if free[place] < bound:
                yield row_at[place], free[place]
            if place == known:
                known = free.first_below(bound, place + 1)

    def cost(self, row: int) -> float:
        """Return by how much the total error rises when a dominant point is dropped."""
        left, right = self.before[row], self.after[row]
        first, last = self.before[left], self.after[right]
        error = self.error
        rise = self.piece_error(first, left, right, last) - error[left] - error[row] - error[right]
        rise += self.piece_error(left, right, last, self.after[last])
        if first != left:  # not an open curve's end
            rise += self.piece_error(self.before[first], first, left, right) - error[first]
        return rise

    def drop(self, row: int) -> list[int]:
        """Take a row out, and return those whose costs of dropping that changes."""
        left, right = self.unlink(row)
        self.error[row] = 0.0
        self.update({self.before[left], left, right})
        return self.walk(left, 2, 3)

    def queue(self, rows: Iterable[int]) -> None:
        """Have the costs of dropping rows computed when asked for, of those that are ends of pieces without error."""
        error, before, after, free = self.error, self.before, self.after, self.free
        for row in rows:
            place = self.place[row]
            if (error[row] == 0.0 or error[before[row]] == 0.0) and after[row] >= 0 and row not in self.fixed:
                free.doubt(place)
            elif place in free:
                free[place] = inf

    def update(self, starts: Iterable[int]) -> float:
        """Compute the errors of pieces, by their starts, anew, and return by how much they fall in all."""
        fall = 0.0
        for start in starts:
            end = self.after[start]
            error, old = self.piece_error(self.before[start], start, end, self.after[end]), self.error[start]
            if error != old:
                fall += old - error
                self.error[start] = error
                if error:
                    heappush(self.largest, (-error, start))
                    heappush(self.smallest, (error, start))
        return fall

    def piece_error(self, *piece: int) -> float:
        if (piece[2] - piece[1]) % self.n == 1:
            return 0.0
        known = self.known.get(piece)
        if known is not None:
            return known
        total = 0.0
        for square in self.squares(*piece):  # not sum, which rounds in another way, and otherwise than the other code
            total += square
        if len(self.known) >= _KNOWN:
            self.known.clear()
        self.known[piece] = total
        return total

    def squares(self, *piece: int) -> list[float]:
        """Return the squared distances of the points inside a piece."""
        inside = (piece[2] - piece[1]) % self.n - 1
        if inside < 1:
            return []
        if inside <= self.few:
            return piece_squares(self.xs, self.ys, self.zs, *piece)
        found: list[float] = square_distances(self.columns, np.array([piece]), np.array([inside]))[1].tolist()
        return found

    def top(self, heap: list[tuple[float, int]], sign: float) -> tuple[float, int]:
        """Return the piece (error, start) at the top of a heap, entries that no longer hold thrown away; 0: none."""
        while heap and (self.after[heap[0][1]] < 0 or sign * heap[0][0] != self.error[heap[0][1]]):
            heappop(heap)
        return (sign * heap[0][0], heap[0][1]) if heap else (0.0, -1)

    def link(self, row: int, left: int, right: int) -> None:
        self.before[row], self.after[row] = left, right
        self.after[left] = self.before[right] = row

    def unlink(self, row: int) -> tuple[int, int]:
        """Take a row out, and return its neighbours."""
        left, right = self.before[row], self.after[row]
        self.after[left], self.before[right] = right, left
        self.before[row] = self.after[row] = -1
        return left, right

    def walk(self, row: int, back: int, ahead: int) -> list[int]:
        """Return the dominant points so many steps before and after one, itself in the middle."""
        for _ in range(back):
            row = self.before[row]
        rows = [row]
        for _ in range(back + ahead):
            rows.append(self.after[rows[-1]])
        return rows
