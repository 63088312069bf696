"""The rounds of an epipolar stage: which of their ends count, and when it is enough."""

import time
from dataclasses import dataclass, replace

import numpy as np
import pytest
from parts_of_repairs import prepared, run_schedule, started

from stereorecal.matching import SAD
from stereorecal.objectives import Parameters, Reach, row_chart
from stereorecal.recalibration import Schedule, ScoreKind, Stage, as_settings
from stereorecal.strategies import AbstractStrategy, Need, Outcome, Status


@dataclass(frozen=True)
class Going(AbstractStrategy):
    """Goes a share of the way to the solution."""

    share: float = 1.0
    needs = Need.RESIDUALS

    def run(self, objective, start, seed):
        objective.value(start)
        residuals, dim = objective.traced.residuals, objective.dim
        at_centre = np.asarray(residuals(np.zeros(dim)), float)
        jacobian = np.stack([np.asarray(residuals(axis), float) - at_centre for axis in np.eye(dim)], axis=1)
        solution = np.linalg.lstsq(jacobian, -at_centre, rcond=None)[0]
        return Outcome(np.clip(start + self.share * (solution - start), -1.0, 1.0), Status.CONVERGED)


@pytest.fixture
def staged(scene):
    """staged(solvers): the last stage of a search on rows, one stage for each solver; and where it ended and where each
    of its rounds did, in the coordinates of its box."""

    def run(*solvers, rounds=6, budget=None):
        given = scene("harbour", 0, (160, 120))
        off = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([0.5, 0.2, -0.4, 0, 0, 0]))
        stages = tuple(Stage(solver, 1.0, ScoreKind.EPIPOLAR, rounds=rounds) for solver in solvers)
        settings = as_settings(
            {"matcher": SAD(num_disparities=24), "schedule": Schedule("rows", stages), "budget": budget}
        )
        settings = replace(settings, free=settings.free.extrinsics, prior="exact")
        case, start, _ = started(prepared(off, given.pairs, settings), settings.schedule)
        stage = run_schedule(case, settings, start, time.perf_counter())[1][-1]
        end = row_chart(off, Reach(), Parameters()).coordinates(stage.end_extrinsics)
        return stage, end, [run.best for run in stage.runs[2::2]]

    return run


def test_the_end_of_a_round_that_came_from_afar_does_not_count(staged):
    """Of those after it, which no longer approach, the mean does."""
    stage, end, rounds = staged(Going())
    assert 2 < len(rounds) < 6
    np.testing.assert_allclose(end, np.mean(rounds[1:], axis=0), atol=1e-12)
    assert len(stage.runs) == 3 + 2 * (len(rounds) - 1)
    assert not stage.cut


def test_rounds_that_are_near_from_the_start_all_count(staged):
    _, end, rounds = staged(Going(), Going())
    assert len(rounds) < 6
    np.testing.assert_allclose(end, np.mean(rounds, axis=0), atol=1e-12)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("most", [2, 1, 6])
def test_rounds_are_bounded(staged, most):
    """One that never arrives ends where its last one does."""
    stage, end, rounds = staged(Going(0.2), rounds=most)
    assert len(stage.runs) == 3 + 2 * (most - 1)
    np.testing.assert_allclose(end, rounds[-1], atol=1e-12)


A_MATCH, A_SOLVE = 1.0, 1.1e-6  # units: of one pair at full size, of one look at the residuals


@pytest.mark.slow(after=2)
@pytest.mark.parametrize(
    ("units", "solved", "cut"),
    [
        (A_MATCH, 0, True),  # before the first solve
        (A_MATCH + 1.5 * A_SOLVE, 1, True),  # between two solves: only weights for far rows were tried
        (1.5 * A_MATCH, 3, False),  # before the second round: the first stands
        (0.5 * A_MATCH, 0, True),  # before anything was matched
        (2 * A_MATCH + 3.5 * A_SOLVE, 3, True),  # in the second round
    ],
)
def test_a_budget_that_ends_in_a_round_is_noticed(staged, units, solved, cut):
    stage, _, _ = staged(Going(), budget=units)
    assert sum(run.status is Status.CONVERGED for run in stage.runs) == solved
    assert stage.cut is cut
