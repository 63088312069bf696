"""What is said first: a verdict of a line and what to do, of every ending and every look; what a refusal keeps."""

import json
import re
from dataclasses import asdict, replace

import numpy as np
import pytest
from fixtures import SAD_48
from hypothesis import given, strategies as st

import stereorecal as sr
from stereorecal.decision import Criterion
from stereorecal.recalibration import Condition, Interval, Reason
from stereorecal.scoring import ImageQuality

DRIFT = np.radians([0.3, 0.1, -0.2, 0.0, 0.0, 0.0])
REASONS = list(Reason)


@pytest.fixture(scope="module")
def harbour(scene) -> sr.Scene:
    return scene("harbour", 0, (320, 240))


@pytest.fixture(scope="module")
def repaired(harbour) -> sr.Solution:
    return sr.recalibrate(harbour.rig.with_extrinsics(harbour.rig.extrinsics + DRIFT), harbour.pairs, matcher=SAD_48)


@pytest.fixture(scope="module")
def counted(scene) -> sr.Solution:
    """Judged by the count, which decides on nothing else."""
    small = scene()
    off = small.rig.with_extrinsics(small.rig.extrinsics + DRIFT)
    return sr.recalibrate(off, small.pairs, matcher=sr.SAD(num_disparities=24), schedule="count", budget=30)


@pytest.fixture(scope="module")
def looked(harbour) -> sr.Solution:
    return sr.health(harbour.rig, harbour.pairs, matcher=SAD_48)


def without(solution: sr.Solution, finding: str) -> sr.Solution:
    return replace(solution, **{finding: None})


def sentences(text: str) -> list[str]:
    return [part for line in text.splitlines() for part in re.split(r"(?<=[.;])\s+(?=[A-Z])", line)]


def assert_plain(text: str, verdict: str, advice: str) -> None:
    """The first line is a verdict of at most twelve words, the second says what to do; no sentence has two colons."""
    assert text.splitlines()[:2] == [verdict, advice]
    assert len(verdict.split()) <= 12, verdict
    for said in (verdict, advice):
        assert said[0].isupper()
        assert said.endswith(".")
    for sentence in sentences(text):
        assert len(re.findall(r":(?:\s|$)", sentence)) <= 1, sentence


@pytest.mark.parametrize("reason", REASONS, ids=[reason.name for reason in REASONS])
def test_every_ending_is_a_verdict_and_an_advice(repaired, counted, reason):
    for solution in (repaired, without(repaired, "decision"), counted):
        found = replace(solution, reason=reason)
        assert_plain(str(found), found.verdict, found.advice)
        assert found.verdict.startswith("Repaired") == reason.accepted
        assert found.verdict.startswith("Cannot tell") == reason.undetermined
        assert found.accepted == (found.rig is found.candidate)


@pytest.mark.parametrize("reason", REASONS, ids=[reason.name for reason in REASONS])
def test_every_look_is_a_verdict_and_an_advice(looked, reason):
    found = replace(looked, reason=reason)
    assert_plain(str(found), found.verdict, found.advice)
    assert found.healthy == (reason is Reason.ALREADY_GOOD)
    assert found.verdict.startswith("Repair it") == (found.condition is Condition.REPAIR) or reason.accepted
    if found.condition is Condition.REPAIR:
        assert "recalibrate" in found.advice


@pytest.mark.parametrize(
    "shown",
    [
        ImageQuality(19.0, 0.8),
        ImageQuality(120.0, 0.1),
        ImageQuality(99.0, 0.5, coarse=True),
        ImageQuality(99.0, 0.5, noise=True),
        ImageQuality(99.0, 0.5, interlaced=True),
    ],
)
def test_images_that_show_too_little_are_named(looked, shown):
    found = replace(looked, reason=Reason.TOO_LITTLE_TEXTURE, shown=shown, decision=None)
    assert_plain(str(found), found.verdict, found.advice)
    assert str(shown.problem) in found.verdict


@given(reason=st.sampled_from(REASONS), pairs=st.integers(1, 2000), rows=st.tuples(*[st.floats(0.0, 1e4)] * 3))
def test_no_number_makes_a_verdict_longer(looked, reason, pairs, rows):
    decision = replace(looked.decision, rows_px=np.array([sorted(rows)] * 2))
    found = replace(looked, reason=reason, used=(0,) * pairs, decision=decision)
    assert len(found.verdict.split()) <= 12


@pytest.mark.parametrize("low", [0.5, -0.5])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_what_became_of_depth_is_said_once(repaired, share, low):
    """What a line says beside the verdict does not contradict it."""
    found = replace(repaired, reason=Reason.IMPROVED, decision=replace(repaired.decision, depth_corrected=share))
    off = replace(repaired.depth[0], percent=Interval(1.0, low, 1.5))
    vars(found)["depth_before"] = vars(found)["depth"] = (off,)
    lines = {
        "depth kept as calibrated": "kept as it was calibrated",
        "depth corrected in part": "corrected as far as is safe",
    }
    for verdict, line in lines.items():
        assert (verdict in found.verdict) == (line in str(found))
    assert ("depth not significantly changed" in found.verdict) == (low < 0 < share)


@pytest.mark.parametrize("failed", [*Criterion, None])
def test_a_good_calibration_whose_depth_is_off_says_why_it_stays(looked, repaired, failed):
    """Rows make it good: what is said above an interval of depth that leaves out zero must not contradict it."""
    off = replace(looked.depth[0], distance=2.0, percent=Interval(1.0, 0.5, 1.5))
    decision = replace(looked.decision, failed=failed)
    look = replace(looked, reason=Reason.ALREADY_GOOD, decision=decision)
    repair = replace(repaired, reason=Reason.ALREADY_GOOD, decision=decision)
    for found in (look, repair):
        vars(found)["depth_before"] = vars(found)["depth"] = (off,)
        assert found.verdict.startswith("Good.")
        assert found.advice.startswith("But depth is 10 to 30 mm too far at 2 m, and ")
        assert_plain(str(found), found.verdict, found.advice)


@pytest.mark.parametrize("reason", [reason for reason in REASONS if not reason.accepted], ids=lambda one: one.name)
def test_what_is_refused_stays_bit_for_bit(repaired, reason):
    """And no interval or depth is told of the answer that was found wrong: the one that nobody can tell is not."""
    found = replace(repaired, reason=reason)
    assert found.rig is repaired.initial
    assert found.to_dict()["extrinsics"]["used"] == found.to_dict()["extrinsics"]["before"]
    told = reason.healthy or reason is Reason.CANNOT_TELL
    assert ("\ndepth " in str(found)) == bool(found.to_dict()["depth"]) == told
    by_chance = replace(found, seen=replace(found.seen, by_chance=True))
    assert ("\ndepth " in str(by_chance)) == reason.healthy, "matches are by chance"
    assert "±" not in str(found)


def test_what_changes_of_intrinsics_is_said_and_how_to_keep_them(repaired):
    assert "the intrinsics were refined" in str(repaired)
    assert "use all new values together" in str(repaired)
    assert "--free" not in str(without(repaired, "intrinsics"))


def test_data_of_a_repair(repaired):
    data = json.loads(json.dumps(repaired.to_dict(), allow_nan=False))
    assert (data["accepted"], data["healthy"], data["reason"]) == (True, True, "improved")
    assert (data["verdict"], data["advice"]) == (repaired.verdict, repaired.advice)
    assert data["why"] == repaired.reason.value
    assert data["intrinsics"]["outcome"] == "refined"
    decision = data["decision"]
    assert (decision["verdict"], decision["failed"]) == ("repair", None)
    assert 0.0 <= decision["depth_corrected"] <= 1.0
    assert decision["expected_loss"]["candidate"] < decision["expected_loss"]["before"]
    assert decision["rows_px"]["candidate"]["high"] < decision["rows_px"]["before"]["low"]
    assert {"name", "count", "before", "after", "fitted"} == set(decision["held_out"][0])
    for when, said in (("before", repaired.score_before), ("after", repaired.score_after)):
        assert data[f"score_{when}"] == {"count": said.count, "pixels": 320 * 240, "fraction": said.fraction}
        assert data["row_error_px"][when] == getattr(repaired.row_errors, when)
    for which, rig in (("before", repaired.initial), ("candidate", repaired.candidate), ("used", repaired.rig)):
        angles = np.radians(list(data["extrinsics"][which]["rotation_deg"].values()))
        np.testing.assert_allclose(angles, rig.extrinsics[:3], rtol=1e-14)
        assert list(data["extrinsics"][which]["translation_m"].values()) == rig.extrinsics[3:].tolist()
    change, widths, baseline = data["change"], data["interval_95"], float(repaired.initial.baseline)
    np.testing.assert_allclose(list(change["rotation_deg"].values()), np.degrees(repaired.change[:3]))
    np.testing.assert_allclose(list(change["translation_percent"].values()), 100 * repaired.change[3:] / baseline)
    found = [*widths["rotation_deg"].values(), *widths["translation_percent"].values()]
    np.testing.assert_allclose(found, repaired.uncertainty.interval)
    assert list(data["observed"]) == data["covariance"]["axes"] == ["pitch", "yaw", "roll", "y", "z"]
    assert list(data["observed"].values()) == repaired.uncertainty.observed.tolist()
    np.testing.assert_allclose(data["covariance"]["matrix"], repaired.covariance)
    assert list(data["depth_error_percent"]) == ["5", "10", "30", "100"]
    assert (data["evaluations"], data["cost"]) == (repaired.evaluations, pytest.approx(repaired.cost.budgeted))
    assert data["cost_total"] == pytest.approx(repaired.cost.total)
    assert data["cost_of"] == pytest.approx(asdict(repaired.cost))
    assert sum(stage["evaluations"] for stage in data["stages"]) == data["evaluations"]
    chance = replace(repaired, reason=Reason.NO_MATCHES).to_dict()
    for name in ("row_error_px", "misfit", "undetermined", "interval_95", "estimate", "decision"):
        assert data[name] is not None
        assert chance[name] is None, "text and page say nothing of it, too"
    assert (chance["depth"], chance["depth_error_percent"]) == ([], {})
    refused = replace(repaired, reason=Reason.CANNOT_TELL).to_dict()
    assert (refused["accepted"], refused["healthy"], refused["expected"]) == (False, False, None)


def test_data_of_a_look(looked):
    data = json.loads(json.dumps(looked.to_dict(), allow_nan=False))
    assert (data["condition"], data["reason"], data["healthy"]) == ("healthy", "already_good", True)
    assert (data["verdict"], data["advice"]) == (looked.verdict, looked.advice)
    assert data["main_axes"] == []
    off = replace(looked, reason=Reason.IMPROVED)
    assert " would change by " in str(off)
    assert ", then " in str(off)
    bad = off.to_dict()
    assert (bad["condition"], bad["healthy"]) == ("repair", False)
    assert len(bad["main_axes"]) >= 1
