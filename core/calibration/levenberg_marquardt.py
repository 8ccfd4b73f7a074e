"""Levenberg-Marquardt: the damped descent that every solver here shares, and small dense problems solved with it."""

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from core.message import Array

State = TypeVar("State")
Linear = TypeVar("Linear")
Place = TypeVar("Place")

FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-9


class Linearisation(NamedTuple, Generic[State, Linear]):
    """M independent problems at one state, M = 1 for a problem that is solved as a whole."""

    state: State
    linear: Linear  # what the next step is computed from
    costs: Array  # (M,); not finite where the state is not admissible


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


def whole(better: Array, there: Place, here: Place) -> Place:
    """Choose for a problem that is solved as a whole: `there` if it improved."""
    return there if better.all() else here


def descend(
    linearise: Callable[[State], Linearisation[State, Linear]],
    advance: Callable[[State, Linear, Array], State],
    start: State,
    *,
    iterations: int,
    close: float,
    hopeless: float = 1e9,
    choose: Callable[
        [Array, Linearisation[State, Linear], Linearisation[State, Linear]], Linearisation[State, Linear]
    ] = whole,
) -> Linearisation[State, Linear]:
    """Descend until no problem gains more than the share `close` of its cost, or its damping exceeds `hopeless`.

    `advance(state, linear, damping (M,))` takes a step whose information has its diagonal raised by the factor
    1 + damping; `choose(better (M,), there, here)` moves the problems that improved.
    """
    here = linearise(start)
    damping = np.full(here.costs.shape, FIRST_DAMPING)
    for _ in range(iterations):
        there = linearise(advance(here.state, here.linear, damping))
        better = np.isfinite(there.costs) & (there.costs <= here.costs)
        before, here = here.costs, choose(better, there, here)
        damping = np.maximum(np.where(better, damping / 10, damping * 10), LEAST_DAMPING)
        if ((before - here.costs <= close * here.costs) & (better | (damping > hopeless))).all():
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
        return Linearisation(state, (residuals, jacobian), np.array([_cost(residuals, soft)]))

    def advance(state: State, linear: tuple[Array, Array], damping: Array) -> State:
        residuals, jacobian = linear
        weights = np.ones_like(residuals) if soft is None else soft_weights(residuals, soft)
        information = (jacobian.T * weights) @ jacobian
        gradient = jacobian.T @ (weights * residuals)
        diagonal = np.maximum(np.diag(information), 1e-12 * max(1e-12, float(np.trace(information))))
        return move(state, np.linalg.lstsq(information + np.diag(damping * diagonal), -gradient, rcond=1e-15)[0])

    found = descend(linearise, advance, start, iterations=iterations, close=1e-12)
    return LeastSquaresFit(found.state, *found.linear, float(found.costs[0]))


def _cost(residuals: Array, soft: float | None) -> float:
    return float(residuals @ residuals) if soft is None else float(soft_costs(residuals, soft).sum())
