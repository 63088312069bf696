"""Which prior a repair begins with, which pairs count, and what is known after it."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from parts_of_repairs import fingerprint, known_after, prior_use

import stereorecal as sr
from stereorecal.estimation import Mixture, SavedPrior, rig_parameters
from stereorecal.io import load_rig, save_rig
from stereorecal.recalibration import Condition

DRIFT = np.array([*np.radians([0.8, 0.3, -0.9]), 0.0, 0.003, -0.003])
MATCHER = sr.SAD(num_disparities=32)


def pair_of(seed: int, **changes) -> sr.Pair:
    left, right = np.random.default_rng(seed).integers(0, 256, (2, 6, 8)).astype(np.float32)
    return sr.Pair(left, right, **changes)


PAIRS = [pair_of(seed) for seed in range(6)]
PRINTS = [fingerprint(pair) for pair in PAIRS]
RIG = sr.synthetic.default_rig().resized((160, 120))
N = rig_parameters(RIG).dim
KNOWN = Mixture(np.ones(1), np.zeros((1, N)), np.eye(N)[None])


def saved(images, earlier: SavedPrior | None = None, rig: sr.StereoRig = RIG) -> SavedPrior:
    return SavedPrior(rig, KNOWN, tuple(images), earlier)


# --- which pairs count ----------------------------------------------------------------------------------------


def test_a_fingerprint_is_of_the_pixels():
    one = pair_of(0)
    assert fingerprint(one) == fingerprint(pair_of(0, name="another"))
    assert fingerprint(one) != fingerprint(sr.Pair(one.right, one.left))
    assert fingerprint(one) != fingerprint(sr.Pair(one.left.reshape(8, 6), one.right.reshape(8, 6)))
    other = one.left.copy()
    other[3, 4] = (other[3, 4] + 1) % 256
    assert fingerprint(one) != fingerprint(sr.Pair(other, one.right))
    strided = sr.Pair(np.asfortranarray(one.left), one.right[:, ::1])
    assert fingerprint(one) == fingerprint(strided)


@given(
    used=st.sets(st.integers(0, 5)),
    before=st.sets(st.integers(0, 5)),
    shown=st.permutations(range(6)),
    n=st.integers(1, 6),
)
def test_no_pair_counts_twice(used, before, shown, n):
    shown, before = shown[:n], before & used
    earlier = SavedPrior(RIG, "default", tuple(PRINTS[i] for i in sorted(before)))
    prior = saved((PRINTS[i] for i in sorted(used)), earlier)
    pairs = [PAIRS[i] for i in shown]
    if set(shown) <= before:
        with pytest.raises(sr.InputError, match="used by earlier repairs"):
            prior_use(prior, RIG, pairs)
        return
    use = prior_use(prior, RIG, pairs)
    rests_on = used if use.prior is prior else before
    assert (use.prior is prior) == bool(set(shown) - used)
    assert use.prior is prior or use.prior.images == earlier.images
    assert known_after(use, None, RIG, RIG, (), good=False) is prior  # nothing is learnt, and nothing forgotten
    counted = {shown[number] for number in use.numbers}
    assert counted == set(shown) - rests_on
    assert use.dropped == len(shown) - len(counted)


def test_without_anything_saved_it_is_the_default():
    for asked in (None, "default"):
        use = prior_use(asked, RIG, PAIRS)
        assert (use.name, use.prior, use.numbers) == ("default", "default", tuple(range(6)))
    assert prior_use({"left.f": 0.1}, RIG, PAIRS).name == "given"
    assert prior_use("exact", RIG, PAIRS).name == "exact"
    with pytest.raises(sr.InputError, match="no prior is saved"):
        prior_use("saved", RIG, PAIRS)
    with pytest.raises(sr.InputError, match="did you mean saved"):
        prior_use("safed", RIG, PAIRS)


def test_a_prior_of_another_rig():
    with pytest.raises(sr.InputError, match="another rig"):
        prior_use(saved(()), RIG.with_extrinsics(RIG.extrinsics + DRIFT), PAIRS)


@pytest.mark.parametrize("name", ["calib.json", "calib.yaml"])
def test_what_was_saved_with_a_calibration_is_found(tmp_path: Path, name: str):
    path = tmp_path / name
    save_rig(RIG, path, prior=saved(PRINTS[:1]))
    rig = load_rig(path, unit=None if name == "calib.json" else "m")
    for asked in (None, "saved"):
        use = prior_use(asked, rig, PAIRS)
        assert (use.name, use.numbers) == ("saved", (1, 2, 3, 4, 5))
        assert isinstance(use.prior, SavedPrior)
        assert use.prior.as_dict() == saved(PRINTS[:1]).as_dict()
        assert "1 of 6 pairs was used before and does not count again" in str(use)
    assert prior_use("default", rig, PAIRS).numbers == tuple(range(6))
    moved = rig.with_extrinsics(rig.extrinsics + DRIFT)
    use = prior_use(None, moved, PAIRS)
    assert (use.name, use.prior) == ("default", "default")
    assert f"{name}" in str(use.note)
    assert "not used" in str(use)
    with pytest.raises(sr.InputError, match="not used"):
        prior_use("saved", moved, PAIRS)


def test_load_prior(tmp_path: Path):
    save_rig(RIG, tmp_path / "a.json", prior=saved(PRINTS))
    save_rig(RIG, tmp_path / "b.json")
    found = sr.load_prior(tmp_path / "a.json")
    assert found is not None
    assert found.as_dict() == saved(PRINTS).as_dict()
    assert sr.load_prior(tmp_path / "b.json") is None
    text = (tmp_path / "a.json").read_text()
    (tmp_path / "a.json").write_text(text.replace('"K_left": [\n  [\n   ', '"K_left": [\n  [\n   1', 1))
    with pytest.raises(sr.InputError, match="other parameters"):
        sr.load_prior(tmp_path / "a.json")


# --- what is known after it -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scenes(scene):
    """A calibration that is off, two pairs, and the rig that took them."""
    pairs = [scene("street", seed).pairs[0] for seed in (3, 4)]
    return RIG.with_extrinsics(RIG.extrinsics + DRIFT), pairs, RIG


@pytest.fixture(scope="module")
def first(scenes):
    bad, pairs, _ = scenes
    solution = sr.recalibrate(bad, pairs[:1], matcher=MATCHER)
    assert solution.accepted
    return solution


def test_a_repair_knows_its_rig_and_its_images(scenes, first):
    _, pairs, true = scenes
    prior = first.prior
    prior.check(first.rig)
    assert prior.images == (fingerprint(pairs[0]),)
    assert prior.earlier.rig is first.initial
    assert prior.earlier.known == "default"
    assert "prior" not in str(first)
    chart = rig_parameters(first.rig)
    apart = chart.coordinates_of(true)[:3] - prior.known.means[0, :3]
    assert (np.abs(apart) < 4.0 * np.sqrt(np.diag(prior.known.covariances[0]))[:3] + 0.02).all()


def test_the_next_look_begins_with_it(scenes, first):
    """New images count, old ones do not."""
    _, pairs, _ = scenes
    second = sr.recalibrate(first.rig, pairs, matcher=MATCHER, prior=first.prior)
    assert second.prior_use.name == "saved"
    assert second.selected == (1,)
    assert second.prior_use.as_dict()["not_again"] == 1
    assert "1 of 2 pairs was used before and does not count again" in str(second)
    alone = sr.recalibrate(first.rig, pairs[1:], matcher=MATCHER, prior=first.prior)
    np.testing.assert_array_equal(second.candidate.extrinsics, alone.candidate.extrinsics)
    if second.reason.healthy:
        assert second.prior.images == tuple(map(fingerprint, pairs))
        assert second.prior.earlier.images == first.prior.images


def test_the_same_pairs_again_say_the_same_again(scenes, first):
    """What was known before them stands in, and nothing adds up."""
    _, pairs, _ = scenes
    again = sr.recalibrate(first.rig, pairs[:1], matcher=MATCHER, prior=first.prior)
    assert again.prior_use.name == "saved, without these pairs"
    assert again.prior.images == first.prior.images
    assert again.prior.earlier.images == ()
    assert again.prior.earlier.earlier is None
    sigmas = [np.sqrt(np.diag(one.prior.known.covariances[0]))[:3] for one in (first, again)]
    np.testing.assert_allclose(sigmas[1], sigmas[0], rtol=0.5)


def test_a_look_begins_with_it_too(scenes, first, tmp_path: Path):
    """What was written is not to be repaired, by its own images or others; what was saved knows what its depth may be
    off by."""
    _, pairs, true = scenes
    wrong = sr.difference(first.rig, true).depth_error_percent[30]
    save_rig(first.rig, tmp_path / "calib.json", prior=first.prior)
    rig = load_rig(tmp_path / "calib.json")
    for some in (pairs[:1], pairs[1:]):
        found = sr.health(rig, some, matcher=MATCHER)
        assert found.condition is not Condition.REPAIR
        assert found.to_dict()["prior"] == {"name": "saved", "pairs_that_count": 1, "not_again": 0, "note": None}
        assert ("prior    saved" in str(found), found.prior) == (True, None), "nothing is learnt"
        low, _, high = sorted(found.estimate.depth_error_percent(np.zeros(len(found.estimate.names)))[30])
        assert low < wrong < high
    moved = sr.health(rig.with_extrinsics(rig.extrinsics + 1e-5), pairs[:1], matcher=MATCHER)
    assert f"prior    default; {tmp_path / 'calib.json'}, 'prior' is of other parameters than" in str(moved)
    with pytest.raises(sr.InputError, match="no prior is saved"):
        sr.health(first.rig, pairs, matcher=MATCHER, prior="saved")


def test_where_images_fit_no_rig_nothing_is_learnt(scenes, first):
    size = scenes[1][0].left.shape
    dark = sr.make_pair(*(np.random.default_rng(s).integers(0, 2, size).astype(np.float32) for s in (0, 1)))
    looked = sr.recalibrate(first.rig, [dark], matcher=MATCHER, prior=first.prior)
    assert not looked.reason.healthy
    assert looked.prior is first.prior
    assert sr.recalibrate(first.rig, [dark], matcher=MATCHER, prior="default").prior is None
