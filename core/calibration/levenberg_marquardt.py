"""Levenberg-Marquardt for small dense problems."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from core.message import Array

State = TypeVar("State")


class LeastSquaresFit(NamedTuple, Generic[State]):
    """The result of the minimisation."""

    state: State
    residuals: Array  # (K,)
    jacobian: Array  # (K, P)
    cost: float  # sum of squares, or of the robust loss

    @property
    def information(self) -> Array:
        """(P, P): JᵀJ."""
        return self.jacobian.T @ self.jacobian


def soft_weights(lengths: Array, scale: float) -> Array:
    """Error lengths and the soft-L1 scale in the same unit → weights of the squares."""
    return 1 / np.sqrt(1 + (lengths / scale) ** 2)


def soft_costs(lengths: Array, scale: float) -> Array:
    """Error lengths → their soft-L1 costs, like the squares for small errors."""
    return 2 * scale**2 * (np.sqrt(1 + (lengths / scale) ** 2) - 1)


def minimise(
    model: Callable[[State], tuple[Array, Array]],
    start: State,
    move: Callable[[State, Array], State],
    *,
    soft: float | None = None,
    iterations: int = 50,
) -> LeastSquaresFit[State]:
    """Minimise the sum of squared residuals, or with `soft` their soft-L1 loss of that scale.

    `model(state)` gives residuals (K,) and their Jacobian (K, P) by the step that `move(state, step)` takes.
    """
    state, damping = start, 1e-3
    residuals, jacobian = model(state)
    cost = _cost(residuals, soft)
    for _ in range(iterations):
        weights = np.ones_like(residuals) if soft is None else soft_weights(residuals, soft)
        information = (jacobian.T * weights) @ jacobian
        gradient = jacobian.T @ (weights * residuals)
        diagonal = np.maximum(np.diag(information), 1e-12 * max(1e-12, float(np.trace(information))))
        step = np.linalg.lstsq(information + np.diag(damping * diagonal), -gradient, rcond=1e-15)[0]
        moved = move(state, step)
        new_residuals, new_jacobian = model(moved)
        new_cost = _cost(new_residuals, soft)
        if np.isfinite(new_cost) and new_cost <= cost:
            settled = cost - new_cost < 1e-12 * cost + 1e-300
            state, residuals, jacobian, cost = moved, new_residuals, new_jacobian, new_cost
            damping = max(damping / 10, 1e-9)
            if settled:
                break
        else:
            damping *= 10
            if damping > 1e9:
                break
    return LeastSquaresFit(state, residuals, jacobian, cost)


def _cost(residuals: Array, soft: float | None) -> float:
    return float(residuals @ residuals) if soft is None else float(soft_costs(residuals, soft).sum())
