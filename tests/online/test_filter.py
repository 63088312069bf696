"""The recursive estimate and the trial, on measurements that are drawn."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import FilterEstimate, Measurement, SequentialTest, at_start as at_start_of, trial as new_trial

from stereorecal.estimation import Normal, consequences, rig_parameters
from stereorecal.online import Config, init
from stereorecal.synthetic import default_rig

SIGMA = np.array([0.01, 0.1, 0.02, 0.5, 1.0])
PRIOR = np.ones(5)
# Of exact intrinsics, unless a test is about what a calibration leaves.
EXACT = Config(prior="exact")
STILL = replace(EXACT, wander=(0.0, 0.0, 0.0), shift=0.0, heating=(0.0, 0.0, 0.0))
CHART = rig_parameters(default_rig())


def at_start(config: Config) -> FilterEstimate:
    return at_start_of(CHART, config)


def of_extrinsics(values: np.ndarray) -> np.ndarray:
    """θ that changes nothing else."""
    return np.concatenate([values, np.zeros(CHART.dim - len(values))])


def shown(frame: int, offset: np.ndarray, information: np.ndarray, turn: np.ndarray) -> Measurement:
    """What is measured of the extrinsics."""
    a = np.zeros((CHART.dim, CHART.dim))
    a[:5, :5] = information
    return Measurement.of(frame, Normal(a, a @ of_extrinsics(offset), 0.0), of_extrinsics(turn))


def measured(frame: int, offset: np.ndarray, draw: np.random.Generator, turn: float = 0.0, late: float = 0.0):
    turned = np.array([0.0, turn, 0.0, 0.0, 0.0])
    noise = SIGMA * draw.standard_normal(5)
    return shown(frame, offset + late * turned + noise, np.diag(SIGMA**-2.0), turned)


def fused(frames: int, offset: np.ndarray, draw: np.random.Generator, late: float = 0.0) -> FilterEstimate:
    estimate = at_start(STILL)
    for frame in range(frames):
        turn = float(np.sin(0.2 * frame))
        estimate = estimate.later(STILL).updated(measured(frame, offset, draw, turn, late))
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
        estimate = at_start(config)
        for frame in range(30):
            estimate = estimate.later(config).updated(measured(frame, np.zeros(5), draw, turn=0.5))
        spread[together] = float(np.sqrt(estimate.of_offset[1, 1]))
        assert bool(estimate.covariance[5, 5] == 0.0) is together
        assert (estimate.delay == 0.0) is together
    assert spread[True] < 0.1 * spread[False]


def test_what_is_said_of_the_shutters_may_change():
    """As by a state that is gone on with: what was known of a delay is then as at a start."""
    draw = np.random.default_rng(1)
    late = fused(60, np.zeros(5), draw, late=0.3)
    triggered = late.of_shutters(True)
    assert triggered.delay == 0.0
    assert not triggered.covariance[5].any()
    np.testing.assert_allclose(triggered.offset, late.offset)
    free = triggered.of_shutters(False)
    assert free.covariance[5, 5] == pytest.approx(at_start(STILL).covariance[5, 5])
    for frame in range(60):
        free = free.later(STILL).updated(measured(frame, np.zeros(5), draw, float(np.sin(0.2 * frame)), 0.3))
    assert free.delay == pytest.approx(0.3, abs=0.06)


def test_of_cameras_with_a_trigger_a_shift_is_no_travel():
    """Of others, what the rig travels during a delay poses as a shift in all looks alike."""
    looks = [measured(frame, np.array([0, 0, 0, 2.0, 0]), np.random.default_rng(frame)) for frame in range(20)]
    evidence = {}
    for together in (True, False):
        trial = on_trial(np.array([0, 0, 0, 2.0, 0]), "repair", -1, together)
        for look in looks:
            trial = trial.moved(look)
        evidence[together] = trial.evidence
    assert evidence[True] > 10.0 * evidence[False]


def test_false_alarms_are_as_rare_as_said():
    shaking = replace(EXACT, wander=(0.001, 0.001, 0.001), shift=0.001, heating=(0.0, 0.0, 0.0))
    draw, estimate, rare = np.random.default_rng(2), at_start(shaking), []
    for frame in range(3000):
        look = measured(frame, np.zeros(5), draw)
        estimate = estimate.later(shaking)
        rare.append(estimate.chance_of(look) < 0.01)
        estimate = estimate.updated(look)
    assert np.mean(rare) == pytest.approx(0.01, abs=0.005)


def test_heat_is_followed_and_the_intervals_know_it():
    """Bars that bend one way for 300 pairs, then back: the mean error stays small, the truth within its interval."""
    draw, config, far, inside = np.random.default_rng(6), EXACT, [], []
    ramp = np.concatenate([np.arange(300), np.arange(300)[::-1]])
    for sides in np.sign(draw.uniform(-1.0, 1.0, (6, 5))):
        estimate = at_start(config)
        for frame, hot in enumerate(ramp):
            truth = np.array([2e-4, 8e-4, 2e-4, 0.0, 0.0]) * sides * hot
            estimate = estimate.later(config).updated(measured(frame, truth, draw))
            if frame >= 50:
                far.append(np.abs(estimate.offset - truth)[:3])
                inside.append(far[-1] < 1.96 * np.sqrt(np.diag(estimate.of_offset))[:3])
    assert np.all(np.mean(far, axis=0) < [0.004, 0.03, 0.008])
    assert np.all(np.mean(inside, axis=0) > 0.9)


def test_a_turn_that_is_badly_known_says_less_while_a_shutter_is_late():
    """A tenth of a third of a degree of turn, times a delay of 0.3 frames: a hundredth of a degree."""
    late = fused(60, np.zeros(5), np.random.default_rng(1), late=0.3)
    information = np.diag([1e6, 1e6, 1e6, 1.0, 1.0])
    look = shown(0, np.zeros(5), information, np.array([0.0, 1 / 3, 0.0, 0.0, 0.0]))
    spread = np.sqrt(np.diag(np.linalg.inv(late.doubted(look).normal.a[:5, :5])))
    np.testing.assert_allclose(spread[:3], 0.01, rtol=0.3)
    np.testing.assert_allclose(spread[3:], 1.0)
    still = replace(look, way=np.zeros(CHART.dim))
    assert late.doubted(still) is still


@settings(max_examples=max(4, settings.default.max_examples // 3))
@given(st.integers(0, 10**6), st.lists(st.sampled_from(("dark", "look", "late", "knock")), min_size=5, max_size=40))
def test_a_covariance_stays_one(seed, events):
    """Whatever comes after whatever, with darkness of a thousand pairs in between."""
    draw, config = np.random.default_rng(seed), Config()
    estimate = at_start(config)
    for frame, event in enumerate(events):
        for _ in range(1000 if event == "dark" else 1):
            estimate = estimate.later(config)
        if event == "late":
            estimate = estimate.late()
        elif event == "knock":
            estimate = estimate.after_knock()
        elif event == "look":
            for _ in range(5):
                look = measured(frame, np.zeros(5), draw, draw.uniform(0.5, 1.0), 0.3).weighed(0.125)
                estimate = estimate.updated(estimate.doubted(look))
        spread = np.sqrt(np.maximum(np.diag(estimate.covariance), 1e-30))
        assert np.linalg.eigvalsh(estimate.covariance / np.outer(spread, spread))[0] > -1e-9
        assert estimate.later(config).covariance[5, 5] <= 0.25 + 1e-9


def test_a_look_that_says_nothing_changes_nothing():
    estimate = at_start(STILL)
    nothing = shown(0, np.full(5, 9.0), np.zeros((5, 5)), np.zeros(5))
    np.testing.assert_allclose(estimate.updated(nothing).mean, estimate.mean, atol=1e-12)
    assert estimate.chance_of(nothing) == 1.0


def on_trial(offset: np.ndarray, by: str = "looks", since: int = 0, synchronous: bool = False) -> SequentialTest:
    """Against the rig that was given, whose intrinsics are exact."""
    return new_trial(
        offset, np.zeros(5), by, since, at_start(STILL).moved(offset, 1e-6 * np.eye(5)), synchronous=synchronous
    )


def trial_over(looks: int, truth: np.ndarray, candidate: np.ndarray, draw: np.random.Generator) -> SequentialTest:
    trial = on_trial(candidate)
    for frame in range(looks):
        trial = trial.measured(measured(frame, truth, draw), 0.2, 0.2)
        if trial.won(1e-3) or trial.lost:
            break
    return trial


def test_a_trial_is_won_by_what_is_better():
    draw, truth = np.random.default_rng(3), np.array([0.05, 0.0, 0.0, 0.0, 0.0])
    assert all(trial_over(60, truth, truth, draw).won(1e-3) for _ in range(100))
    assert not any(trial_over(60, np.zeros(5), truth, draw).won(1e-3) for _ in range(1000))


def test_a_trial_is_not_won_by_one_look_nor_by_worse_rows():
    trial = on_trial(np.ones(5))
    look = shown(1, np.ones(5), 1e6 * np.eye(5), np.zeros(5))
    assert not trial.measured(look, 1.0, 0.1).won(1e-3)
    for _ in range(10):
        trial = trial.measured(look, 0.1, 0.2)
    assert not trial.won(1e-3)


@pytest.mark.parametrize("late", [True, False])
def test_an_even_turn_is_no_proof_however_long(late):
    """A shutter that is late by 0.2 frames on a rig that turns evenly looks like a yaw in every look. A rig that is
    off by that yaw shows it when it no longer turns."""
    draw, yaw = np.random.default_rng(4), np.array([0.0, 0.2, 0.0, 0.0, 0.0])
    trial, won = on_trial(yaw), []
    for frame in range(50):
        turn = 1.0 if frame < 40 else 0.0  # degrees a frame
        look = measured(frame, 0.0 * yaw if late else yaw, draw, turn, 0.2 if late else 0.0)
        trial = trial.measured(look, 0.2, 0.2)
        won.append(trial.won(1e-3))
    assert not any(won[:40])
    assert won[-1] is not late


def test_one_look_counts_for_so_much_and_no_more():
    """Whatever the rig's turn would explain of it."""
    draw = np.random.default_rng(5)
    for _ in range(200):
        trial = on_trial(np.append(0.0, [draw.uniform(-0.3, 0.3), 0.0, 0.0, 0.0]))
        for frame in range(6):
            sharp = measured(frame, draw.uniform(-0.5, 0.5, 5), draw, draw.uniform(-1.0, 1.0)).weighed(25.0)
            after = trial.measured(sharp, 0.2, 0.2)
            assert abs(after.evidence - trial.evidence) <= 4.0 + 1e-9
            trial = after


# --- what a calibration leaves --------------------------------------------------------------------------------


LEFT_SOMETHING = replace(STILL, prior="default")
SLOPES = consequences(CHART, np.zeros(CHART.dim), (10, 30))
ROWS, DEPTH = SLOPES.rows[0], SLOPES.mean_nearness[1] / SLOPES.mean_nearness[1, 1]


def by_rows(theta: np.ndarray, draw: np.random.Generator, pixels: float = 0.05) -> Measurement:
    """A look at a rig: rows of points over the view, each off by so much."""
    rows = ROWS @ theta + pixels * draw.standard_normal(len(ROWS))
    return Measurement.of(0, Normal(ROWS.T @ ROWS / pixels**2, ROWS.T @ rows / pixels**2, 0.0), np.zeros(CHART.dim))


def by_motion(yaw: float, draw: np.random.Generator, sigma: float = 0.03) -> Measurement:
    """A window: the yaw that depth shows, and nothing else."""
    told = yaw + sigma * draw.standard_normal()
    normal = Normal(np.outer(DEPTH, DEPTH) / sigma**2, DEPTH * told / sigma**2, 0.0)
    return Measurement.of(0, normal, np.zeros(CHART.dim))


def left_of_depth(estimate: FilterEstimate) -> float:
    """Standard deviation of the yaw that depth shows."""
    return float(np.sqrt(DEPTH @ estimate.of_theta @ DEPTH))


def test_a_calibration_leaves_less_of_depth_than_of_a_yaw():
    """Boards tie principal points, and a yaw with them, to where they stand."""
    start = at_start(replace(Config(), prior="default"))
    assert 0.01 < left_of_depth(start) < 0.1 < np.sqrt(start.of_theta[1, 1])
    assert left_of_depth(at_start(STILL)) == pytest.approx(1.0, abs=1e-3)  # that a rig has turned, nothing else shows


def test_rows_alone_do_not_tell_depth_and_motion_does():
    draw, theta = np.random.default_rng(4), at_start(LEFT_SOMETHING).theta
    rows = at_start(LEFT_SOMETHING)
    before = left_of_depth(rows)
    for _ in range(5):
        rows = rows.updated(by_rows(theta, draw))
    assert left_of_depth(rows) > 0.3 * before
    told = rows
    for _ in range(40):
        told = told.updated(by_motion(0.0, draw))
    assert left_of_depth(told) < 0.01


def test_a_yaw_that_comes_later_is_the_rigs():
    """What the calibration left is constant."""
    draw, walking = np.random.default_rng(5), Config(wander=(0.01, 0.02, 0.01), heating=(0.0, 0.0, 0.0))
    estimate, truth = at_start(Config()), np.zeros(CHART.dim)
    for _ in range(20):
        estimate = estimate.later(LEFT_SOMETHING).updated(by_rows(truth, draw))
    for _ in range(100):
        truth[1] += 0.003
        estimate = estimate.later(walking).updated(by_rows(truth, draw))
    assert estimate.offset[1] == pytest.approx(0.3, abs=0.08)


def test_a_yaw_from_before_the_start_is_put_down_to_the_calibration_unless_it_is_asked_for():
    """As if it had been thought possible from the start."""
    draw, truth = np.random.default_rng(6), of_extrinsics(np.array([0.0, 0.4, 0.0, 0.0, 0.0]))
    looks = [by_rows(truth, draw, 0.3) for _ in range(5)]
    tight = wide = at_start(LEFT_SOMETHING)
    wide = wide.turned(1.0)
    for seen in looks:
        tight, wide = tight.updated(seen), wide.updated(seen)
    again = tight.turned_before()
    assert tight.offset[1] < 0.01 < 0.1 < again.offset[1]
    turned = [one.updated(by_motion(0.4, draw)) for one in (again, wide)]  # which tells how much of it there was
    np.testing.assert_allclose(turned[0].offset[1], turned[1].offset[1], atol=0.1)
    for rows in (ROWS @ (one.theta - truth) for one in turned):
        assert np.sqrt(np.mean(rows**2)) < 0.2


@pytest.mark.parametrize("wrong", [0.0, 2.0])
def test_how_good_the_calibration_was_is_learnt(wrong):
    """Rigs of exact intrinsics, and ones that are off by two standard deviations of the widest prior everywhere."""
    draw, start = np.random.default_rng(7), at_start(LEFT_SOMETHING)
    truth = wrong * np.linalg.cholesky(start.covariance[9:, 9:] + 1e-18 * np.eye(CHART.dim)) @ np.ones(CHART.dim)
    state = init(default_rig(), LEFT_SOMETHING)
    for _ in range(5):
        state = state.measured(by_rows(truth, draw))
    chosen = state.with_likelier_prior()
    spread, before = (np.diag(one.estimate.covariance)[9:] for one in (chosen, state))
    assert bool((spread < before).all()) is (wrong == 0.0)
    assert chosen.with_likelier_prior().prior == chosen.prior


@pytest.mark.parametrize(("step", "faster"), [(0.0, False), (0.006, True)])
def test_how_fast_a_rig_drifts_is_learnt(step, faster):
    draw, config, truth = np.random.default_rng(7), EXACT, np.zeros(5)
    state = init(default_rig(), config)
    for frame in range(80):
        truth[:3] += step * draw.standard_normal(3)
        state = state.later().measured(measured(frame, truth, draw))
    learnt = state.pace.config(config)
    assert (learnt.wander[0] > 5.0 * config.wander[0]) is faster
    again = state.standing_at(at_start(config))
    assert again.pace.config(config) == learnt  # a knock says nothing of it
    wider = again.later().estimate.covariance[0, 0] - again.estimate.covariance[0, 0]
    assert wider == pytest.approx(config.heating[0] ** 2 + learnt.wander[0] ** 2, rel=1e-6)


def test_heat_is_as_likely_after_an_hour_as_at_first():
    """Rates are forgotten as fast as new ones come."""
    config = EXACT
    start = after = at_start(config)
    for _ in range(2000):
        after = after.later(config)
    rates = slice(6, 9)
    np.testing.assert_allclose(np.diag(after.covariance)[rates], np.diag(start.covariance)[rates], rtol=1e-9)
