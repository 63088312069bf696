"""What is known of a rig that was repaired: it comes back from a file as it was, and counts once."""

import json

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import stereorecal as sr
from stereorecal.estimation import (
    Mixture,
    SavedPrior,
    as_prior,
    estimate,
    points_of_view,
    readings,
    recentred_posterior,
    rig_parameters,
)
from stereorecal.objectives import EXTRINSICS


def mixture(chart, seed: int, components: int = 2) -> Mixture:
    """With a parameter that is held."""
    rng, scale = np.random.default_rng(seed), np.ones(chart.dim)
    scale[-1] = 0.0
    roots = rng.normal(0, 1, (components, chart.dim, chart.dim)) * scale[:, None]
    weights = rng.uniform(0.1, 1.0, components)
    covariances = roots @ roots.swapaxes(1, 2)
    covariances = 0.5 * (covariances + covariances.swapaxes(1, 2))
    return Mixture(weights / weights.sum(), rng.normal(0, 1, (components, chart.dim)), covariances)


def same_prior(one, other) -> bool:
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("covariances", "weights", "means")]
    return all(np.array_equal(*pair) for pair in pairs)


def saved(seen, rig, *images: str, earlier: SavedPrior | None = None) -> SavedPrior:
    """After an estimate whose candidate has other extrinsics alone."""
    return SavedPrior(rig, recentred_posterior(seen.posterior, seen.chart.coordinates_of(rig)), images, earlier)


def repaired(seen) -> sr.StereoRig:
    return seen.chart.rig_at(seen.with_free(EXTRINSICS))


def sigmas(seen) -> np.ndarray:
    return np.sqrt(np.diag(seen.posterior.covariance))


# --- as data --------------------------------------------------------------------------------------------------


@settings(max_examples=10)
@given(
    seed=st.integers(0, 999),
    images=st.lists(st.text("0123456789abcdef", min_size=16, max_size=16), max_size=4).map(tuple),
    before=st.sampled_from(["default", None, "mixture"]),
)
def test_it_comes_back_as_it_was(rig, chart, seed, images, before):
    prior = mixture(chart, seed + 1, 3) if before == "mixture" else before
    one = SavedPrior(rig, mixture(chart, seed), images, SavedPrior(rig, prior, images[:1]))
    again = SavedPrior.from_dict(json.loads(json.dumps(one.as_dict(), allow_nan=False)))
    assert again.as_dict() == one.as_dict()
    np.testing.assert_array_equal(again.rig.extrinsics, rig.extrinsics)
    assert same_prior(as_prior(again, chart), as_prior(one, chart))
    assert same_prior(as_prior(again.earlier, chart), as_prior(one.earlier, chart))


def test_nothing_known_comes_back_as_nothing_known(rig):
    again = SavedPrior.from_dict(json.loads(json.dumps(SavedPrior(rig, None).as_dict())))
    assert (again.known, again.images, again.earlier) == (None, (), None)


def damaged(content: dict, where: str, value) -> dict:
    content = json.loads(json.dumps(content))
    *keys, last = where.split(".")
    place = content
    for key in keys:
        place = place[int(key) if key.isdigit() else key]
    place[int(last) if last.isdigit() else last] = value
    return content


DAMAGED = {
    "schema": ["stereorecal.prior/9"],
    "rig": [None],
    "rig.left.size": ["wide"],
    "rig.extrinsics": [[1.0]],
    "names": [["yaw"]],
    "components": [[]],
    "components.0.weight": [-1.0, 0.7],
    "components.0.mean": [[0.0]],
    "components.0.covariance": [[[1.0]]],
    "components.0.covariance.0": [[-1.0]],
    "components.0.covariance.1.0": [1e9],
    "components.0.covariance.3": [None],
    "images": ["0123", [1]],
    "earlier": [{}, 3],
    "earlier.components": ["exact", [], 1.0],
    "earlier.images": ["0123", [1]],
}


@pytest.mark.parametrize(("where", "value"), [(where, one) for where, several in DAMAGED.items() for one in several])
def test_what_is_damaged_is_refused_in_a_sentence(rig, chart, where, value):
    whole = SavedPrior(rig, mixture(chart, 0, 1), ("00",), SavedPrior(rig, "default")).as_dict()
    SavedPrior.from_dict(damaged(whole, "units", 1))  # those are for people
    with pytest.raises(sr.InputError, match="no prior that stereorecal has written, or it is damaged") as error:
        SavedPrior.from_dict(damaged(whole, where, value))
    assert "\n" not in str(error.value)
    assert "Error(" not in str(error.value)


@pytest.mark.parametrize("content", [None, [], "prior", {}, {"schema": "stereorecal.solution/1"}])
def test_something_else_is_refused(content):
    with pytest.raises(sr.InputError, match="no prior that stereorecal has written"):
        SavedPrior.from_dict(content)


# --- as a prior -----------------------------------------------------------------------------------------------


def test_it_belongs_to_its_rig(rig, chart, seen):
    found = estimate(seen(rig, rig), rig)
    prior, other = saved(found, rig), rig.with_extrinsics(rig.extrinsics + 1e-6)
    with pytest.raises(sr.InputError, match="another rig"):
        estimate(seen(other, other), other, prior)
    assert same_prior(as_prior(prior, chart), as_prior(prior, rig_parameters(rig.with_extrinsics(rig.extrinsics))))


def test_what_is_known_does_not_change_with_the_rig_that_it_is_counted_from(rig, chart):
    """Probable rigs are the same rigs."""
    used = np.r_[0.2, -0.3, 0.1, 0.5, -0.2, np.zeros(chart.dim - 5)]
    new = chart.rig_at(used)
    before = as_prior("default", chart)
    after = as_prior(SavedPrior(rig, "default").counted_from(new), rig_parameters(new))
    theta = 0.5 * before.roots[3][:, 0] + before.means[3]
    there = rig_parameters(new).rig_at(theta - before.means[3] + after.means[3])
    points = points_of_view(rig, 10)
    rows, nearness = readings(there, chart.rig_at(theta), points)
    assert np.abs(rows).max() < 1e-3
    assert np.abs(nearness).max() < 1e-4
    known = recentred_posterior(before, used)
    np.testing.assert_allclose(known.means[0] + used, before.weights @ before.means, atol=1e-12)


def test_a_covariance_may_have_a_mean_which_is_where_nothing_is_seen(rig, chart, seen):
    names, mean = ("left.cx", "yaw"), np.array([1.5, -0.2])
    blind = seen(rig, rig)
    blind = sr.Correspondences(**{**vars(blind), "weight": 0.0 * blind.weight})
    found = estimate(blind, rig, sr.CalibrationCovariance(names, np.diag([4.0, 0.01]), mean))
    where = [chart.names.index(name) for name in names]
    np.testing.assert_allclose(found.theta[where], mean)
    assert sigmas(found)[where[0]] == pytest.approx(2.0)
    assert np.count_nonzero(found.theta) == 2
    with pytest.raises(sr.InputError, match="mean"):
        sr.CalibrationCovariance(names, np.diag([4.0, 0.01]), np.array([1.0, np.nan]))


# --- twice ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def two_looks(rig, chart, prior, seen):
    """Four rigs drawn from the prior, drifted; repaired; and looked at again, by other images and by the same."""
    looks = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        drift = np.r_[rng.uniform(-0.4, 0.4, 5) * [1, 1, 1, 0.5, 0.5], np.zeros(chart.dim - 5)]
        true = chart.rig_at(prior.roots[1] @ rng.normal(0, 1, chart.dim) + drift)
        first = estimate(seen(rig, true, seed, cells=900), rig)
        new = repaired(first)
        known = saved(first, new, earlier=SavedPrior(rig, "default"))
        other = estimate(seen(new, true, seed + 100, cells=900), new, known)
        again = estimate(seen(new, true, seed, cells=900), new, known.earlier.counted_from(new))
        fresh = estimate(seen(new, true, seed + 100, cells=900), new)
        looks.append((true, first, other, again, fresh))
    return looks


def of_depth(found, true) -> tuple[float, bool]:
    """Width of the interval of depth at 30 baselines, of the given rig, and whether it holds the truth."""
    _, low, high = found.depth_error_percent(np.zeros(len(found.theta)))[30]
    nearness = readings(found.chart.rig, true, points_of_view(true, 30))[1].mean()
    return high - low, bool(low <= 100 * (1 / (1 + nearness) - 1) <= high)


def test_a_second_look_holds_the_truth_and_a_fresh_prior_would_be_too_sure(two_looks):
    held = [of_depth(other, true)[1] for true, _, other, _, _ in two_looks]
    assert sum(held) >= 3
    widths = [(of_depth(other, true)[0], of_depth(fresh, true)[0]) for true, _, other, _, fresh in two_looks]
    assert np.median([known / naive for known, naive in widths]) > 1.5


def test_the_same_images_again_are_no_news(two_looks):
    """Neither surer nor elsewhere: what was known before them stands in. Groups begin at another rig, so a misfit is
    now and then another."""
    ratios = []
    for _, first, _, again, _ in two_looks:
        ratios.append(sigmas(again)[:5] / sigmas(first)[:5])
        moved = first.chart.rig_at(first.theta), again.chart.rig_at(again.theta)
        apart = first.chart.coordinates_of(moved[1]) - first.theta
        assert (np.abs(apart) < sigmas(first) + 1e-9).all()
    assert np.median(ratios) > 0.97
    assert np.min(ratios) > 0.85


def test_of_a_repair_without_a_posterior_depth_is_not_known(rig, seen):
    blind = seen(rig, rig, cells=900)
    default, unknown = estimate(blind, rig), estimate(blind, rig, SavedPrior(rig, None))
    widths = [found.depth_error_percent(np.zeros(len(found.theta)))[30] for found in (default, unknown)]
    assert widths[1][2] - widths[1][1] > 3 * (widths[0][2] - widths[0][1])
