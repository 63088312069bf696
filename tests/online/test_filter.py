"""The recursive estimate, on measurements that are drawn."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import FilterEstimate, Measurement, at_start

from stereorecal.online import Config, init
from stereorecal.synthetic import default_rig

SIGMA = np.array([0.01, 0.1, 0.02, 0.5, 1.0])
PRIOR = np.ones(5)
STILL = Config(wander=(0.0, 0.0, 0.0), shift=0.0, heating=(0.0, 0.0, 0.0))


def measured(offset: np.ndarray, draw: np.random.Generator, turn: float = 0.0, late: float = 0.0):
    turned = np.array([0.0, turn, 0.0, 0.0, 0.0])
    noise = SIGMA * draw.standard_normal(5)
    return Measurement(offset + late * turned + noise, np.diag(SIGMA**-2.0), turned)


def fused(frames: int, offset: np.ndarray, draw: np.random.Generator, late: float = 0.0) -> FilterEstimate:
    estimate = at_start(PRIOR, STILL)
    for frame in range(frames):
        turn = float(np.sin(0.2 * frame))
        estimate = estimate.later(STILL).updated(measured(offset, draw, turn, late))
    return estimate


def test_intervals_hold():
    """Of 200 rigs, each looked at 20 times."""
    draw, inside = np.random.default_rng(0), []
    for _ in range(200):
        truth = PRIOR * draw.standard_normal(5)
        estimate = fused(20, truth, draw)
        inside.append(np.abs(estimate.offset - truth) < 1.96 * np.sqrt(np.diag(estimate.of_offset)))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)


def test_what_follows_the_motion_is_a_delay():
    """And leaves the yaw alone."""
    estimate = fused(60, np.zeros(5), np.random.default_rng(1), late=0.3)
    assert estimate.delay == pytest.approx(0.3, abs=0.06)
    assert abs(estimate.offset[1]) < 0.05


def test_shutters_that_open_at_once_leave_the_yaw_of_a_rig_that_turns_evenly():
    """Without a trigger it may as well be a delay, in all looks alike."""
    spread = {}
    for together in (True, False):
        config, draw = replace(STILL, synchronous=together), np.random.default_rng(1)
        estimate = at_start(PRIOR, config)
        for _ in range(30):
            estimate = estimate.later(config).updated(measured(np.zeros(5), draw, turn=0.5))
        spread[together] = float(np.sqrt(estimate.of_offset[1, 1]))
        assert bool(estimate.covariance[5, 5] == 0.0) is together
        assert (estimate.delay == 0.0) is together
    assert spread[True] < 0.1 * spread[False]


def test_false_alarms_are_as_rare_as_said():
    shaking = Config(wander=(0.001, 0.001, 0.001), shift=0.001, heating=(0.0, 0.0, 0.0))
    draw, estimate, rare = np.random.default_rng(2), at_start(PRIOR, shaking), []
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
        estimate = at_start(PRIOR, config)
        for frame, hot in enumerate(ramp):
            truth = np.array([2e-4, 8e-4, 2e-4, 0.0, 0.0]) * sides * hot
            estimate = estimate.later(config).updated(measured(truth, draw))
            if frame >= 50:
                far.append(np.abs(estimate.offset - truth)[:3])
                inside.append(far[-1] < 1.96 * np.sqrt(np.diag(estimate.of_offset))[:3])
    assert np.all(np.mean(far, axis=0) < [0.004, 0.03, 0.008])
    assert np.all(np.mean(inside, axis=0) > 0.9)


def test_a_turn_that_is_badly_known_says_less_while_a_shutter_is_late():
    """A tenth of a third of a degree of turn, times a delay of 0.3 frames: a hundredth of a degree."""
    late = fused(60, np.zeros(5), np.random.default_rng(1), late=0.3)
    look = Measurement(np.zeros(5), np.diag([1e6, 1e6, 1e6, 1.0, 1.0]), np.array([0.0, 1 / 3, 0.0, 0.0, 0.0]))
    spread = np.sqrt(np.diag(np.linalg.inv(late.doubted(look).information)))
    np.testing.assert_allclose(spread[:3], 0.01, rtol=0.3)
    np.testing.assert_allclose(spread[3:], 1.0)
    still = replace(look, turn=np.zeros(5))
    np.testing.assert_allclose(late.doubted(still).information, still.information)


@settings(max_examples=max(4, settings.default.max_examples // 3))
@given(st.integers(0, 10**6), st.lists(st.sampled_from(("dark", "look", "late", "knock")), min_size=5, max_size=40))
def test_a_covariance_stays_one(seed, events):
    """Whatever comes after whatever, with darkness of a thousand pairs in between."""
    draw, config = np.random.default_rng(seed), Config()
    estimate = at_start(PRIOR, config, keystone=0.3)
    for event in events:
        for _ in range(1000 if event == "dark" else 1):
            estimate = estimate.later(config)
        if event == "late":
            estimate = estimate.late()
        elif event == "knock":
            estimate = estimate.after_knock(PRIOR)
        elif event == "look":
            for _ in range(5):
                look = measured(np.zeros(5), draw, draw.uniform(0.5, 1.0), 0.3).weighed(0.125)
                estimate = estimate.updated(estimate.doubted(look))
        spread = np.sqrt(np.diag(estimate.covariance))
        assert np.linalg.eigvalsh(estimate.covariance / np.outer(spread, spread))[0] > -1e-9
        assert estimate.later(config).covariance[5, 5] <= 0.25 + 1e-9


def by_motion(yaw: float, draw: np.random.Generator, sigma: float = 0.03) -> Measurement:
    """What a window tells: the yaw, and nothing else."""
    offset, information = np.zeros(5), np.zeros((5, 5))
    offset[1], information[1, 1] = yaw + sigma * draw.standard_normal(), sigma**-2.0
    return Measurement(offset, information, np.zeros(5), keystone=False)


def test_a_keystone_of_the_lenses_is_no_yaw():
    """Rows show half a degree, depth none: rows alone leave it open, motion tells which."""
    draw = np.random.default_rng(4)
    bent = np.array([0.0, 0.5, 0.0, 0.0, 0.0])
    rows = at_start(np.array([1.0, 0.05, 1.0, 1.0, 1.0]), STILL, keystone=0.3)
    for _ in range(40):
        rows = rows.later(STILL).updated(measured(bent, draw))
    assert abs(rows.offset[1]) < 0.1 < 0.4 < rows.keystone
    told = rows
    for _ in range(40, 80):
        told = told.later(STILL).updated(by_motion(0.0, draw)).updated(measured(bent, draw))
    assert abs(told.offset[1]) < 0.02
    assert told.of_offset[1, 1] > 0.01**2
    assert told.keystone == pytest.approx(0.5, abs=0.05)
    assert told.of_offset[1, 1] < rows.of_offset[1, 1]


def test_what_the_lenses_leave_of_the_yaw_does_not_average_away():
    """However many windows there are: 0.02 degrees stay in doubt, once; of exact intrinsics nothing."""
    draw = np.random.default_rng(8)
    for config, least in ((STILL, 0.02), (replace(STILL, prior="exact"), 0.0)):
        estimate = at_start(PRIOR, config)
        for _ in range(400):
            estimate = estimate.later(config).updated(by_motion(0.0, draw))
        spread = float(np.sqrt(estimate.of_offset[1, 1]))
        assert spread == pytest.approx(np.hypot(least, 0.03 / np.sqrt(400)), rel=0.02)


@pytest.mark.parametrize(("step", "faster"), [(0.0, False), (0.006, True)])
def test_how_fast_a_rig_drifts_is_learnt(step, faster):
    draw, config, truth = np.random.default_rng(7), Config(), np.zeros(5)
    state = init(default_rig(), config)
    for _ in range(80):
        truth[:3] += step * draw.standard_normal(3)
        state = state.later().measured(measured(truth, draw))
    learnt = state.pace.config(config)
    assert (learnt.wander[0] > 5.0 * config.wander[0]) is faster
    again = state.standing_at(at_start(PRIOR, config))
    assert again.pace.config(config) == learnt  # a knock says nothing of it
    wider = again.later().estimate.covariance[0, 0] - again.estimate.covariance[0, 0]
    assert wider == pytest.approx(config.heating[0] ** 2 + learnt.wander[0] ** 2, rel=1e-6)
