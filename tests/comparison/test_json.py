"""The JSON of a comparison: complete, versioned, free of NaN, the same for the same seed."""

import json

import pytest
from moody import Crashing

from stereorecal import InputError
from stereorecal.comparison import Drift, compare, compare_scenes
from stereorecal.matching import SAD
from stereorecal.objectives import Reach
from stereorecal.recordings import Scene
from stereorecal.strategies import Budget, strategy

SMALL = {"matcher": SAD(num_disparities=24), "draws": 2, "scale": 0.5, "budget": Budget(evaluations=10)}


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


def test_what_was_compared(content):
    """(Which keys there are is held against the page on JSON, in tests/cli.)"""
    settings, (first, second) = content["settings"], content["scenes"]
    assert (content["schema"], content["interrupted"]) == ("stereorecal.compare/1", False)
    assert content["versions"]["strategy compass"].startswith("stereorecal-compass ")
    assert settings["strategies"] == ["compass", "crashing"]
    assert (settings["matcher"]["name"], settings["matcher"]["block_size"]) == ("sad", 11)
    assert settings["decalibrate"] == {"degrees": 0.5, "baseline_fraction": 0.01}
    assert settings["reach"] == {"degrees": 3.0, "baseline_fraction": 0.03}
    assert (settings["draws"], settings["seed"], settings["scale"], settings["schedule"]) == (2, 0, 0.5, "count")
    assert settings["budget"] == {"evaluations": 10, "seconds": None}
    assert (first["name"], second["name"]) == ("harbour-0", "street-0")
    assert (first["image_size"], first["reference"], first["num_disparities"]) == ([160, 120], "truth", 24)


def test_trials(content):
    """A crash is a failed row without numbers, and the others live."""
    trials = content["trials"]
    assert [(t["scene"], t["draw"], t["strategy"]) for t in trials] == [
        (s, d, name) for s in ("harbour-0", "street-0") for d in (0, 1) for name in ("compass", "crashing")
    ]
    for trial in trials:
        numbers = [trial[key] for key in ("score_initial", "score_final", "score_reference", "ratio", "seconds")]
        if trial["strategy"] == "compass":
            assert None not in numbers
            assert trial["status"] == "BUDGET"
            assert trial["ratio"] == pytest.approx(trial["score_final"] / trial["score_reference"])
            assert (trial["evaluations"], trial["cost"]) == (40, pytest.approx(10))
            assert set(trial["by_truth"]["row_error_px"]) == {"start", "final"}
        else:
            assert trial["status"] == "FAILED"
            assert "Crashing" in trial["message"]
            assert "KeyError('a bug')" in trial["message"]
            assert not trial["accepted"]
            assert {*numbers, trial["evaluations"], trial["cost"], trial["by_truth"]} == {None}
            assert trial["rotation_error_deg"] is trial["score_at"] is None


def test_summary(content):
    rows = {(row["scene"], row["strategy"]): row for row in content["summary"]}
    assert len(rows) == 4
    good, bad = rows["harbour-0", "compass"], rows["harbour-0", "crashing"]
    assert (good["draws"], good["failed"], good["evaluations_median"]) == (2, 0, 40)
    ratios = {t["ratio"] for t in content["trials"] if (t["scene"], t["strategy"]) == ("harbour-0", "compass")}
    assert len(ratios) == 2  # each draw is another
    assert good["ratio_median"] == pytest.approx(sum(ratios) / 2)
    assert (bad["failed"], bad["success_rate"], bad["ratio_median"], bad["harmful"]) == (2, 0.0, None, None)


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


@pytest.mark.parametrize(
    ("reach", "expected"),
    [(None, {"degrees": 6.0, "baseline_fraction": pytest.approx(0.12)}), (Reach(1.0, 0.02), vars(Reach(1.0, 0.02)))],
)
def test_the_reach_follows_the_drift_unless_it_is_given(scene, reach, expected):
    found = compare_scenes([scene()], drift=Drift(5.0, 0.1), reach=reach, **(SMALL | {"draws": 1}))
    assert found.settings["reach"] == expected


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"draws": 0}, "nothing to compare"),
        ({"strategies": []}, "nothing to compare"),
        ({"strategies": ["nonsense"]}, "unknown strategy 'nonsense'"),
        ({"scale": 1.5}, "scale is 1.5"),
        ({"scale": 0.01}, "at least 16 pixels"),
        ({"matcher": SAD(num_disparities=400)}, "beyond the width of the image"),
    ],
)
def test_requests_that_make_no_sense_are_refused_before_anything_runs(scene, changes, words):
    given_scene = scene()
    with pytest.raises(InputError, match=words):
        compare(given_scene.rig, given_scene.pairs, **(SMALL | changes))


@pytest.mark.parametrize("limits", [(17, 0.01), (0.5, 0.5), (float("nan"), 0.0), (0.5, -1.0)])
def test_drifts_that_make_no_sense(limits):
    with pytest.raises(InputError, match="a drift of"):
        Drift(*limits)


def test_a_scene_without_calibration(scene):
    with pytest.raises(InputError, match="garden: the scene has no calibration"):
        compare_scenes([Scene("garden", None, scene().pairs)], **SMALL)
    with pytest.raises(InputError, match="nothing to compare"):
        compare_scenes([])
