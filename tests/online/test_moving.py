"""The rig's own motion on the vehicle: what is followed, for how long, and what has no say."""

import numpy as np
import pytest
from parts_of_estimates import Measurement
from parts_of_repairs import _moving
from rides import standing_at
from simulated_tracks import tracks_of

from stereorecal.estimation import Normal, consequences
from stereorecal.online import State, init, step
from stereorecal.recordings import Pair
from stereorecal.scoring.host import Corners
from stereorecal.synthetic import default_rig


def with_corners(state, pairs=5, since=None):
    grid = np.stack(np.meshgrid(np.arange(20.0, 300.0, 20.0), np.arange(20.0, 220.0, 40.0)), axis=-1).reshape(-1, 2)
    image = np.random.default_rng(0).integers(0, 255, (240, 320), dtype=np.uint8)
    corners = Corners(image, grid, grid - np.array([8.0, 0.0]))
    return state.replace(corners=corners, corners_frame=state.frame - pairs, corners_time=since, tracked_pairs=4)


def after_coarse(state: State, readout: float = 0.0, time: float | None = None) -> State:
    """The state after a pair of so few grey levels that only corners are looked for; it tells nothing of the rig."""
    left, right = np.random.default_rng(1).integers(0, 4, (2, 240, 320)).astype(np.float32) * 64.0
    after, _ = step(state, Pair(left, right, time=time).read_out(readout))
    np.testing.assert_array_equal(after.estimate.mean, state.later().estimate.mean)
    return after


@pytest.mark.parametrize("time", [10.0, 9.0, 12.5, 10_000.0])
def test_times_that_stand_go_back_or_jump_end_it(ridden, time):
    after = after_coarse(with_corners(ridden[-1].state, since=10.0), time=time)
    assert (after.corners, after.tracked_pairs) == (None, 4)  # not even looked for


@pytest.mark.parametrize(("since", "time"), [(None, None), (10.0, None), (None, 10.5)])
@pytest.mark.parametrize(("pairs", "soon"), [(16, True), (17, False), (500, False)])
def test_where_times_are_not_known_sixteen_pairs_end_it(ridden, since, time, pairs, soon):
    """As a repair takes, during which corners are not looked for."""
    after = after_coarse(with_corners(ridden[-1].state, pairs, since), time=time)
    assert after.corners is None
    assert after.tracked_pairs == (2 if soon else 4)  # looked for, and not seen again; or not asked


def test_until_the_rig_may_have_moved_nothing_is_asked(ridden):
    state = with_corners(ridden[-1].state, pairs=3)
    after = after_coarse(state)
    assert after.corners is state.corners
    assert after.tracked_pairs == 4


def test_corners_that_are_not_seen_again_are_looked_for_sooner(ridden):
    after = after_coarse(with_corners(ridden[-1].state))
    assert (after.corners, after.tracked_pairs) == (None, 2)


def test_what_lenses_leave_of_the_yaw_does_not_blur_each_window_by_itself(ridden):
    """It is in common to all of them, or many would be surer of it."""
    state = ridden[-1].state
    told = _moving.motion_measurement(yaw_alone(state, 1e6, 0.0), np.zeros(3))
    np.testing.assert_allclose(told.normal.a, yaw_alone(state, 1e6 / 9.0, 0.0).a)


def yaw_alone(state, information, yaw) -> Normal:
    """The likelihood of a yaw by depth, and of nothing else."""
    of_yaw = state.as_extrinsics[1]
    return Normal(information * np.outer(of_yaw, of_yaw), information * yaw * of_yaw, 0.0)


def told_yaw(state, degrees, sigma=0.02):
    """By a window whose own deviation is so much, wider than its tracks say by three."""
    told = yaw_alone(state, 9.0 * sigma**-2.0, state.as_extrinsics[1] @ state.estimate.theta + degrees)
    return _moving.motion_measurement(told, np.zeros(3))


def yaw_of(state: State) -> float:
    """By depth, as the filter has it."""
    return float(state.as_extrinsics[1] @ state.estimate.theta)


def test_a_boat_that_crosses_the_view_has_no_say(ridden):
    """Window after window, it tells a yaw of which rows know nothing."""
    state = ridden[-1].state
    for _ in range(6):
        state = _moving._after_window(state, told_yaw(ridden[-1].state, 0.7))
    assert yaw_of(state) == pytest.approx(yaw_of(ridden[-1].state))


def bent(yaw: float) -> State:
    """Rows of the view have shown so many degrees of yaw to a rig that was calibrated: it has made them lenses."""
    state = init(default_rig())
    near = consequences(state.chart, state.theta, (10, 30), state.view)
    rows = near.rows
    a = rows.T @ rows / 0.1**2
    seen = Measurement(Normal(a, yaw * a[1], 0.0), np.zeros(3))
    return state.replace(estimate=state.estimate.updated(seen), beside=state.beside.updated(seen))


def test_a_yaw_that_rows_took_for_lenses_is_believed_to_two_windows():
    state = bent(0.7)
    assert abs(yaw_of(state)) < 0.2
    told = told_yaw(state, 0.7 - yaw_of(state))
    once = _moving._after_window(state, told)
    assert yaw_of(once) == pytest.approx(yaw_of(state), abs=0.02)
    twice = _moving._after_window(once, told)
    assert yaw_of(twice) == pytest.approx(0.7, abs=0.1)


def test_a_filter_beside_knows_the_yaw_less_whatever_came(ridden):
    """By depth, until a knock makes any yaw likely."""
    state = ridden[3].state
    yaw, (one, other) = state.as_extrinsics[1], (state.estimate.of_theta, state.beside[0].of_theta)
    assert yaw @ other @ yaw > 2.0 * (yaw @ one @ yaw)
    for covariance in (one, other):
        spread = np.sqrt(np.diag(covariance))
        assert np.linalg.eigvalsh(covariance / np.outer(spread, spread)).min() > -1e-9
    assert np.array_equal(ridden[-1].state.standing_at(state.estimate).beside[0].mean, state.estimate.mean)


def test_two_windows_of_a_boat_are_not_believed_either():
    """Whatever is known of the lenses: theirs would be worse."""
    for yaw in (0.0, 0.3):
        start = after = bent(yaw)
        for _ in range(3):
            after = _moving._after_window(after, told_yaw(start, -0.7))
        assert yaw_of(after) == pytest.approx(yaw_of(start), abs=0.02)
        assert after.others > 0.9


def test_a_rolling_shutter_whose_times_are_not_known_tells_nothing(ridden):
    after = after_coarse(with_corners(ridden[-1].state), readout=0.02)
    assert (after.corners, after.tracked_pairs) == (None, 4)


def test_the_turn_of_a_window_is_that_of_one_pair(ride, ridden, monkeypatch):
    """A delay counts in frames, and corners are followed over several. A filter that is sure of another yaw waits for
    the next window, and keeps what this one told."""
    state, turn = with_corners(ridden[-1].state, pairs=4), (0.004, -0.008, 0.002)
    sure = standing_at(state, state.offset + np.eye(5)[1], 1e-4 * np.eye(5))
    monkeypatch.setattr(_moving, "corner_tracks", lambda before, pair: tracks_of(state.rig, turn=turn, noise=0.0))
    after = _moving.moved(state.standing_at(sure), ride.pairs[-1])
    np.testing.assert_allclose(after.outlier_motion.turn[:3], np.degrees(turn) / 4, rtol=0.02)


def test_what_a_window_tells_counts_from_the_first_calibration_also_after_a_switch(ride, ridden, monkeypatch):
    """Tracks of the rig in use, wherever that is, tell the yaw of that rig."""
    state = with_corners(ridden[-1].state.replace(using=np.array([0.1, 0.4, -0.2, 1.0, -2.0])), pairs=4)
    monkeypatch.setattr(_moving, "corner_tracks", lambda before, pair: tracks_of(state.rig, noise=0.0))
    told: list[Measurement] = []
    monkeypatch.setattr(_moving, "_after_window", lambda state, measured: told.append(measured) or state)
    _moving.moved(state, ride.pairs[-1])
    (normal,) = (one.normal for one in told)
    assert (normal.b - normal.a @ state.theta)[1] / normal.a[1, 1] == pytest.approx(0.0, abs=0.01)
