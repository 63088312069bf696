"""Whole schedules compared, and what errors are measured against."""

import numpy as np
import pytest

from stereorecal._errors import InputError
from stereorecal.comparison import Drift, compare, compare_scenes
from stereorecal.matching import SAD
from stereorecal.recalibration import Schedule
from stereorecal.recordings import Scene
from stereorecal.strategies import Budget

MATCHER = SAD(num_disparities=48)
SIZE = (320, 240)


@pytest.fixture(scope="module")
def table(scene):
    """Both schedules on one rendered scene that does not say what its rig is worth."""
    given_scene = scene("harbour", 2, SIZE)
    options = {"matcher": MATCHER, "draws": 1, "drift": Drift(1.0, 0.01), "seed": 3}
    return {
        "default": compare(given_scene.rig, given_scene.pairs, schedule="default", **options),
        "count": compare(given_scene.rig, given_scene.pairs, schedule="count", scale=0.5, **options),
    }


def test_the_default_schedule_brings_the_geometry_back(table):
    [fine] = table["default"].trials
    [coarse] = table["count"].trials
    assert (fine.schedule, coarse.schedule) == ("default", "count")
    assert fine.accepted
    assert fine.reason == "improved"
    assert max(fine.rotation_error_deg["pitch"], fine.rotation_error_deg["roll"]) < 0.01
    assert fine.rotation_error_deg["yaw"] < coarse.rotation_error_deg["yaw"]


def test_scores_of_several_stages_do_not_compare(table):
    assert table["default"].trials[0].score_at is None
    assert table["count"].trials[0].score_at["100"] > 0
    assert table["default"].summary[0].score_at_median == {"100": None, "300": None, "1000": None}


def test_without_a_truth_errors_are_against_the_consensus(table):
    for comparison in table.values():
        assert comparison.scenes[0]["reference"] == "consensus"
        assert comparison.trials[0].reference == "consensus"
        assert comparison.settings["schedule"] == comparison.trials[0].schedule


def test_without_the_default_strategies_errors_are_against_the_stored_calibration(scene, monkeypatch):
    def missing():
        raise InputError("optimistix is not installed")

    monkeypatch.setattr(Schedule, "default", missing)
    given_scene = scene()
    comparison = compare(
        given_scene.rig, given_scene.pairs, matcher=SAD(num_disparities=24), draws=1, budget=Budget(evaluations=2)
    )
    assert comparison.trials[0].reference == "stored"


def test_a_known_truth_is_the_reference(scene):
    given_scene = scene()
    assert given_scene.reference == "truth"
    budget = Budget(evaluations=1)
    comparison = compare_scenes([given_scene], matcher=SAD(num_disparities=24), draws=1, budget=budget)
    [trial] = comparison.trials
    assert trial.reference == "truth"
    assert max(trial.rotation_error_deg.values()) <= 0.5 + 1e-9


def test_an_unknown_schedule(scene):
    given_scene = Scene("one", scene().rig, scene().pairs)
    with pytest.raises(InputError, match="unknown schedule 'fast'; choose one of: count, default"):
        compare_scenes([given_scene], schedule="fast")


def test_errors_are_absolute(table):
    for trial in table["default"].trials:
        assert np.all(np.array([*trial.rotation_error_deg.values(), *trial.translation_error_percent.values()]) >= 0)
