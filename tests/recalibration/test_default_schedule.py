"""The default schedule end to end: the geometry comes right, and what is right or invisible is left alone."""

from dataclasses import dataclass, replace

import jax
import numpy as np
import pytest
from fixtures import SAD_48
from moody import Crashing
from spoiled import fog

import stereorecal as sr
from stereorecal.geometry import StereoRig
from stereorecal.recalibration import Reason, Schedule, ScoreKind, Solution, Stage
from stereorecal.strategies import Budget, Need, Status
from stereorecal.synthetic import decalibrate, default_rig, photographs, plan_drive

RIG = default_rig().resized((320, 240))
FREE = [0, 1, 2, 4, 5]
UNITS = np.array([180 / np.pi] * 3 + [100 / RIG.baseline] * 2)  # degrees, percent of the baseline
DRIFT = (1.5, -1.0, -1.5, 0.5, -0.5)
NEAR = (0.2, -0.3, -0.2, 0.0, 0.0)  # so near that one look at the images is enough


def drifted(drift=DRIFT) -> StereoRig:
    """The truth, off by so many degrees and percent of the baseline."""
    return RIG.with_extrinsics(RIG.extrinsics + np.insert(np.array(drift) / UNITS, 3, 0.0))


def errors(rig: StereoRig) -> np.ndarray:
    """Distance from the truth: pitch, yaw, roll [degrees], y, z [percent of the baseline]."""
    return np.abs(np.asarray(rig.extrinsics) - RIG.extrinsics)[FREE] * UNITS


def repair(rig, pairs, **options) -> Solution:
    """Rendered rigs have the intrinsics that they say."""
    return sr.recalibrate(rig, pairs, matcher=SAD_48, prior="exact", **options)


def assert_harmless(solution: Solution):
    """Accepted only if no axis that is said to be observed lies further off than before, by more than its interval."""
    assert (solution.rig is solution.initial) != solution.accepted
    if solution.accepted:
        assert solution.uncertainty is not None
        known = solution.uncertainty
        further = errors(solution.rig) - errors(solution.initial)
        assert (further <= known.interval)[known.observed].all()


@pytest.fixture(scope="module")
def harbour(scene):
    return scene("harbour", 0, RIG.left.size).pairs


@pytest.fixture(scope="module")
def repaired(harbour):
    return repair(drifted(), harbour)


@pytest.fixture(scope="module")
def searched(harbour):
    """Without a survey, a look from the initial calibration sees too little."""
    return repair(drifted(), harbour, schedule=replace(Schedule.default(), survey=False))


def test_a_drifted_rig_comes_right(repaired):
    assert repaired.reason is Reason.IMPROVED
    assert repaired.status is Status.CONVERGED
    pitch, yaw, roll, y, z = errors(repaired.rig)
    assert max(pitch, roll) < 0.02
    assert yaw < 0.07  # a pixel of disparity in seven: .0501 on one processor, less on others
    assert y < 0.6
    assert z < 1.2  # hardly told in images this small: .28 or .68 % off, by how XLA compiles
    assert (errors(repaired.rig) < 2 * repaired.uncertainty.interval).all()
    assert_harmless(repaired)


def test_what_it_says_about_itself(repaired):
    """Intervals of a size that means something; rows and counts before and after."""
    known, rows = repaired.uncertainty, repaired.row_errors
    assert known.observed[:4].all()  # y and z together are hardly told in images this small
    assert (known.interval[:3] < [0.02, 0.1, 0.02]).all()
    assert (known.interval > 1e-4).all()
    np.testing.assert_allclose(repaired.covariance, repaired.covariance.T, rtol=1e-9)
    assert rows.before > 2
    assert rows.after < 0.2
    assert repaired.score_after.count > 2 * repaired.score_before.count
    # The far points suffer most: the yaw was a degree off.
    wrong = repaired.depth_error_percent
    assert abs(wrong[5]) < abs(wrong[100])
    assert abs(wrong[10]) > 5


def test_stages(searched):
    assert [stage.stage.scale for stage in searched.stages] == [0.25, 0.5, 1.0]
    assert searched.cost.budgeted == pytest.approx(sum(stage.cost.budgeted for stage in searched.stages))
    assert searched.evaluations == sum(len(run.trace.values) for stage in searched.stages for run in stage.runs)
    for stage in searched.stages[1:]:
        # Each match is paid for; the solver's own work is next to nothing.
        matches = stage.cost.correspondences / stage.scale**2
        assert matches == pytest.approx(round(matches))
        assert 1 <= matches <= stage.stage.rounds
        assert stage.cost.search < 0.5


def test_the_path_has_the_end_of_every_stage(searched):
    path, cost, (*_, half, last) = searched.path, searched.cost, searched.stages
    np.testing.assert_allclose(path[-1].extrinsics, searched.candidate.extrinsics, atol=1e-12)
    assert cost.starts >= 1  # of the look, which came before them
    np.testing.assert_allclose(path[-1].cost, cost.total - cost.judging - last.cost.survey)
    np.testing.assert_allclose(path[-2].cost + half.cost.survey, path[-1].cost - last.cost.budgeted)


def test_the_path_of_a_search_that_moves_nothing(searched):
    began = searched.initial
    still = [replace(stage, began=began, ended=began, path=()) for stage in searched.stages]
    start, end = replace(searched, stages=tuple(still)).path
    np.testing.assert_array_equal(start.extrinsics, began.extrinsics)
    np.testing.assert_array_equal(end.extrinsics, searched.candidate.extrinsics)
    assert end.cost == searched.path[-1].cost


def test_the_same_again(harbour, repaired):
    again = repair(drifted(), harbour)
    np.testing.assert_array_equal(again.candidate.extrinsics, repaired.candidate.extrinsics)
    np.testing.assert_array_equal(again.covariance, repaired.covariance)
    assert again.score_after == repaired.score_after
    assert again.cost == repaired.cost


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("drift", [DRIFT, (0.0, 1.5, 0.0, 0.0, 0.0)])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_open_sea_never_does_harm(scene, drift, seed):
    assert_harmless(repair(drifted(drift), scene("open-sea", seed, RIG.left.size).pairs))


def test_a_drift_far_beyond_the_reach(harbour):
    """The images have texture: it is no night or fog, and worth an alarm."""
    far = drifted((12.0, 0.0, 0.0, 0.0, 0.0))
    solution = repair(far, harbour)
    assert solution.reason is Reason.NO_MATCHES
    assert solution.rig is far


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("limit", [0.01, 5, 20, 36])
def test_a_budget_is_kept(harbour, limit):
    """Whatever of the schedule fits; without a look at the rows nothing is accepted."""
    solution = repair(drifted(), harbour, budget=Budget(evaluations=limit))
    assert solution.cost.budgeted <= limit * (1 + 1e-9)
    assert_harmless(solution)
    assert len(solution.stages) <= 3
    if all(stage.found is None for stage in solution.stages):
        assert solution.reason is Reason.OUT_OF_BUDGET
        assert solution.status is Status.BUDGET


@pytest.mark.parametrize("with_fog", [False, True])
def test_frames_are_repaired_jointly_and_fog_among_them_does_not_matter(scene, harbour, with_fog):
    """Two frames of the rig, or one and another that shows nothing."""
    pairs = [*harbour, *([fog()] if with_fog else scene("harbour", 1, RIG.left.size).pairs)]
    solution = repair(drifted(NEAR), pairs)
    assert solution.reason is Reason.IMPROVED
    assert solution.stages[-1].found.weight.shape[0] == 2
    assert solution.score_after.pixels == 2 * 320 * 240
    pitch, yaw, roll, *_ = errors(solution.rig)
    assert max(pitch, roll) < 0.02
    assert yaw < 2.0 * solution.uncertainty.interval[1] < 0.15
    assert (errors(solution.rig) < 3 * solution.uncertainty.interval).all()


@dataclass(frozen=True)
class Unwanted(Crashing):
    """Must not be asked."""

    needs = Need.RESIDUALS


def test_where_one_look_is_enough_nothing_is_searched(harbour):
    """And none of the budget is spent."""
    schedule = Schedule("none", (Stage(Unwanted(), score=ScoreKind.EPIPOLAR),))
    for rig, reason in ((drifted(NEAR), Reason.IMPROVED), (RIG, Reason.ALREADY_GOOD)):
        solution = repair(rig, harbour, schedule=schedule, budget=1)
        assert solution.reason is reason
        assert solution.evaluations == solution.cost.budgeted == 0
        assert errors(solution.rig)[[0, 2]].max() < 0.02


@pytest.mark.slow
def test_what_a_late_shutter_leaves_moves_no_intrinsics():
    """Lenses would explain some of it, also in frames that are left out."""
    plan = plan_drive("street", 1, 25, weather=False, late=((0, 25, 0.6),))
    plan = replace(plan, rig=plan.rig.resized((640, 480)))
    given = decalibrate(plan.truth(12), jax.random.key(1), 0.3, 0.0027)
    found = sr.recalibrate(given, list(photographs(plan))[::3], motion=True)
    assert found.estimate.is_late
    assert found.rig is given
    assert found.misfit.late
    assert "are not taken at the same time" in str(found)
