"""The rounds of an epipolar stage: match, fit, until it settles."""

import json
import time
from dataclasses import dataclass, replace

import numpy as np
import pytest
from parts_of_repairs import prepared, run_schedule, started

from stereorecal.geometry import AXES
from stereorecal.matching import SAD
from stereorecal.recalibration import Schedule, ScoreKind, Stage, as_settings, recalibrate
from stereorecal.strategies import AbstractStrategy, Need, Outcome, Status

FITS = 3  # of the rows of one match


@dataclass(frozen=True)
class Going(AbstractStrategy):
    """Goes a share of the way to the solution."""

    share: float = 1.0
    needs = Need.RESIDUALS

    def run(self, objective, start, seed):
        objective.value(start)
        return Outcome(start + self.share * (objective.traced.residuals.least - start), Status.CONVERGED)


@pytest.fixture
def staged(scene):
    """staged(solver): a stage on the rows of a rig that is half a degree off, and how far from the truth it ended, in
    degrees of pitch and roll."""

    def run(solver=None, rounds=6, budget=None):
        given = scene("harbour", 0, (160, 120))
        off = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([0.5, 0.2, -0.4, 0, 0, 0]))
        schedule = Schedule("rows", (Stage(solver, 1.0, ScoreKind.EPIPOLAR, rounds=rounds),))
        settings = as_settings({"matcher": SAD(num_disparities=24), "schedule": schedule, "budget": budget})
        settings = replace(settings, free=settings.free.extrinsics, prior="exact")
        case, start, _ = started(prepared(off, given.pairs, settings))
        [stage] = run_schedule(case, start, time.perf_counter())[1]
        error = np.degrees(np.asarray(stage.ended.extrinsics) - np.asarray(given.rig.extrinsics))
        return stage, np.abs(error[[AXES.index("pitch"), AXES.index("roll")]])

    return run


def matches(stage):
    return round(stage.cost.correspondences / stage.scale**2)


@pytest.mark.parametrize("solver", [None, Going()], ids=["fit", "strategy"])
def test_it_ends_once_it_has_settled(staged, solver):
    stage, error = staged(solver)
    assert error.max() < 0.1
    assert 1 < matches(stage) < 6
    assert len(stage.runs) == (0 if solver is None else FITS * matches(stage))
    assert not stage.cut


def test_a_strategy_ends_where_the_fit_does(staged):
    by_fit, by_strategy = staged()[0], staged(Going())[0]
    np.testing.assert_allclose(by_fit.ended.extrinsics, by_strategy.ended.extrinsics, atol=1e-9)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("most", [2, 1, 6])
def test_rounds_are_bounded(staged, most):
    """One that hardly moves takes all of them."""
    assert matches(staged(Going(0.05), rounds=most)[0]) == most


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
    stage, _ = staged(Going(), budget=units)
    assert sum(run.status is Status.CONVERGED for run in stage.runs) == solved
    assert stage.cut is cut


def test_a_schedule_may_be_the_fit_alone(scene):
    given = scene("harbour", 0, (160, 120))
    off = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([0.5, 0.2, -0.4, 0, 0, 0]))
    schedule = Schedule("fit", (Stage(None, score=ScoreKind.EPIPOLAR, rounds=4),), survey=True)
    solution = recalibrate(off, given.pairs, matcher=SAD(num_disparities=24), schedule=schedule, prior="exact")
    assert solution.accepted
    assert solution.status is Status.CONVERGED
    assert solution.trace is None
    json.dumps(solution.to_dict())


def test_what_has_not_settled_is_said(scene):
    """A pitch that is held leaves rows that no roll explains: matches and fit go on moving each other, for longer than
    rounds are allowed."""
    given = scene("harbour", 0, (320, 240))
    off = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([0.6, 0.0, 0.2, 0, 0, 0]))
    *coarse, last = Schedule.default().stages
    schedule = Schedule("impatient", (*coarse, replace(last, rounds=2)))
    options = {"matcher": SAD(num_disparities=48), "prior": "exact", "free": ("roll",), "schedule": schedule}
    assert recalibrate(off, given.pairs, **options).status is Status.STALLED
    assert recalibrate(off, given.pairs, **{**options, "free": ("pitch", "roll")}).status is Status.CONVERGED
