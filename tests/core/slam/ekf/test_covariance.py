import numpy as np
import pytest

from core.slam.ekf.covariance import Covariance


def spread(size: int, seed: int = 0) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(size, size + 3))
    return root @ root.T


def stored(matrix: np.ndarray) -> Covariance:
    """The matrix, grown state by state as a filter grows it."""
    covariance = Covariance(matrix[:3, :3])
    for first in range(3, len(matrix), 2):
        last = first + 2
        covariance.append(matrix[first:last, :first], matrix[first:last, first:last])
    return covariance


@pytest.mark.parametrize("size", [5, 63, 65, 131])
def test_what_was_put_in_comes_out(size: int) -> None:
    matrix = spread(size)
    covariance = stored(matrix)
    assert np.allclose(covariance.dense(), matrix)
    assert np.allclose(covariance.rows(np.array([[0, 2], [4, 3]])), matrix[[[0, 2], [4, 3]]])
    assert np.allclose(covariance.diagonal(1), np.diagonal(matrix, 1))
    assert np.allclose(covariance.block(1, 3), matrix[1:4, 1:4])


@pytest.mark.parametrize("size", [5, 63, 65, 131])
def test_the_stacked_update_is_the_textbook_s(size: int) -> None:
    matrix, rng = spread(size), np.random.default_rng(1)
    covariance = stored(matrix)
    slopes, noise = rng.normal(size=(6, size)), 0.5 * np.eye(6)
    residual = rng.normal(size=6)
    innovation = slopes @ matrix @ slopes.T + noise
    gain = matrix @ slopes.T @ np.linalg.inv(innovation)
    correction = covariance.absorb(slopes @ matrix, innovation, residual)
    assert np.allclose(correction, gain @ residual)
    assert np.allclose(covariance.dense(), (np.eye(size) - gain @ slopes) @ matrix, atol=1e-9 * matrix.max())


def test_the_update_works_in_the_array_that_is_there() -> None:
    covariance = stored(spread(131))
    square = covariance._square
    covariance.lower(0.01 * np.ones((4, 131)))
    covariance.lift(0.01 * np.ones((4, 131)))
    assert covariance._square is square
    assert np.allclose(covariance.dense(), spread(131))


def test_dropping_states_is_marginalising() -> None:
    matrix = spread(71)
    covariance = stored(matrix)
    covariance.drop(5, 2)
    covariance.drop(67, 2)
    kept = [index for index in range(71) if index not in (5, 6, 69, 70)]
    assert np.allclose(covariance.dense(), matrix[np.ix_(kept, kept)])
    covariance.append(np.zeros((2, 67)), np.eye(2))
    assert np.allclose(covariance.dense()[67:, :67], 0.0)


def test_adding_to_a_row_keeps_symmetry() -> None:
    matrix, change = spread(9), np.arange(9.0)
    covariance = stored(matrix)
    covariance.add_to_row(1, change)
    matrix[1] += change
    matrix[:, 1] += change
    matrix[1, 1] -= change[1]
    assert np.allclose(covariance.dense(), matrix)


def test_an_impossible_innovation_is_refused() -> None:
    covariance = stored(spread(5))
    with pytest.raises(ValueError, match="positive definite"):
        covariance.absorb(np.zeros((2, 5)), -np.eye(2), np.zeros(2))
