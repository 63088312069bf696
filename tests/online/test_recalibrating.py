"""Recalibration on request."""

from types import SimpleNamespace

import numpy as np
import pytest
from parts_of_repairs import _switching
from rides import BEFORE, Ride, error

from stereorecal.decision import decide
from stereorecal.estimation import (
    Estimate,
    Mixture,
    consequences,
    points_of_view,
    readings,
    rig_parameters,
)
from stereorecal.geometry import StereoRig
from stereorecal.objectives import EXTRINSICS
from stereorecal.online import Config, Kind, freeze, init, reading, recalibrate, rollback, step
from stereorecal.recalibration import Reason


@pytest.mark.slow
def test_a_knock(ride: Ride):
    state = init(ride.rig)
    after, (event,) = recalibrate(state, ride.pairs[BEFORE : BEFORE + 3])
    assert event.kind is Kind.RECALIBRATED
    assert error(after, ride.knocked)[0] < 0.03 < 0.4 < error(state, ride.knocked)[0]
    assert event.facts["proof"]["row_error_after_px"] < event.facts["proof"]["row_error_before_px"]
    assert reading(after).change is None  # the estimate goes with it
    same, (event,) = recalibrate(state, ride.pairs[:2])
    assert (same, event.kind, event.why) == (state, Kind.REJECTED, Reason.ALREADY_GOOD.value)


@pytest.mark.parametrize("reason", Reason, ids=lambda reason: reason.name)
def test_only_what_the_decision_accepts_is_in_use(ride: Ride, monkeypatch: pytest.MonkeyPatch, reason: Reason):
    chart = rig_parameters(ride.rig)
    posterior = Mixture(np.ones(1), chart.coordinates_of(ride.knocked)[None], 1e-4 * np.eye(chart.dim)[None])
    estimate = Estimate(chart, posterior, (0.0, 0.0), 0, float("nan"), np.ones(chart.dim))
    found = SimpleNamespace(
        accepted=reason.accepted,
        reason=reason,
        rig=ride.knocked if reason.accepted else ride.rig,
        estimate=estimate,
        decision=decide(estimate, EXTRINSICS),
    )
    monkeypatch.setattr(_switching, "recalibrated", lambda *given, **options: found)
    state = freeze(init(ride.rig, Config()))
    after, (event,) = recalibrate(state, ride.pairs[BEFORE : BEFORE + 1])
    if not reason.accepted:
        assert (after, event.kind, event.why) == (state, Kind.REJECTED, reason.value)
        return
    assert event.kind is Kind.RECALIBRATED
    np.testing.assert_allclose(after.rig.extrinsics, ride.knocked.extrinsics, atol=1e-6)
    assert event.facts["new"]["extrinsics"] == after.rig.extrinsics.tolist()
    assert np.array_equal(after.previous, [state.using])
    assert not after.config.repair  # frozen, as it was
    assert np.array_equal(rollback(after).rig.extrinsics, ride.rig.extrinsics)


def depth_error(used: StereoRig, true: StereoRig) -> float:
    """Percent, at 30 baselines, on average over the view."""
    _, nearness = readings(used, true, points_of_view(true, 30.0))
    return abs(100.0 * (1.0 / (1.0 + float(np.mean(nearness))) - 1.0))


def with_wrong_lenses(true: StereoRig, pixels: float) -> StereoRig:
    """A principal point so many pixels off, and the yaw that makes up for it in depth, though not in rows."""
    chart = rig_parameters(true)
    near, yaw, principal_point = (
        consequences(chart, np.zeros(chart.dim), (30,)).mean_nearness[0],
        chart.names.index("yaw"),
        chart.names.index("right.cx"),
    )
    theta = np.zeros(chart.dim)
    theta[principal_point], theta[yaw] = pixels, -pixels * near[principal_point] / near[yaw]
    return chart.rig_at(theta)


def test_extrinsics_are_not_taken_without_the_lenses_that_they_go_with(ride: Ride):
    """Rows alone would undo the yaw, and with it depth."""
    given = with_wrong_lenses(ride.rig, 10.0)
    after, (event,) = recalibrate(init(given), ride.pairs[:3])
    assert depth_error(given, ride.rig) < 1.0
    assert depth_error(after.rig, ride.rig) < 3.0, event.kind


def test_what_follows_a_request_finds_nothing_moved(ride: Ride):
    """The keystone of the lenses is counted once."""
    state = init(with_wrong_lenses(ride.rig, 10.0))
    for pair in ride.pairs[:BEFORE]:
        state, _ = step(state, pair)
    state, (event,) = recalibrate(state, ride.pairs[BEFORE : BEFORE + 3])
    assert event.kind is Kind.RECALIBRATED
    said = []
    for pair in ride.pairs[BEFORE + 3 :]:
        state, events = step(state, pair)
        said += [event.kind for event in events]
    assert not {Kind.KNOCK, Kind.DRIFTING} & set(said)


def test_pairs_that_cannot_be_used(ride: Ride):
    state = init(ride.rig)
    for size in ((240, 320), (24, 32)):
        after, (event,) = recalibrate(state, [(np.zeros(size, np.uint8),) * 2])
        assert (after, event.kind) == (state, Kind.REJECTED)
        assert event.why
