"""The recursive estimate, on measurements that are drawn."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import DRIFT, FilterEstimate, Measurement, at_start

from stereorecal.estimation import Normal
from stereorecal.online import Config, init
from stereorecal.synthetic import default_rig

SIGMA = np.array([0.01, 0.1, 0.02, 0.5, 1.0])
STILL = Config(wander=(0.0, 0.0, 0.0), shift=0.0, heating=(0.0, 0.0, 0.0))


def measured(offset: np.ndarray, draw: np.random.Generator, turn: float = 0.0, late: float = 0.0):
    seen = offset + late * turn * np.eye(5)[1] + SIGMA * draw.standard_normal(5)
    return Measurement(likelihood(seen, np.diag(SIGMA**-2.0)), turn * np.eye(3)[1])


def likelihood(theta: np.ndarray, information: np.ndarray) -> Normal:
    """The likelihood by what was measured, and how well."""
    return Normal(information, information @ theta, 0.0)


def start(config: Config, theta: int = 5) -> FilterEstimate:
    """A rig of which nothing is known, of so many parameters."""
    return at_start(np.eye(theta), config)


def fused(frames: int, offset: np.ndarray, draw: np.random.Generator, late: float = 0.0) -> FilterEstimate:
    estimate = start(STILL)
    for frame in range(frames):
        turn = float(np.sin(0.2 * frame))
        estimate = estimate.later(STILL).updated(measured(offset, draw, turn, late))
    return estimate


def test_intervals_hold():
    """95 % of all intervals hold the truth, of 200 rigs that are each looked at 20 times."""
    draw, inside = np.random.default_rng(0), []
    for _ in range(200):
        truth = draw.standard_normal(5)
        estimate = fused(20, truth, draw)
        inside.append(np.abs(estimate.theta - truth) < 1.96 * np.sqrt(np.diag(estimate.of_theta)))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)


def test_what_follows_the_motion_is_a_delay():
    """And leaves the yaw alone."""
    estimate = fused(60, np.zeros(5), np.random.default_rng(1), late=0.3)
    assert estimate.delay == pytest.approx(0.3, abs=0.06)
    assert abs(estimate.theta[1]) < 0.05


def test_shutters_that_open_at_once_leave_the_yaw_of_a_rig_that_turns_evenly():
    """Without a trigger it may as well be a delay, in all looks alike."""
    spread = {}
    for together in (True, False):
        config, draw = replace(STILL, synchronous=together), np.random.default_rng(1)
        estimate = start(config)
        for _ in range(30):
            estimate = estimate.later(config).updated(measured(np.zeros(5), draw, turn=0.5))
        spread[together] = float(np.sqrt(estimate.of_theta[1, 1]))
        assert bool(estimate.of_delay == 0.0) is together
        assert (estimate.delay == 0.0) is together
    assert spread[True] < 0.1 * spread[False]


def test_false_alarms_are_as_rare_as_said():
    shaking = Config(wander=(0.001, 0.001, 0.001), shift=0.001, heating=(0.0, 0.0, 0.0))
    draw, estimate, rare = np.random.default_rng(2), start(shaking), []
    for _ in range(3000):
        look = measured(np.zeros(5), draw)
        estimate = estimate.later(shaking)
        rare.append(estimate.chance_of(look) < 0.01)
        estimate = estimate.updated(look)
    assert np.mean(rare) == pytest.approx(0.01, abs=0.005)


def test_heat_is_followed_and_the_intervals_know_it():
    """Bars that bend one way for 300 pairs, then back: the mean error stays small, the truth within its interval."""
    draw, config, far, inside = np.random.default_rng(6), Config(), [], []
    ramp = np.concatenate([np.arange(300), np.arange(300)[::-1]])
    for sides in np.sign(draw.uniform(-1.0, 1.0, (6, 5))):
        estimate = start(config)
        for frame, hot in enumerate(ramp):
            truth = np.array([2e-4, 8e-4, 2e-4, 0.0, 0.0]) * sides * hot
            estimate = estimate.later(config).updated(measured(truth, draw))
            if frame >= 50:
                far.append(np.abs(estimate.theta - truth)[:3])
                inside.append(far[-1] < 1.96 * np.sqrt(np.diag(estimate.of_theta))[:3])
    assert np.all(np.mean(far, axis=0) < [0.004, 0.03, 0.008])
    assert np.all(np.mean(inside, axis=0) > 0.9)


def test_a_turn_that_is_badly_known_says_less_while_a_shutter_is_late():
    """A tenth of a third of a degree of turn, times a delay of 0.3 frames: a hundredth of a degree."""
    late = at_start(1e6 * np.eye(5), replace(STILL, synchronous=True)).moved(np.array([0.3]), np.zeros((1, 1)), 5)
    information, turn = np.diag([1e6, 1e6, 1e6, 1.0, 1.0]), np.array([0.0, 1 / 3, 0.0])
    look = Measurement(likelihood(np.ones(5) + 0.3 * np.pad(turn, (0, 2)), information), turn)
    after = late.updated(look)
    np.testing.assert_allclose(np.sqrt(np.diag(after.of_theta)), [0.01, 0.01, 0.01, 1.0, 1.0], rtol=0.02)
    np.testing.assert_allclose(after.theta, np.ones(5), atol=1e-5)  # nor is it another rig
    for still in (np.zeros(3), None):
        sure = late.updated(replace(look, turn=still)).of_theta
        np.testing.assert_allclose(sure, np.linalg.inv(information), rtol=1e-4, atol=1e-9)


@settings(max_examples=max(4, settings.default.max_examples // 3))
@given(st.integers(0, 10**6), st.lists(st.sampled_from(("dark", "look", "late", "knock")), min_size=5, max_size=40))
def test_a_covariance_stays_one(seed, events):
    """Whatever comes after whatever, with darkness of a thousand pairs in between."""
    draw, config = np.random.default_rng(seed), Config()
    estimate = start(config)
    for event in events:
        for _ in range(1000 if event == "dark" else 1):
            estimate = estimate.later(config)
        if event == "late":
            estimate = estimate.late()
        elif event == "knock":
            estimate = estimate.widened(DRIFT)
        elif event == "look":
            for _ in range(5):
                estimate = estimate.updated(measured(np.zeros(5), draw, draw.uniform(0.5, 1.0), 0.3), 8)
        spread = np.sqrt(np.diag(estimate.covariance))
        assert np.linalg.eigvalsh(estimate.covariance / np.outer(spread, spread))[0] > -1e-9
        assert estimate.later(config).of_delay <= 0.25 + 1e-9


BENT = np.column_stack([np.eye(5), np.eye(5)[1]])  # rows of a rig whose lenses bend them as a yaw does


def by_motion(yaw: float, draw: np.random.Generator, sigma: float = 0.03) -> Measurement:
    """What a window tells: the yaw, and nothing else."""
    information = np.diag([0.0, sigma**-2.0, 0.0, 0.0, 0.0, 0.0])
    return Measurement(likelihood((yaw + sigma * draw.standard_normal()) * np.eye(6)[1], information), np.zeros(3))


def by_rows(offset: np.ndarray, draw: np.random.Generator) -> Measurement:
    """What rows tell of a yaw and lenses: the sum."""
    seen = measured(offset, draw).normal
    return Measurement(seen.of_parameters(BENT), np.zeros(3))


def test_rows_that_lenses_bend_are_no_yaw():
    """Rows show half a degree, depth none: rows alone leave it open, motion tells which."""
    draw, half = np.random.default_rng(4), 0.5 * np.eye(5)[1]
    rows = at_start(np.diag(np.square([1.0, 0.05, 1.0, 1.0, 1.0, 0.3])), STILL)
    for _ in range(40):
        rows = rows.later(STILL).updated(by_rows(half, draw))
    assert abs(rows.theta[1]) < 0.1 < 0.4 < rows.theta[5]
    told = rows
    for _ in range(40, 80):
        told = told.later(STILL).updated(by_motion(0.0, draw)).updated(by_rows(half, draw))
    assert abs(told.theta[1]) < 0.02
    assert told.theta[5] == pytest.approx(0.5, abs=0.05)
    assert told.of_theta[1, 1] < rows.of_theta[1, 1]


def test_a_look_that_says_nothing_new_of_lenses_moves_extrinsics_as_all_would():
    """Rows that lenses bend as a yaw: the sum is told as before, the lenses keep what was known."""
    draw, like = np.random.default_rng(5), np.column_stack([np.eye(5), np.eye(5)[1]])
    before = at_start(np.diag(np.square([1.0, 0.1, 1.0, 1.0, 1.0, 0.3])), STILL)
    for _ in range(20):
        before = before.later(STILL).updated(by_rows(np.zeros(5), draw))
    look = by_rows(0.2 * np.eye(5)[0], draw)
    free, held = (before.updated(replace(look, as_extrinsics=one)) for one in (None, like))
    np.testing.assert_allclose(like @ held.theta, like @ free.theta, atol=1e-12)
    np.testing.assert_allclose(like @ held.of_theta @ like.T, like @ free.of_theta @ like.T, atol=1e-12)
    assert held.theta[5] == before.theta[5] != free.theta[5]
    assert held.of_theta[5, 5] == pytest.approx(before.of_theta[5, 5])


@pytest.mark.parametrize("late", [0.0, 0.3])
def test_how_likely_a_measurement_is_does_not_reward_a_delay(late):
    """That was expected just so, by a filter that is as sure of a delay as of none."""
    estimate = at_start(1e-6 * np.eye(5), replace(STILL, synchronous=True))
    mean, turn = estimate.mean.copy(), np.array([0.0, 1.0, 0.0])
    mean[-4] = late
    expected = Measurement(likelihood(np.pad(late * turn, (0, 2)), np.diag(SIGMA**-2.0)), turn)
    without = Measurement(likelihood(np.zeros(5), np.diag(SIGMA**-2.0)), np.zeros(3))
    likelihoods = replace(estimate, mean=mean).log_likelihood(expected), estimate.log_likelihood(without)
    assert likelihoods[0] <= likelihoods[1] + 1e-9


@pytest.mark.parametrize(("step", "faster"), [(0.0, False), (0.006, True)])
def test_how_fast_a_rig_drifts_is_learnt(step, faster):
    draw, config, truth = np.random.default_rng(7), Config(), np.zeros(5)
    state = init(default_rig(), config)
    state = state.standing_at(start(config))
    for _ in range(80):
        truth[:3] += step * draw.standard_normal(3)
        state = state.later().measured(measured(truth, draw))
    assert bool(state.pace[0] > 5.0) is faster
    again = state.standing_at(start(config))
    assert np.array_equal(again.pace, state.pace)  # a knock says nothing of it
    wider = again.later().estimate.covariance[0, 0] - again.estimate.covariance[0, 0]
    assert wider == pytest.approx(config.heating[0] ** 2 + (state.pace[0] * config.wander[0]) ** 2, rel=1e-6)
