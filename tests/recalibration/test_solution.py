"""What a Solution says when the count is all there is, and how it is accepted or not."""

from itertools import pairwise

import numpy as np
import pytest

from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.recalibration import Reason, Schedule, recalibrate
from stereorecal.scoring.host import score
from stereorecal.strategies import Budget, Status, strategy

SAD_24 = SAD(num_disparities=24)
COMPASS = strategy("compass")
COUNT = Schedule.count(COMPASS)


@pytest.fixture(scope="module")
def drifted(scene):
    rig = scene().rig
    return rig.with_extrinsics(rig.extrinsics + np.array([*np.radians([0.8, 0.3, -0.9]), 0.0, 0.003, -0.003]))


@pytest.fixture(scope="module")
def solution(scene, drifted):
    return recalibrate(drifted, scene().pairs, matcher=SAD_24, schedule=COUNT)


def test_the_count_rises_and_the_rig_is_the_candidate(solution, drifted):
    assert solution.accepted
    assert solution.reason is Reason.MORE_MATCHES
    assert solution.status is Status.CONVERGED
    assert solution.score_after.count > 1.1 * solution.score_before.count
    assert solution.rig is solution.candidate
    assert solution.initial is drifted
    assert solution.change[3] == 0.0
    assert solution.rig.left is drifted.left


def test_scores_are_those_of_the_rigs_in_one_view(solution, scene, drifted):
    pairs = scene().pairs
    for rig, said in ((drifted, solution.score_before), (solution.rig, solution.score_after)):
        assert score(rig, pairs, matcher=SAD_24, view=solution.view) == said
    assert solution.view.focal == view(drifted).focal
    assert solution.view.centre_row == view(drifted).centre_row


def test_trace_cost_and_evaluations(solution):
    assert solution.evaluations == len(solution.trace.values)
    assert solution.cost.search == pytest.approx(solution.evaluations)
    assert solution.cost.total == pytest.approx(solution.evaluations + 2)  # and judged: before and after
    assert solution.trace.values.max() == solution.score_after.count
    assert solution.seconds > 0


def test_the_path_climbs_from_the_start_to_the_end(solution, scene, drifted):
    path, how = solution.path, {"matcher": SAD_24, "view": solution.view}
    np.testing.assert_array_equal(path[0].extrinsics, drifted.extrinsics)
    np.testing.assert_allclose(path[-1].extrinsics, solution.candidate.extrinsics, atol=1e-12)
    assert path[0].cost == 0
    assert all(a.cost < b.cost for a, b in pairwise(path))
    assert path[-1].cost <= solution.cost.total
    counts = [score(drifted.with_extrinsics(p.extrinsics), scene().pairs, **how).count for p in path]
    assert counts == sorted(counts)
    assert counts[0] < counts[-1]


def test_text(solution):
    text = str(solution)
    lines = text.splitlines()
    assert lines[0] == "Repaired: another calibration matches more pixels."
    assert f"{solution.evaluations} evaluations" in text
    counts = [f"{score.count:,}".replace(",", " ") for score in (solution.score_before, solution.score_after)]
    assert lines[2].startswith(f"matched  {' -> '.join(counts)} of ")
    assert [line.split()[0] for line in lines[3:]] == ["depth", "pitch", "yaw", "roll", "x", "y", "z", "search"]
    assert lines[4].split()[-1] == f"{np.degrees(solution.change[0]):+.3f}"
    assert lines[-3].split()[-1] == f"{1e3 * solution.change[4]:+.3f}"


def test_the_old_calibration_stays_when_nothing_is_better(scene, solution):
    """A search with the last step of the one before finds nothing."""
    again = recalibrate(
        solution.rig,
        scene().pairs,
        matcher=SAD_24,
        view=solution.view,
        schedule=Schedule.count(strategy("compass", step=1 / 128, min_step=1 / 128)),
    )
    assert not again.accepted
    assert again.rig is solution.rig
    assert again.reason is Reason.NOT_IMPROVED
    assert again.score_after.count <= again.score_before.count
    assert str(again).startswith("Not repaired: no calibration matches more pixels.")


@pytest.mark.parametrize("limit", [1, 7, 30.5])
def test_budget(scene, drifted, solution, limit):
    found = recalibrate(drifted, scene().pairs, matcher=SAD_24, schedule=COUNT, budget=Budget(evaluations=limit))
    assert found.evaluations == int(limit)
    assert found.cost.budgeted <= limit
    assert found.status is Status.BUDGET
    np.testing.assert_array_equal(found.trace.points, solution.trace.points[: int(limit)])
    assert found.score_after.count == found.trace.values.max()
