"""What the page of a repair is given: of the calibration that is to be used, and nothing where nothing was found."""

import json
from dataclasses import replace

import numpy as np
import pytest
from fixtures import SAD_48
from parts_of_repairs import conclusion_of, report_of
from simulated_rows import chart as chart, rig as rig, seen as seen

import stereorecal as sr
from stereorecal.estimation import estimate
from stereorecal.geometry import changed_camera, view
from stereorecal.recalibration import Intrinsics, IntrinsicsOutcome, Reason, row_errors_of
from stereorecal.report.repair_report import Conclusion, RepairReport

RIG = sr.synthetic.default_rig().resized((320, 240))
DRIFTED = RIG.with_extrinsics(RIG.extrinsics + np.radians([0.6, -0.3, 0.5, 0.0, 0.0, 0.0]))


@pytest.fixture(scope="module")
def harbour(scene) -> tuple[sr.Pair, ...]:
    return scene("harbour", 0, RIG.left.size).pairs


@pytest.fixture(scope="module")
def repaired(harbour) -> sr.Solution:
    return sr.recalibrate(DRIFTED, harbour, matcher=SAD_48, budget=sr.Budget(evaluations=200), seed=7)


def reported(solution: sr.Solution, pairs, **settings) -> RepairReport:
    return report_of(solution, pairs, "", None, settings, ())


def test_all_that_repeats_a_repair(repaired, harbour):
    said = reported(repaired, harbour).settings
    assert reported(repaired, harbour, output="new.json").advice.endswith("--output new.json).")
    assert said["free"][:6] == ["pitch", "yaw", "roll", "y", "z", "left.f"]
    assert said["reach"] == {"degrees": 3.0, "baseline_fraction": 0.03}
    assert said["budget"] == {"evaluations": 200, "seconds": None}
    assert (said["seed"], said["schedule"]) == (7, "default")
    assert (said["matcher"]["name"], said["matcher"]["num_disparities"]) == ("sad", 48)
    assert [stage["strategy"] for stage in said["stages"]][::2] == ["compass", "fit"]
    assert said["stages"][0]["options"]["step"] == 0.125
    assert "compass 0." in said["stages"][0]["origin"]


def test_the_pair_that_is_shown_is_matched_once(repaired, harbour, tmp_path, monkeypatch):
    """For the page and the recordings of one command; pairs that were not looked at are on the page."""
    matched, solution = [], replace(repaired, selected=(0,))
    monkeypatch.setattr(
        "stereorecal.recalibration._repair_report.disparity",
        lambda rig, *given, **how: matched.append(rig) or sr.disparity(rig, *given, **how),
    )
    for name in ("page", "another"):
        solution.to_html(tmp_path / f"{name}.html", [*harbour, *harbour], name=name)
    assert matched == [solution.initial, solution.candidate]
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "1 other pair</td>" in page
    assert "1 frame was used." in page


def test_what_was_good_speaks_of_itself(harbour):
    solution = sr.recalibrate(RIG, harbour, matcher=SAD_48)
    found = reported(solution, harbour)
    assert found.conclusion is Conclusion.GOOD
    assert not found.accepted
    assert found.when == "before"
    assert found.depths == [(error, error) for error in solution.depth]
    (used, _) = found.calibrations.values()
    assert json.loads(used)["T"] == RIG.translation.tolist()
    assert any("not taken" in title for title in found.calibrations)
    look = replace(solution, searched=False, reason=Reason.MISFIT)
    assert (look.condition.name, reported(look, harbour).conclusion) == ("CANNOT_TELL", Conclusion.UNKNOWN)


def test_what_nobody_can_tell_has_no_tables(harbour):
    dark = [sr.Pair(0.01 * pair.left, 0.01 * pair.right, pair.name) for pair in harbour]
    solution = sr.recalibrate(DRIFTED, dark, matcher=SAD_48)
    assert solution.reason is Reason.TOO_LITTLE_TEXTURE
    found = reported(solution, dark)
    assert found.conclusion is Conclusion.UNKNOWN
    assert (list(found.axes), list(found.depths), list(found.remarks)) == ([], [], [])
    assert found.rows is found.misfit is found.expected is None


def test_a_page_concludes_as_the_verdict_does():
    unknown = {Reason.TOO_LITTLE_TEXTURE, Reason.OUT_OF_BUDGET, Reason.CANNOT_TELL}
    for reason in Reason:
        assert (conclusion_of(reason) is Conclusion.REPAIRED) == reason.accepted
        assert (conclusion_of(reason) in (Conclusion.REPAIRED, Conclusion.GOOD)) == reason.healthy
        assert (conclusion_of(reason) is Conclusion.UNKNOWN) == (reason in unknown)


def test_rows_under_other_lenses(repaired, harbour):
    """Matches are what the initial cameras saw: under them the true rig's rows agree, under others they do not."""
    lenses = replace(RIG, right=changed_camera(RIG.right, {"f": 0.02, "cy": 2.0}))
    initial, other = (rig.with_extrinsics(repaired.rig.extrinsics) for rig in (RIG, lenses))
    rows = reported(replace(repaired, initial=initial, candidate=other), harbour).rows
    assert rows is not None
    assert np.median(np.abs(rows.all_before)) < 0.2
    assert np.median(np.abs(rows.all_after)) > 1.5


def test_lenses(repaired, harbour):
    """In units of a calibration file, with intervals in the same."""
    right = changed_camera(RIG.right, {"f": 0.01, "cx": 2.0, "k1": 0.02})
    names, interval = ("baseline", "right.f", "right.cx", "right.k1"), np.array([0.1, 0.5, 0.25, 0.001])
    units = ("%", "%", "px", "")
    taken, kept = IntrinsicsOutcome.REFINED, IntrinsicsOutcome.REFUSED
    seen = Intrinsics(taken, names, units, np.zeros(4), interval, ("right.cx",))
    other = replace(repaired, initial=RIG, candidate=replace(RIG, right=right))

    def intrinsics_of(seen: Intrinsics | None):
        return reported(replace(other, intrinsics=seen), harbour).intrinsics

    cameras, (focal, centre, first) = zip(*intrinsics_of(seen), strict=True)
    assert cameras == ("right",) * 3
    assert (focal.name, focal.unit) == ("focal length, f", "px")
    before = float(RIG.right.matrix[0, 0])
    np.testing.assert_allclose([focal.before, focal.after], [before, before * np.exp(0.01)])
    np.testing.assert_allclose(focal.half_width, 0.005 * focal.after)
    assert (centre.observed, first.observed) == (False, True)
    np.testing.assert_allclose([centre.after - centre.before, centre.half_width], [2.0, 0.25])
    np.testing.assert_allclose(first.after - first.before, 0.02)
    assert intrinsics_of(None) == intrinsics_of(replace(seen, outcome=kept)) == []


def test_what_is_to_be_expected_of_rows_has_the_sign_of_the_rows(repaired, rig, chart, seen):
    """As `sr.difference` has them: the row in the left rectified image less the one in the right."""
    true = chart.rig_at(np.r_[0.3, 0.0, 0.2, np.zeros(chart.dim - 3)])
    shown, columns, rows = view(rig), np.linspace(0, 639, 17), np.linspace(0, 479, 13)
    kept = replace(repaired, initial=rig, reason=Reason.ALREADY_GOOD, view=shown)
    found = replace(kept, estimate=estimate(seen(rig, true, cells=900), rig)).expected
    apart = row_errors_of(rig, true, shown, columns, rows, (10.0,))[0]
    assert np.nanmean(np.abs(apart)) > 1.0
    assert np.nanmax(np.abs(found.rows - apart) / found.rows_deviation) < 5.0
