"""A late shutter beside the rig: told where frames move at different speeds, and the rig beside it is the true one."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_tracks import late_rig, tracks_of

from stereorecal.estimation import Windows, estimate, points_of_view, readings

SECONDS = 0.1
WAYS = [((0.05 * k, 0.0, -0.4 - 0.2 * k), (0.004 * k - 0.006, 0.008 - 0.005 * k, 0.002 * k)) for k in range(4)]
STEADY = [WAYS[2]] * 4


def solved(rig, true, prior, seen, late, ways=WAYS, first=None, seconds=SECONDS):
    """The estimate of four frames of a rig whose right shutter is late by a share of the time between two pairs.

    Args:
        first: tracks in place of those of the first way.
        seconds: from one pair to the next.
    """
    tracks = tuple(tracks_of(true, *way, seed=k, number=300, late=late) for k, way in enumerate(ways))
    tracks = tracks if first is None else (first, *tracks[1:])
    frames = [seen(rig, late_rig(true, *way, late), k, frames=1, cells=400) for k, way in enumerate(ways)]
    parts = {
        name: np.concatenate([getattr(one, name) for one in frames]) for name in ("left", "right", "weight", "tile")
    }
    windows = Windows(tracks, tuple((k, k) for k in range(len(ways))), (seconds,) * len(ways))
    return estimate(replace(frames[0], **parts), rig, prior, windows=windows)


@pytest.mark.parametrize("late", [0.2, pytest.param(-0.1, marks=pytest.mark.slow)])
def test_a_late_shutter_is_told_and_does_no_harm(rig, chart, prior, seen, late):
    true = chart.rig_at(np.r_[0.2, 0.3, -0.3, 0.2, -0.3, np.zeros(chart.dim - 5)])
    found = solved(rig, true, prior, seen, late)
    assert found.delay.probability > 0.99
    assert found.is_late
    assert found.delay.seconds == pytest.approx(late * SECONDS, abs=0.03 * SECONDS)
    error = 100.0 * float(readings(found.chart.rig_at(found.theta), true, points_of_view(true, 30))[1].mean())
    assert abs(error) < 3.0
    assert not found.other_rigs


def test_a_shutter_in_time_is_not_late(rig, prior, seen):
    found = solved(rig, rig, prior, seen, 0.0)
    assert found.delay is None or found.delay.probability < 0.1
    assert not found.is_late


@pytest.mark.slow
def test_the_unit_of_time_does_not_matter(rig, prior, seen):
    """How probable a delay is, depends on its share of the time between two pairs."""
    told = [solved(rig, rig, prior, seen, 0.009, seconds=seconds).delay for seconds in (1.0, 0.02)]
    assert told[0].seconds == pytest.approx(told[1].seconds / 0.02, rel=1e-3)
    assert 1.0 - told[0].probability == pytest.approx(1.0 - told[1].probability, rel=0.05)


@pytest.mark.slow
def test_on_a_steady_way_a_delay_and_a_shift_are_one(rig, prior, seen):
    """What is told is their sum; and no drift shifts a rig so far."""
    found = solved(rig, rig, prior, seen, 0.1, STEADY)
    low, high = found.intervals[found.names.index("z")]
    assert low < 0.0 < high


def test_a_window_that_moves_by_a_hundred_baselines_is_no_error(rig, prior, seen):
    """What the right camera would see then is no rig: its baseline points the other way."""

    def far_away(rays):
        return np.full(len(rays), 1 / 3000)

    leap = tracks_of(rig, (200.0, 0.0, -20.0), nearness=far_away)
    found = solved(rig, rig, prior, seen, 0.0, first=leap)
    assert max(window.metres[0] for window in found.motions) > 100.0 * float(rig.baseline)
    assert found.delay is None or found.delay.probability < 0.1
