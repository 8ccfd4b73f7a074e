"""Levenberg-Marquardt: the damped descent that every solver here shares, and small dense problems solved with it."""

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from core.message import Array

State = TypeVar("State")
Linear = TypeVar("Linear")

FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-9


class Linearisation(NamedTuple, Generic[State, Linear]):
    """A problem at one state."""

    state: State
    linear: Linear  # what the next step is computed from
    cost: float  # not finite where the state is not admissible


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


def descend(
    linearise: Callable[[State], Linearisation[State, Linear]],
    advance: Callable[[State, Linear, float], tuple[State, float]],
    start: State,
    *,
    iterations: int,
    close: float,
    hopeless: float = 1e9,
    damping: float = FIRST_DAMPING,
) -> Linearisation[State, Linear]:
    """Descend until no more than the share `close` of the cost is to be gained, or the damping exceeds `hopeless`.

    `damping`: the first; less where the start is near.
    `advance(state, linear, damping)` takes a step whose information has its diagonal raised by the factor
    1 + damping, and promises by how much that lowers the cost.
    """
    here = linearise(start)
    for _ in range(iterations):
        state, promised = advance(here.state, here.linear, damping)
        if damping <= FIRST_DAMPING and promised <= close * here.cost:
            break
        there = linearise(state)
        if np.isfinite(there.cost) and there.cost <= here.cost:
            gain, here = here.cost - there.cost, there
            damping = max(damping / 10, LEAST_DAMPING)
            if gain <= close * here.cost:
                break
        else:
            damping *= 10
            if damping > hopeless:
                break
    return here


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

    def linearise(state: State) -> Linearisation[State, tuple[Array, Array]]:
        residuals, jacobian = model(state)
        return Linearisation(state, (residuals, jacobian), _cost(residuals, soft))

    def advance(state: State, linear: tuple[Array, Array], damping: float) -> tuple[State, float]:
        residuals, jacobian = linear
        weights = np.ones_like(residuals) if soft is None else soft_weights(residuals, soft)
        information = (jacobian.T * weights) @ jacobian
        gradient = jacobian.T @ (weights * residuals)
        diagonal = np.maximum(np.diag(information), 1e-12 * max(1e-12, float(np.trace(information))))
        step = np.linalg.lstsq(information + np.diag(damping * diagonal), -gradient, rcond=1e-15)[0]
        return move(state, step), float(-gradient @ step)

    found = descend(linearise, advance, start, iterations=iterations, close=1e-12)
    return LeastSquaresFit(found.state, *found.linear, found.cost)


def _cost(residuals: Array, soft: float | None) -> float:
    if soft is None:
        return float(residuals @ residuals)
    return float((2 * soft**2 * (np.sqrt(1 + (residuals / soft) ** 2) - 1)).sum())
