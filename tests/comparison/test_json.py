"""The JSON of a comparison: complete, versioned, free of NaN, the same for the same seed."""

import json
from dataclasses import dataclass

import pytest

from stereorecal import InputError
from stereorecal.comparison import Drift, compare, compare_scenes
from stereorecal.matching import SAD
from stereorecal.objectives import Reach
from stereorecal.recordings import Scene
from stereorecal.strategies import AbstractStrategy, Budget, strategy

SMALL = {"matcher": SAD(num_disparities=24), "draws": 2, "scale": 0.5, "budget": Budget(evaluations=10)}
NUMBERS = {"score_initial", "score_final", "score_reference", "ratio", "evaluations", "cost", "seconds"}


@dataclass(frozen=True)
class Crashing(AbstractStrategy):
    def run(self, objective, start, seed):
        raise KeyError("a bug")


@pytest.fixture(scope="module")
def table(scene):
    both = {"compass": strategy("compass"), "crashing": Crashing()}
    return compare_scenes([scene("harbour"), scene("street")], strategies=both, **SMALL)


def no_constant(token):
    raise AssertionError(f"{token} in the JSON")


@pytest.fixture(scope="module")
def content(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("comparison") / "compare.json"
    table.to_json(path)
    return json.loads(path.read_text(), parse_constant=no_constant)


def test_top_level(content):
    assert content["schema"] == "stereorecal.compare/1"
    assert {"schema", "versions", "settings", "scenes", "trials", "summary"} <= set(content)
    assert content["interrupted"] is False


def test_the_truth_judges_rows_and_depth(content):
    for trial in content["trials"]:
        if trial["strategy"] == "compass":
            assert set(trial["by_truth"]["row_error_px"]) == {"start", "final"}
            assert set(trial["by_truth"]["depth_error_percent"]["final"]) == {"10", "30"}
        else:
            assert trial["by_truth"] is None
    for row in content["summary"]:
        assert (row["harmful"] is None) == (row["strategy"] == "crashing")


def test_versions(content):
    assert {"python", "stereorecal", "jax", "numpy"} <= set(content["versions"])
    assert content["versions"]["strategy compass"].startswith("stereorecal-compass ")


def test_settings_say_everything_that_was_asked(content):
    settings = content["settings"]
    assert settings["strategies"] == ["compass", "crashing"]
    assert settings["matcher"]["name"] == "sad"
    assert settings["matcher"]["block_size"] == 11
    assert settings["decalibrate"] == {"degrees": 0.5, "baseline_fraction": 0.01}
    assert settings["reach"] == {"degrees": 3.0, "baseline_fraction": 0.03}
    assert (settings["draws"], settings["seed"], settings["scale"], settings["schedule"]) == (2, 0, 0.5, "count")
    assert settings["budget"] == {"evaluations": 10, "seconds": None}
    assert {"ratio", "pitch_roll_deg", "yaw_deg", "flagged_ratio"} <= set(settings["thresholds"])


def test_scenes(content):
    assert [s["name"] for s in content["scenes"]] == ["harbour-0", "street-0"]
    assert content["scenes"][0]["image_size"] == [160, 120]
    assert content["scenes"][0]["reference"] == "truth"
    assert content["scenes"][0]["num_disparities"] == 24


def test_trials(content):
    trials = content["trials"]
    assert [(t["scene"], t["draw"], t["strategy"]) for t in trials] == [
        (s, d, name) for s in ("harbour-0", "street-0") for d in (0, 1) for name in ("compass", "crashing")
    ]
    for trial in trials:
        assert {"matcher", "schedule", "status", "message", "accepted", "reason", "reference"} <= set(trial)
        assert set(trial) >= NUMBERS
        assert trial["reference"] == "truth"
        if trial["strategy"] == "compass":
            assert None not in [trial[key] for key in NUMBERS]
            assert set(trial["rotation_error_deg"]) == {"pitch", "yaw", "roll"}
            assert set(trial["translation_error_percent"]) == {"y", "z"}
            assert set(trial["score_at"]) == {"100", "300", "1000"}
            assert trial["ratio"] == pytest.approx(trial["score_final"] / trial["score_reference"])
            assert trial["evaluations"] == 40
            assert trial["cost"] == pytest.approx(10)
        else:
            assert [trial[key] for key in NUMBERS] == [None] * len(NUMBERS)
            assert trial["rotation_error_deg"] is trial["score_at"] is None


def test_summary(content):
    rows = {(row["scene"], row["strategy"]): row for row in content["summary"]}
    assert len(rows) == 4
    good, bad = rows["harbour-0", "compass"], rows["harbour-0", "crashing"]
    assert {"matcher", "schedule", "draws", "success_rate", "ratio_median", "rotation_error_deg_median"} <= set(good)
    assert {"evaluations_median", "cost_median", "seconds_median"} <= set(good)
    assert (good["draws"], good["failed"], good["evaluations_median"]) == (2, 0, 40)
    ratios = [t["ratio"] for t in content["trials"] if (t["scene"], t["strategy"]) == ("harbour-0", "compass")]
    assert good["ratio_median"] == pytest.approx(sum(ratios) / 2)
    assert (bad["failed"], bad["success_rate"], bad["ratio_median"]) == (2, 0.0, None)


def test_a_crash_is_a_failed_row_and_the_others_live(content):
    failed = [t for t in content["trials"] if t["strategy"] == "crashing"]
    assert {t["status"] for t in failed} == {"FAILED"}
    assert all("Crashing" in t["message"] and "KeyError('a bug')" in t["message"] for t in failed)
    assert not any(t["accepted"] for t in failed)
    assert all(t["status"] == "BUDGET" for t in content["trials"] if t["strategy"] == "compass")


def stripped(table):
    content = table.as_dict()
    del content["versions"]
    for row in content["trials"]:
        del row["seconds"]
    for row in content["summary"]:
        del row["seconds_median"]
    return json.dumps(content)


@pytest.mark.slow
def test_the_same_seed_the_same_json(scene, table):
    both = {"compass": strategy("compass"), "crashing": Crashing()}
    again = compare_scenes([scene("harbour"), scene("street")], strategies=both, **SMALL)
    assert stripped(again) == stripped(table)
    other = compare_scenes([scene("harbour"), scene("street")], strategies=both, seed=1, **SMALL)
    assert stripped(other) != stripped(table)


def test_every_draw_is_another(table):
    initial = [t.score_initial for t in table.trials if (t.scene, t.strategy) == ("harbour-0", "compass")]
    assert len(set(initial)) == 2


def test_reach_follows_the_drift(scene):
    given_scene = scene()
    found = compare_scenes([given_scene], drift=Drift(5.0, 0.1), **(SMALL | {"draws": 1}))
    assert found.settings["reach"] == {"degrees": 6.0, "baseline_fraction": pytest.approx(0.12)}


def test_an_explicit_reach(scene):
    given_scene = scene()
    found = compare_scenes([given_scene], reach=Reach(1.0, 0.02), **(SMALL | {"draws": 1}))
    assert found.settings["reach"] == {"degrees": 1.0, "baseline_fraction": 0.02}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"draws": 0}, "nothing to compare"),
        ({"draws": -3}, "nothing to compare"),
        ({"strategies": []}, "nothing to compare"),
        ({"strategies": ["nonsense"]}, "unknown strategy 'nonsense'"),
        ({"scale": 0.0}, "scale is 0.0"),
        ({"scale": 1.5}, "scale is 1.5"),
        ({"scale": float("nan")}, "scale is nan"),
        ({"scale": 0.01}, "at least 16 pixels"),
        ({"matcher": SAD(num_disparities=400)}, "beyond the width of the image"),
    ],
)
def test_requests_that_make_no_sense_are_refused_before_anything_runs(scene, changes, words):
    given_scene = scene()
    with pytest.raises(InputError, match=words):
        compare(given_scene.rig, given_scene.pairs, **(SMALL | changes))


@pytest.mark.parametrize("limits", [(-0.1, 0.01), (17, 0.01), (0.5, 0.5), (float("nan"), 0.0), (0.5, -1.0)])
def test_drifts_that_make_no_sense(limits):
    with pytest.raises(InputError, match="a drift of"):
        Drift(*limits)


def test_a_scene_without_calibration(scene):
    with pytest.raises(InputError, match="garden: the scene has no calibration"):
        compare_scenes([Scene("garden", None, scene().pairs)], **SMALL)
    with pytest.raises(InputError, match="nothing to compare"):
        compare_scenes([])
