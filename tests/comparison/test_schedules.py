"""Whole schedules compared, and what errors are measured against."""

from inspect import unwrap

import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.comparison import Drift, compare, compare_scenes
from stereorecal.geometry import axis_errors, view
from stereorecal.matching import SAD
from stereorecal.recalibration import Schedule
from stereorecal.scoring.host import score
from stereorecal.strategies import Budget, strategy

MATCHER = SAD(num_disparities=48)  # which other files have compiled
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


def test_scores_of_several_stages_do_not_compare(table):
    assert table["default"].trials[0].score_at is None
    assert table["count"].trials[0].score_at["100"] > 0
    assert table["default"].summary[0]["score_at_median"] == {"100": None, "300": None, "1000": None}


def test_counts_and_errors_have_one_reference(table, scene):
    given_scene = scene("harbour", 2, SIZE)
    for comparison in table.values():
        [trial] = comparison.trials
        start, final, reference = (
            given_scene.rig.with_extrinsics(np.array(trial.extrinsics[name]))
            for name in ("start", "final", "reference")
        )
        assert not np.array_equal(reference.extrinsics, given_scene.rig.extrinsics)
        counted = score(reference, given_scene.pairs, matcher=MATCHER, view=view(start))
        assert trial.score_reference == counted.count
        errors = axis_errors(final, reference)
        assert trial.rotation_error_deg == pytest.approx({name: errors[name] for name in ("pitch", "yaw", "roll")})


def test_without_the_default_strategies_errors_are_against_the_stored_calibration(scene, nothing_installed, install):
    install("stereorecal.strategies", {"other": "stereorecal_compass:Compass"})
    given_scene = scene()
    options = {"matcher": SAD(num_disparities=24), "schedule": "count", "draws": 1, "budget": Budget(evaluations=2)}
    comparison = compare(given_scene.rig, given_scene.pairs, strategies=["other"], **options)
    assert comparison.trials[0].reference == "stored"


BUDGETED = {"matcher": SAD(num_disparities=24), "draws": 1, "scale": 0.5, "budget": Budget(evaluations=3)}


def test_without_schedule_and_strategies_both_schedules_run_the_default_one_first(scene):
    comparison = compare_scenes([scene()], **(BUDGETED | {"draws": 2}))
    ran = {"default": ("compass",), "count": ("compass",)}
    rows = [(draw, schedule) for draw in (0, 1) for schedule in ("default", "count")]
    assert [(t.draw, t.schedule) for t in comparison.trials] == rows
    assert all(t.strategies == ran[t.schedule] for t in comparison.trials)
    assert [(row["schedule"], row["strategies"], row["draws"]) for row in comparison.summary] == [
        ("default", ran["default"], 2),
        ("count", ran["count"], 2),
    ]
    settings = comparison.as_dict()["settings"]
    assert settings["schedule"] == "count and default"
    assert settings["strategies"] == ["compass"]
    assert settings["entrants"] == [
        {"strategy": "compass", "schedule": name, "strategies": list(ran[name])} for name in ("default", "count")
    ]
    assert "strategy compass" in comparison.versions


def test_a_strategy_alone_runs_in_the_count_schedule_or_takes_its_place_in_the_default_one(scene):
    alone = compare_scenes([scene()], strategies=["compass"], **BUDGETED)
    assert [(t.schedule, t.strategies) for t in alone.trials] == [("count", ("compass",))]
    assert alone.settings["schedule"] == "count"
    [trial] = compare_scenes([scene()], schedule="default", strategies=["secant"], **BUDGETED).trials
    assert (trial.schedule, trial.strategy, trial.strategies) == ("default", "secant", ("secant",))


REFUSED = {
    "a text": ({"strategies": "compass"}, r"strategies is the text 'compass'; give a list of names"),
    "a strategy": ({"strategies": strategy("compass")}, "strategies is one strategy; give a mapping"),
    "a list of strategies": ({"strategies": [strategy("compass")]}, "give names, or a mapping"),
    "a schedule": ({"schedule": Schedule.count()}, "schedule is an sr.Schedule; give its name"),
    "an unknown schedule": ({"schedule": "fast"}, "unknown schedule 'fast'; choose one of: count, default"),
    "a number": ({"schedule": 1}, "unknown schedule 1; choose one of"),
}


@pytest.mark.parametrize(("options", "said"), REFUSED.values(), ids=REFUSED.keys())
def test_what_stands_in_the_place_of_a_name_is_refused_in_one_sentence(scene, options, said):
    with pytest.raises(InputError, match=said) as refusal:
        unwrap(compare_scenes)([scene()], **options)  # without the tests' own check of types
    assert "\n" not in str(refusal.value)
