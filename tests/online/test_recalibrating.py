"""Recalibration on request."""

from types import SimpleNamespace

import numpy as np
import pytest
from parts_of_repairs import _recalibrating
from rides import BEFORE, Ride, error

from stereorecal.online import Config, Kind, freeze, init, reading, recalibrate, rollback
from stereorecal.recalibration import Reason, RowErrors


@pytest.mark.slow
def test_a_knock(ride: Ride):
    state = init(ride.rig)
    after, (event,) = recalibrate(state, ride.pairs[BEFORE : BEFORE + 3])
    assert event.kind is Kind.RECALIBRATED
    assert error(after, ride.knocked)[0] < 0.03 < 0.4 < error(state, ride.knocked)[0]
    assert event.facts["proof"]["row_error_after_px"] < event.facts["proof"]["row_error_before_px"]
    assert not reading(after).repairs  # the estimate goes with it
    same, (event,) = recalibrate(state, ride.pairs[:2])
    assert (same, event.kind, event.why) == (state, Kind.REJECTED, Reason.ALREADY_GOOD.value)


@pytest.mark.parametrize("reason", Reason, ids=lambda reason: reason.name)
def test_only_what_the_decision_accepts_is_in_use(ride: Ride, monkeypatch: pytest.MonkeyPatch, reason: Reason):
    found = SimpleNamespace(
        accepted=reason.accepted,
        reason=reason,
        rig=ride.knocked if reason.accepted else ride.rig,
        covariance=1e-4 * np.eye(5),
        row_errors=RowErrors(3.0, 0.1, 9.0),
    )
    monkeypatch.setattr(_recalibrating, "recalibrated", lambda *given, **options: found)
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


def test_pairs_that_cannot_be_used(ride: Ride):
    state = init(ride.rig)
    for size in ((240, 320), (24, 32)):
        after, (event,) = recalibrate(state, [(np.zeros(size, np.uint8),) * 2])
        assert (after, event.kind) == (state, Kind.REJECTED)
        assert event.why
