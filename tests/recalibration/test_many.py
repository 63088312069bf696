"""Many recordings: any executor gives the same answers, and one that fails does not take the others with it."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from moody import Crashing

import stereorecal as sr
from stereorecal import InputError
from stereorecal.io import load_scene, save_scene
from stereorecal.objectives import Reach
from stereorecal.recalibration import Fault, recalibrate_many
from stereorecal.strategies import Budget, strategy

OPTIONS = {
    "matcher": sr.SAD(num_disparities=24),
    "schedule": sr.Schedule.count(strategy("compass"), 0.5),
    "budget": Budget(evaluations=10),
    "reach": Reach(2.0, 0.02),
}


def drifted(scene, name, roll):
    rig = scene.rig
    return replace(
        scene, name=name, rig=rig.with_extrinsics(rig.extrinsics + np.array([0, 0, np.radians(roll), 0, 0, 0]))
    )


@pytest.fixture(scope="module")
def scenes(scene, tmp_path_factory):
    """Three recordings that come from files."""
    folder = tmp_path_factory.mktemp("recordings") / "harbour"
    save_scene(scene(), folder)
    return [drifted(load_scene(folder), name, roll) for name, roll in (("one", 1.0), ("two", -0.7), ("three", 0.4))]


@pytest.fixture(scope="module")
def serial(scenes):
    return recalibrate_many(scenes, **OPTIONS)


def what(repairs):
    """All that an answer says, but for the time it took."""
    return [{**repair.as_dict(), "seconds": None} for repair in repairs]


def test_answers_are_those_of_recalibrate_in_the_order_given(scenes, serial):
    assert [repair.name for repair in serial] == ["one", "two", "three"]
    for scene, repair in zip(scenes, serial, strict=True):
        alone = sr.recalibrate(scene.rig, scene.pairs, **OPTIONS)
        np.testing.assert_array_equal(repair.solution.candidate.extrinsics, alone.candidate.extrinsics)
        assert repair.solution.initial is scene.rig
        assert repair.solution.score_after == alone.score_after
        assert (repair.error, repair.fault) == (None, None)
    assert len({repair.solution.score_before.count for repair in serial}) == 3


def test_recordings_that_cannot_be_repaired_are_errors(scenes, serial):
    bad = [
        replace(scenes[0], name="no rig", rig=None),
        replace(scenes[0], name="no pairs", pairs=()),
        replace(scenes[0], name="other size", rig=scenes[0].rig.resized((80, 60))),
    ]
    found = recalibrate_many([*bad, scenes[1]], **OPTIONS)
    assert [repair.fault for repair in found] == [Fault.INPUT] * 3 + [None]
    for repair, words in zip(found, ("no calibration", "no image pair", "160x120, but the calibration"), strict=False):
        assert repair.solution is None
        assert words in repair.error
        assert "\n" not in repair.error
    assert what(found[3:]) == what(serial[1:2])


def test_a_crashing_strategy_is_an_error_that_names_it(scenes):
    found = recalibrate_many(scenes[:2], **{**OPTIONS, "schedule": sr.Schedule.count(Crashing())})
    assert [(repair.fault, repair.solution) for repair in found] == [(Fault.INSIDE, None)] * 2
    assert "strategy Crashing" in found[0].error
    assert "a bug" in found[0].error


@pytest.mark.parametrize(("name", "said"), [("matchr", "did you mean matcher?"), ("q", "there are: budget, distances")])
def test_an_option_that_is_typed_wrongly_is_named(scenes, name, said):
    for function in (recalibrate_many, lambda scenes, **options: sr.recalibrate(scenes[0].rig, (), **options)):
        with pytest.raises(TypeError, match=re.escape(f"there is no option {name!r}; {said}")):
            function(scenes, **{name: 1})
    with pytest.raises(
        TypeError, match="there is no option 'budget'; there are: distances, matcher, motion, prior, tolerances, view"
    ):
        sr.health(scenes[0].rig, scenes[0].pairs, budget=3)


def test_nothing_to_repair():
    with pytest.raises(sr.InputError, match="nothing to repair"):
        recalibrate_many([])


def test_a_missing_strategy_is_said_once_and_before_any_work(scenes, nothing_installed):
    with pytest.raises(InputError, match="pip install"):
        sr.recalibrate_many(scenes)


def test_plain_data(scenes, serial):
    """A repair that is judged by the count tells no more than that; one that failed tells its error alone."""
    data = json.loads(json.dumps(serial[0].as_dict(), allow_nan=False))
    assert (data["scene"], data["accepted"]) == ("one", serial[0].solution.accepted)
    assert {**data, "scene": None} == {
        **json.loads(json.dumps(serial[0].solution.to_dict())),
        **dict.fromkeys(("scene", "error", "fault")),
    }
    assert data["row_error_px"] is data["interval_95"] is data["covariance"] is None
    assert data["change"]["translation_percent"]["x"] == 0.0 != data["change"]["rotation_deg"]["roll"]
    (failed,) = recalibrate_many([replace(scenes[0], rig=None)], **OPTIONS)
    assert failed.as_dict() == {"scene": "one", "error": failed.error, "fault": "input"}


def test_ranges_of_cameras_one_above_the_other(scene):
    """Their pairs are turned on the way."""
    shown = scene("harbour", 0, (160, 120))
    (pair,) = shown.pairs
    turned = sr.Pair(np.rot90(pair.left, -1), np.rot90(pair.right, -1), "first")
    above = replace(shown, rig=replace(shown.rig, turns=(1, 1)).as_taken(), pairs=(turned,))
    (repair,) = sr.recalibrate_many(above, ranges=[sr.Range("first", (60.0, 80.0), 5.0)])
    assert repair.error is None
    assert repair.solution.ranges.given == 1
