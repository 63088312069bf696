"""The conformance kit passes a good strategy and fails each bad one by the check that is meant for it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from stereorecal.strategies import AbstractStrategy, BudgetExhausted, Need, Outcome, Status, strategy
from stereorecal.testing import check_strategy


@dataclass(frozen=True)
class Climber(AbstractStrategy):
    """A compass search that can be bent: the base of the bad ones."""

    def run(self, objective, start, seed):
        return Outcome(self.climb(objective, start, seed)[0], Status.CONVERGED)

    def climb(self, objective, start, seed):
        directions = np.concatenate([np.eye(objective.dim), -np.eye(objective.dim)])
        best, value, step = start, self.ask(objective, start[None])[0], 0.25
        while step > 1e-3:
            points = self.limited(best + step * directions)
            values = self.ask(objective, points)
            if values.max() > value:
                best, value = points[values.argmax()], values.max()
            else:
                step /= 2
        return best, value

    def ask(self, objective, points):
        values = objective.batch(points)
        return np.where(np.isnan(values), -np.inf, values)

    def limited(self, points):
        return np.clip(points, -1, 1)


@dataclass(frozen=True)
class Liar(Climber):
    def run(self, objective, start, seed):
        self.climb(objective, start, seed)
        return Outcome(start, Status.CONVERGED)


@dataclass(frozen=True)
class Swallower(Climber):
    """Takes BudgetExhausted for an end of its own."""

    def run(self, objective, start, seed):
        try:
            return super().run(objective, start, seed)
        except BudgetExhausted:
            return Outcome(start, Status.CONVERGED)


@dataclass(frozen=True)
class Spender(Climber):
    """Goes on calling."""

    def ask(self, objective, points):
        try:
            return super().ask(objective, points)
        except BudgetExhausted:
            return np.full(len(points), -np.inf)


@dataclass(frozen=True)
class Runaway(Climber):
    def limited(self, points):
        return points


@dataclass(frozen=True)
class Muffler(Climber):
    """Takes every exception of the objective for a bad point."""

    def ask(self, objective, points):
        try:
            return super().ask(objective, points)
        except BudgetExhausted:
            raise
        except Exception:
            return np.full(len(points), -np.inf)


@dataclass(frozen=True)
class Gambler(Climber):
    """Draws from NumPy's global generator."""

    def climb(self, objective, start, seed):
        probes = np.random.uniform(-0.5, 0.5, (4, objective.dim))  # noqa: NPY002
        self.ask(objective, probes)
        return super().climb(objective, start, seed)


@dataclass(frozen=True)
class Homebody(Climber):
    """Carries something that does not pickle."""

    helper: Callable = field(default_factory=lambda: lambda x: x)


@dataclass(frozen=True)
class Blind(Climber):
    """Takes NaN for the best value there is."""

    def ask(self, objective, points):
        values = objective.batch(points)
        return np.where(np.isnan(values), np.inf, values)

    def climb(self, objective, start, seed):
        # Far enough to meet a NaN.
        points = np.concatenate([start[None], np.full((1, objective.dim), 0.9)])
        values = self.ask(objective, points)
        if np.isinf(values[1]):
            return points[1], values[1]
        return super().climb(objective, start, seed)


@dataclass(frozen=True)
class Idle(AbstractStrategy):
    """Nominates the start."""

    def run(self, objective, start, seed):
        return Outcome(start, Status.STALLED)


@jax.jit
def look(score, z):
    return jax.value_and_grad(lambda q: score(q))(z)


@dataclass(frozen=True)
class Ascent(AbstractStrategy):
    """Normalised gradient ascent on the soft count that can be bent."""

    needs: ClassVar[Need] = Need.SMOOTH

    def run(self, objective, start, seed):
        best, (value, slope), step = start, self.ask(objective, start, start), 0.25
        while step > 1e-3:
            point = np.clip(best + step * slope / max(np.linalg.norm(slope), 1e-9), -1, 1)
            there, its_slope = self.ask(objective, point, best)
            if there > value:
                best, value, slope = point, there, its_slope
            else:
                step /= 2
        return Outcome(best, Status.CONVERGED)

    def ask(self, objective, point, best):
        objective.reserve(objective.gradient_cost)
        value, slope = look(objective.traced.soft_count, jnp.asarray(point, jnp.float32))
        self.pay(objective, best)
        return (float(value), np.asarray(slope, float)) if np.isfinite(value) else (-np.inf, np.zeros(len(point)))

    def pay(self, objective, best):
        objective.charge(objective.gradient_cost, best)


@dataclass(frozen=True)
class Miser(Ascent):
    """Declares a gradient as one evaluation."""

    def pay(self, objective, best):
        objective.charge(objective.cost, best)


@dataclass(frozen=True)
class Deaf(Ascent):
    """Does not hear when something goes wrong."""

    def pay(self, objective, best):
        try:
            super().pay(objective, best)
        except BudgetExhausted:
            raise
        except BaseException:
            pass


def failures(bad: AbstractStrategy) -> set[str]:
    return {result.name for result in check_strategy(bad) if not result.passed}


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("good", [strategy("compass"), Climber(), Ascent()])
def test_good_strategies_pass(good):
    assert not failures(good)


CLIMBS = {
    "climbs a smooth bowl",
    "climbs a staircase",
    "climbs a tilted ridge",
    "keeps off a cliff",
    "climbs a noisy bowl",
}


@pytest.mark.slow(after=4)
@pytest.mark.parametrize(
    ("bad", "expected"),
    [
        (Liar(), {"is honest"}),
        (Swallower(), {"keeps any budget"}),
        (Spender(), {"keeps any budget"}),
        (Runaway(), {"stays in the box"}),
        (Muffler(), {"lets exceptions pass"}),
        (Gambler(), {"is deterministic"}),
        (Homebody(), {"travels"}),
        (Blind(), {"survives nan"}),
        (Idle(), CLIMBS | {"repairs a stereo rig", "ends on a flat score"}),
        (Miser(), {"keeps any budget"}),
        (Deaf(), {"lets exceptions pass"}),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, AbstractStrategy) else "",
)
def test_bad_strategies_fail_by_the_right_check(bad, expected):
    assert failures(bad) == expected


def test_a_result_says_what_is_wrong():
    results = {result.name: result for result in check_strategy(Liar())}
    assert "nominates a point of value" in results["is honest"].message
    assert results["climbs a smooth bowl"].passed
    assert results["climbs a smooth bowl"].message == ""
