"""The page on JSON, held against what commands write: no key that it does not list, and none that nobody writes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from json_page import differences, listed, matched, paths
from simulated_tracks import tracks_of

import stereorecal as sr
from stereorecal.comparison import errors_by_truth
from stereorecal.estimation import Estimate, Mixture, Windows, rig_parameters
from stereorecal.recalibration import Mismatch, RangesSeen

RIG = sr.synthetic.default_rig()
CHART = rig_parameters(RIG)
MOVED = Estimate(
    CHART,
    Mixture(np.ones(1), np.zeros((1, CHART.dim)), np.eye(CHART.dim)[None]),
    (0.0, 0.0),
    1,
    0.0,
    np.ones(CHART.dim),
    windows=Windows((tracks_of(RIG),), ((0, 1),), (1.0,)),
)
VERSIONS = {"health": 4, "solution": 3}
COUNT = ("--schedule", "count", "--scale", 0.5, "--budget", 40)


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("schema", ["solution", "health", "difference", "compare"])
def test_what_is_written_and_what_is_listed(command, schema: str, clean_scene, drifted_scene, tmp_path: Path):
    words = {
        "solution": ("recalibrate", drifted_scene),
        "health": ("score", drifted_scene),
        "difference": ("diff", clean_scene, drifted_scene),
        "compare": ("compare", "--scene", drifted_scene, "--draws", 1, *COUNT),
    }[schema]
    target, calibration = tmp_path / "out.json", tmp_path / "calib.json"
    words = (*words, "--output", calibration) if schema == "solution" else words
    command(*words, "--json", target, "--quiet")
    content = json.loads(target.read_text())
    assert content["schema"] == f"stereorecal.{schema}/{VERSIONS.get(schema, 1)}"
    for answers in content.keys() & {"repairs", "scenes"} if schema != "compare" else ():
        assert content[answers][0]["mismatch"] is None
        content[answers][0]["mismatch"] = Mismatch(0.1).as_dict()
    if schema == "health":  # a scene has the keys of a repair
        scenes = content["scenes"]
        assert [scenes[0].pop(name) for name in ("motion", "ranges")] == [None] * 2
        assert not differences([{"schema": "stereorecal.solution/3", "repairs": scenes}])[0]
        content["scenes"] = [{key: value for key, value in one.items() if type(value) is not dict} for one in scenes]
        for scene in content["scenes"]:
            del scene["stages"], scene["depth"]
    if schema == "solution":
        prior = json.loads(calibration.read_text())["prior"]
        assert differences([prior]) == (set(), {"versions.*"})
        assert content["repairs"][0]["ranges"] is None
        assert content["repairs"][0]["motion"] is None
        content["repairs"][0]["ranges"] = RangesSeen(5, 4, 1).as_dict()
        given = sr.io.load_scene(drifted_scene)
        repaired = sr.recalibrate(given.rig, given.pairs, budget=1)
        content["repairs"][0]["motion"] = replace(repaired, estimate=MOVED).to_dict()["motion"]
    if schema == "compare":  # of a scene whose true rig is not known
        (trial,), (row,) = content["trials"], content["summary"]
        assert trial["by_truth"] is row["harmful"] is row["row_error_px_median"] is None
        trial["by_truth"] = errors_by_truth(RIG, RIG, RIG, sr.view(RIG))
        row |= {"row_error_px_median": {"final": 0.1}, "depth_error_percent_median": {"30": 1.0}}
    assert differences([content]) == (set(), set())


def test_the_page_is_read():
    """Every heading, more than one key in a row, and what would not be found."""
    pages = listed()
    written = "solution/3", "health/4", "difference/1", "compare/1", "events/1", "prior/2", "reproduce/1", "field/1"
    assert set(pages) == {"All schemas", *(f"stereorecal.{name}" for name in written)}
    assert {"before", "after"} <= pages["stereorecal.difference/1"]
    assert list(paths({"a": {"b": 1, "c": [{"d": None}, {"e": []}]}, "f": {}})) == ["a.b", "a.c[].d", "a.c[].e", "f"]
    assert matched("a[].*", "a[].b")
    assert not matched("a[].*", "a[].b.c")
    assert not matched("a.b", "a.bc")
