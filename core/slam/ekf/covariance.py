"""The covariance of the whole state: stored once, changed in place."""

from functools import lru_cache

import numpy as np
import scipy

from core.message import Array

BLOCK_SIZE = 64  # capacity comes in multiples of this


class Covariance:
    """A symmetric matrix (size, size) in the upper triangle of a padded square, Fortran order.

    The cost of a large filter is the traffic of this matrix through memory; so it is touched as a whole only by
    `lower` and `lift`, each one pass over half of it.
    """

    def __init__(self, start: Array) -> None:
        self.size = len(start)
        self._square = np.zeros((BLOCK_SIZE, BLOCK_SIZE), order="F")
        self._square[: self.size, : self.size] = np.triu(start)

    def row(self, index: int) -> Array:
        """Row `index` in full (size,)."""
        full = np.empty(self.size)
        full[:index] = self._square[:index, index]
        full[index:] = self._square[index, index : self.size]
        return full

    def rows(self, indices: Array) -> Array:
        """Rows (..., ) of indices → (..., size)."""
        size, flat = self.size, indices.ravel()
        full = self._square[:size, flat].T
        for row, index in enumerate(flat.tolist()):
            full[row, index:] = self._square[index, index:size]
        return full.reshape(*indices.shape, size)

    def first_rows(self, count: int) -> Array:
        """The first rows (count, size)."""
        full = self._square[:count, : self.size].copy()
        full[:, :count] = self.block(0, count)
        return full

    def block(self, first: int, count: int) -> Array:
        """The square block (count, count) on the diagonal from `first`."""
        upper = self._square[first : first + count, first : first + count]
        return np.where(_below_diagonal(count), upper.T, upper)

    def diagonal(self, offset: int = 0) -> Array:
        """Diagonal `offset` places above the main one (size - offset,)."""
        return np.diagonal(self._square, offset)[: self.size - offset].copy()

    def dense(self) -> Array:
        """The whole matrix (size, size), for tests and for looking at it."""
        return self.block(0, self.size)

    def lower(self, factor: Array) -> None:
        """P ← P − WᵀW with W (k, size)."""
        self._accumulate(-1.0, self._padded(factor))

    def lift(self, factor: Array) -> None:
        """P ← P + WᵀW with W (k, size)."""
        self._accumulate(1.0, self._padded(factor))

    def add_to_row(self, index: int, change: Array) -> None:
        """Add `change` (size,) to a row and to the column of the same index; the diagonal element once."""
        self._square[:index, index] += change[:index]
        self._square[index, index : self.size] += change[index:]

    def add_to_block(self, first: int, change: Array) -> None:
        """Add `change` (k, k), symmetric, to the square block on the diagonal from `first`."""
        last = first + len(change)
        self._square[first:last, first:last] += np.triu(change)

    def append(self, rows: Array, block: Array) -> None:
        """New states with covariances `rows` (k, size) to the present ones and `block` (k, k) among themselves."""
        count, size = len(block), self.size
        if size + count > len(self._square):
            capacity = max(2 * len(self._square), -(-(size + count) // BLOCK_SIZE) * BLOCK_SIZE)
            larger = np.zeros((capacity, capacity), order="F")
            larger[:size, :size] = self._square[:size, :size]
            self._square = larger
        self._square[:size, size : size + count] = rows.T
        self._square[size : size + count, size : size + count] = np.triu(block)
        self.size += count

    def insert(self, first: int, rows: Array, block: Array) -> None:
        """New states as `append` has them, but before state `first`; what is behind it moves back."""
        size, count = self.size, len(block)
        self.append(rows, block)
        if first < size:
            order = np.r_[:first, size : size + count, first:size]
            self._square[: self.size, : self.size] = np.triu(self.dense()[np.ix_(order, order)])

    def drop(self, first: int, count: int) -> None:
        """Forget the states from `first` on (marginalise): their rows and columns go."""
        size, rest = self.size, self.size - count
        square = self._square
        square[:first, first:rest] = square[:first, first + count : size]
        square[first:rest, first:rest] = square[first + count : size, first + count : size]
        square[:, rest:size] = 0.0
        square[rest:size, :] = 0.0
        self.size = rest

    def absorb(self, crossing: Array, innovation: Array, residual: Array) -> Array:
        """One stacked update (eq. 28-30 without the inverse) → the correction of the state (size,).

        `crossing` HP (k, size), `innovation` S (k, k), symmetric, `residual` ν (k,): with S = LLᵀ and W = L⁻¹HP,
        P ← P − WᵀW, correction WᵀL⁻¹ν. Raises ValueError if S is not positive definite.
        """
        root, failed = scipy.linalg.lapack.dpotrf(innovation, lower=1)
        if failed:
            raise ValueError("The innovation covariance is not positive definite.")
        padded = np.zeros((len(crossing), 1 + len(self._square)), order="F")
        padded[:, : self.size], padded[:, -1] = crossing, residual
        solved, _ = scipy.linalg.lapack.dtrtrs(root, padded, lower=1, overwrite_b=1)
        self._accumulate(-1.0, solved[:, :-1])
        return solved[:, : self.size].T @ solved[:, -1]

    def _padded(self, factor: Array) -> Array:
        """W (k, size) → the same (k, capacity), zero where there are no states."""
        padded = np.zeros((len(factor), len(self._square)), order="F")
        padded[:, : self.size] = factor
        return padded

    def _accumulate(self, sign: float, padded: Array) -> None:
        """P ← P + sign WᵀW in place: dsyrk copies anything but a whole Fortran-ordered array, so it gets that."""
        changed = scipy.linalg.blas.dsyrk(sign, padded, beta=1.0, c=self._square, trans=1, lower=0, overwrite_c=1)
        assert np.shares_memory(changed, self._square), "dsyrk worked on a copy"


@lru_cache(maxsize=4)
def _below_diagonal(count: int) -> Array:
    """Mask (count, count) of what lies below the diagonal."""
    return np.tri(count, k=-1, dtype=bool)
