"""Analytic problems on the unit box, each with one difficulty that real scores have."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import Problem

Values = Callable[[Float[np.ndarray, "k n"]], Float[np.ndarray, "k"]]


def _summit(dim: int) -> Float[np.ndarray, "n"]:
    return np.linspace(-0.4, 0.3, dim) if dim > 1 else np.array([0.3])


def _depth(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
    return np.sum((points - _summit(points.shape[1])) ** 2, axis=1)


def bowl(dim: int) -> Problem:
    """A smooth bowl upside down; its maximum is 1."""
    return Problem(dim, lambda points: 1.0 - _depth(points))


def staircase(dim: int) -> Problem:
    """The bowl in steps of 1/64, as a count is: piecewise constant."""
    return Problem(dim, lambda points: np.floor(64.0 * (1.0 - _depth(points))) / 64.0)


def nan_pocket(dim: int) -> Problem:
    """The bowl with NaN on one side, right beside the start."""

    def values(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        return np.where(points[:, 0] > 0.1, np.nan, 1.0 - _depth(points))

    return Problem(dim, values)


def flat(dim: int) -> Problem:
    """The same value everywhere: nothing to find."""
    return Problem(dim, lambda points: np.ones(len(points)))


def failing(dim: int, after: int) -> Problem:
    """The bowl until `after` evaluations, then every call raises `ZeroDivisionError`."""
    calls = 0

    def values(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        nonlocal calls
        calls += len(points)
        if calls > after:
            raise ZeroDivisionError("planted by the conformance kit")
        return 1.0 - _depth(points)

    return Problem(dim, values)


class Counted:
    """A problem that counts its evaluations, also those that no meter sees."""

    def __init__(self, problem: Problem) -> None:
        self.evaluations = 0

        def values(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
            self.evaluations += len(points)
            return problem.values(points)

        self.problem = replace(problem, values=values)
