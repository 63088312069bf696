"""The rounds of an epipolar stage, with their ends told beforehand: which of them count, and when it is enough."""

from typing import NamedTuple

import numpy as np
import pytest

from stereorecal.matching import SAD
from stereorecal.objectives import Parameters, Reach
from stereorecal.recalibration import Case, ScoreKind, Stage, _stages
from stereorecal.recalibration._stages import run_stage
from stereorecal.scoring import Correspondences, pyramid
from stereorecal.strategies import Budget, Objective, Problem, Run, Status, strategy
from stereorecal.synthetic import default_rig, render

RIG = default_rig().resized((64, 48))
SOLVE = strategy("levenberg-marquardt")
NOTHING_DONE = Objective(Problem(5, lambda points: np.zeros(len(points)))).trace
RAYS, ONES, ONE = np.zeros((1, 80, 3), np.float32), np.ones((1, 80), np.float32), np.ones(())
FOUND = Correspondences(RAYS, RAYS, ONES, np.zeros((1, 80), np.int32), ONE, ONE, ONE)


class Told(NamedTuple):
    """Rows that are as far apart as the first coordinate says."""

    z: np.ndarray
    differences: np.ndarray

    def moved(self, found, chart, z):
        return Told(z, np.full((1, 80), z[0]))


@pytest.fixture
def staged(monkeypatch):
    """A stage whose rounds end where they are told to: the first coordinate is how far rows are apart, in pixels."""

    def run(ends, cut_at=None, status=Status.CONVERGED, rounds=6):
        asked, told = iter(range(100)), iter(ends)
        end = np.zeros(5)

        def correspondences(*given):
            end[0] = next(told)
            return FOUND

        def solved(strategy, objective, start, seed):
            return Run(end.copy(), 0.0, 0.0, status, status.value, NOTHING_DONE, 0.0)

        monkeypatch.setattr(_stages.host, "correspondences", correspondences)
        monkeypatch.setattr(_stages, "run_strategy", solved)
        monkeypatch.setattr(_stages, "linearised", lambda found, chart, z: Told(z, np.full((1, 80), z[0])))
        monkeypatch.setattr(_stages, "precisions", lambda *given: None)
        monkeypatch.setattr(_stages, "epipolar_objective", lambda *given: None)
        monkeypatch.setattr(_stages, "remaining", lambda *given: None if next(asked) == cut_at else Budget())
        case = Case(pyramid(RIG, render("harbour", 0, rig=RIG).pairs), SAD(num_disparities=16), Reach(), Parameters())
        stage = Stage(SOLVE, 1.0, ScoreKind.EPIPOLAR, rounds=rounds)
        done = run_stage(case, stage, RIG, Budget(), 0)
        return done, case.chart.coordinates(done.end_extrinsics)

    return run


@pytest.mark.slow(after=2)
@pytest.mark.parametrize(
    ("ends", "rounds", "best"),
    [
        ([0.01], 1, 0.01),  # nothing to do
        ([0.04, 0.06], 2, 0.05),  # near from the start: the mean of both
        ([1.0, 1.01], 2, 1.01),  # the end of a round that came from afar does not count
        ([1.0, 1.04, 1.02], 3, 1.03),
        ([0.04, 0.2, 0.19], 3, 0.19),  # it went on after all
        ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 6, 6.0),  # it never arrives: the last end
    ],
)
def test_the_mean_of_near_rounds_counts(staged, ends, rounds, best):
    done, end = staged([*ends, 100.0])
    assert len(done.runs) == 3 + 2 * (rounds - 1)
    assert end[0] == pytest.approx(best)
    assert not done.cut


def test_rounds_are_bounded(staged):
    assert len(staged([1.0, 2.0, 3.0], rounds=1)[0].runs) == 3


@pytest.mark.parametrize(
    ("cut_at", "runs", "cut"),
    [
        (0, 0, True),  # before anything was matched
        (1, 0, True),  # before the first solve
        (2, 1, True),  # between two solves: only weights for far rows were tried
        (4, 3, False),  # before the second round: the first stands
        (6, 4, True),
    ],
)
def test_a_budget_that_ends_in_a_round_is_noticed(staged, cut_at, runs, cut):
    done, _ = staged([1.0, 2.0, 3.0], cut_at)
    assert (len(done.runs), done.cut) == (runs, cut)


def test_a_run_that_spent_the_budget_is_noticed(staged):
    assert staged([1.0, 2.0], status=Status.BUDGET)[0].cut
