"""Comparisons in which strategies search intrinsics too: a box with more coordinates, the same contract."""

from dataclasses import dataclass

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.comparison import compare
from stereorecal.objectives import Parameters, count_chart, count_objective
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import score
from stereorecal.strategies import AbstractStrategy, Budget, Need, Outcome, Status

BOTH = ("extrinsics", "intrinsics")
SMALL = {"matcher": sr.SAD(num_disparities=24), "draws": 1, "scale": 0.5, "budget": Budget(evaluations=5)}


@dataclass(frozen=True)
class FirstAndLast(AbstractStrategy):
    """Moves the pitch and the right camera's k2."""

    def run(self, objective, start, seed):
        best = np.zeros(objective.dim)
        best[[0, -1]] = 0.01, 0.5
        objective.value(best)
        return Outcome(best, Status.CONVERGED, f"{objective.dim} coordinates")


@dataclass(frozen=True)
class Smooth(FirstAndLast):
    needs = Need.SMOOTH


def test_more_coordinates_and_the_same_errors(scene):
    given_scene = scene()
    both = {"mover": FirstAndLast(), "smooth": Smooth()}
    more = compare(given_scene.rig, given_scene.pairs, strategies=both, free=BOTH, **SMALL)
    mover, smooth = more.trials
    assert mover.message == "15 coordinates"
    assert (smooth.status, smooth.rotation_error_deg) == ("SKIPPED", None)
    assert mover.rotation_error_deg.keys() == {"pitch", "yaw", "roll"}
    free = more.as_dict()["settings"]["free"]
    assert (free[:5], free[-1], len(free)) == (["pitch", "yaw", "roll", "y", "z"], "right.k2", 15)


def test_extrinsics_must_be_free(scene):
    with pytest.raises(sr.InputError, match="free them as well"):
        compare(scene().rig, scene().pairs, strategies=["compass"], free="intrinsics", **SMALL)
    with pytest.raises(sr.InputError, match="did you mean"):
        compare(scene().rig, scene().pairs, strategies=["compass"], free="intrinsic", **SMALL)


@pytest.mark.slow
def test_the_count_of_a_point_is_that_of_its_rig(scene):
    """The count is that of the whole rig, its lenses too."""
    rig, pairs, matcher = scene().rig, scene().pairs, SMALL["matcher"]
    chart = count_chart(rig, sr.Reach(), Parameters(BOTH))
    asked = count_objective(pyramid(rig, pairs), matcher, chart)
    bent = np.zeros(15)
    bent[[0, 8, -3]] = 0.05, 0.9, 0.8
    for z in (np.zeros(15), bent):
        assert asked.value(z) == score(chart.rig_at(z), pairs, matcher=matcher, view=sr.view(rig)).count
    assert asked.value(bent) < 0.99 * asked.value(np.zeros(15))
