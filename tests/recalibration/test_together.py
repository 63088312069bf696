"""Freed intrinsics, shared by recordings: rows come right over the view, and nothing is taken that does not help."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest
from parts_of_repairs import fingerprint, prepared
from wrong_lenses import TRUE, over_the_view, wrong

import stereorecal as sr
from stereorecal.estimation import SavedPrior
from stereorecal.recalibration import MOST_FRAMES, Case, IntrinsicsOutcome, as_settings
from stereorecal.synthetic import photographs, plan_drive

SIZE = (320, 240)
WRONG = wrong({"k1": 0.012, "k2": -0.02}, {"k1": -0.008, "k2": 0.02})
BOTH = ("extrinsics", "intrinsics")


@pytest.fixture(scope="module")
def scenes(scene) -> list[sr.Scene]:
    kinds = [("harbour", 2), ("coast", 1), ("street", 1), ("harbour", 1), ("street", 2)]
    return [scene(kind, seed, SIZE) for kind, seed in kinds]


@pytest.fixture(scope="module")
def given_wrong(scenes) -> list[sr.Scene]:
    return [replace(scene, rig=WRONG) for scene in scenes]


@pytest.mark.slow
def test_each_its_own_extrinsics_on_any_executor(given_wrong):
    alone = sr.recalibrate_many(given_wrong[:3], free=BOTH)
    with ThreadPoolExecutor(2) as pool:
        pooled = sr.recalibrate_many(given_wrong[:3], free=BOTH, executor=pool)
    for one, other in zip(alone, pooled, strict=True):
        for found in ("extrinsics", "left.matrix", "right.distortion"):
            take = attrgetter(f"solution.candidate.{found}")
            np.testing.assert_allclose(take(one), take(other), rtol=1e-6, atol=1e-8)
    first, second, _ = (repair.solution for repair in alone)
    assert first.intrinsics.taken
    assert first.uncertainty.names == sr.Parameters().names  # intrinsics have their own intervals
    np.testing.assert_array_equal(first.candidate.left.matrix, second.candidate.left.matrix)
    np.testing.assert_array_equal(first.candidate.right.distortion, second.candidate.right.distortion)
    assert not np.array_equal(first.candidate.extrinsics, second.candidate.extrinsics)
    assert max(over_the_view(repair.solution.rig) for repair in alone) < 0.4 * over_the_view(WRONG)


@pytest.mark.slow
def test_another_rig_with_the_same_calibration_takes_no_part(given_wrong):
    """A fleet's calibration file is no proof: what is not of one rig is repaired as it would be alone."""
    other = wrong({"f": -0.003, "k1": 0.03}, {"f": 0.005, "cy": 2.0, "k1": 0.02})
    stranger = replace(sr.synthetic.render("harbour", 4, rig=other), rig=WRONG)
    *others, last = (repair.solution for repair in sr.recalibrate_many([*given_wrong[:3], stranger]))
    assert [one.intrinsics.outcome for one in others] == [IntrinsicsOutcome.REFINED] * 3
    assert max(over_the_view(one.rig) for one in others) < 0.4 * over_the_view(WRONG)
    assert last.intrinsics.outcome is IntrinsicsOutcome.APART
    alone = sr.recalibrate(WRONG, stranger.pairs)
    np.testing.assert_array_equal(last.rig.extrinsics, alone.rig.extrinsics)
    two = [repair.solution for repair in sr.recalibrate_many([given_wrong[0], stranger])]
    assert {one.intrinsics.outcome for one in two if one.intrinsics} == {IntrinsicsOutcome.APART}
    np.testing.assert_array_equal(two[1].rig.extrinsics, alone.rig.extrinsics)


@pytest.mark.slow
def test_fog_takes_no_part(given_wrong):
    noise = np.random.default_rng(0)
    left, right = (noise.normal(128, 0.5, SIZE[::-1]).round() for _ in "lr")
    fog = sr.Scene("fog", WRONG, (sr.make_pair(left, right),))
    (alone,) = sr.recalibrate_many(fog, free=BOTH)
    assert alone.solution.intrinsics is None
    *others, last = sr.recalibrate_many([*given_wrong, fog], free=BOTH)
    assert not last.solution.accepted
    assert last.solution.intrinsics.outcome is IntrinsicsOutcome.NOT_HERE
    assert not last.solution.intrinsics.taken
    assert others[0].solution.intrinsics.taken


@pytest.mark.slow
def test_what_was_saved_counts_for_recordings_that_share(given_wrong):
    """Pairs that it rests on take no part."""
    used = tuple(pair for index in (0, 3, 4) for pair in given_wrong[index].pairs)
    first = sr.recalibrate(WRONG, used)
    assert first.accepted
    again = replace(given_wrong[1], rig=first.rig, pairs=(*used, *given_wrong[1].pairs))
    third = replace(given_wrong[2], rig=first.rig)
    repairs = sr.recalibrate_many([again, third], prior=first.prior)
    for repair, number in zip(repairs, (3, 0), strict=True):
        assert repair.error is None
        assert repair.solution.prior_use.name == "saved"
        assert repair.solution.prior_use.numbers == (number,)
        assert not set(first.prior.images) - set(repair.solution.prior.images)


def test_rigs_that_differ_share_nothing(given_wrong):
    with pytest.raises(sr.InputError, match="other intrinsics"):
        sr.recalibrate_many([given_wrong[0], replace(given_wrong[1], rig=TRUE)], free=BOTH)


def long(number: int = 100) -> sr.Scene:
    """Frames of which every seventh has the most texture: a grating."""
    noise, made = np.random.default_rng(0), []
    for index in range(number):
        step = 20.0 if index % 7 == 5 else 2.0
        image = np.clip(128 + noise.normal(0, step, (120, 160)), 0, 255).astype(np.float32)
        made.append(sr.Pair(image, image[::-1].copy(), str(index)))
    return sr.Scene("long", TRUE.resized((160, 120)), tuple(made))


def test_long_recordings_are_looked_at_in_part():
    """The frame with the most texture of each stretch is looked at, and those that ranges name."""
    scene = long()

    def looked_at(prior="default", **options) -> Case:
        return prepared(scene.rig, scene.pairs, as_settings({"prior": prior, **options}))

    numbers = list(looked_at().selected)
    assert [int(pair.name) for pair in looked_at().images.pairs] == numbers
    assert len(numbers) == MOST_FRAMES
    assert numbers == sorted(numbers)
    assert max(np.diff(numbers)) < 10
    assert sum(number % 7 == 5 for number in numbers) >= 13  # of 14 that there are, two in one stretch
    ranged = looked_at(ranges=sr.Range("1", (5.0, 5.0), 3.0))
    assert list(ranged.selected) == sorted({1, *numbers})
    travelled = pickle.loads(pickle.dumps(ranged))
    for case in (ranged, travelled):
        assert case.ranges[0].pair is case.images.pairs[case.selected.index(1)]
    assert len(looked_at(free="extrinsics").images.pairs) == 100
    used = tuple(fingerprint(scene.pairs[number]) for number in numbers)
    fresh = looked_at(SavedPrior(scene.rig, None, used))
    assert len(fresh.selected) == MOST_FRAMES
    assert not set(fresh.selected) & set(numbers)
    assert sr.health(scene.rig, scene.pairs[:30], matcher=sr.BM(num_disparities=16)).used == tuple(range(MOST_FRAMES))


def test_intrinsics_without_extrinsics(scenes):
    with pytest.raises(sr.InputError, match="free them as well"):
        sr.recalibrate(TRUE, scenes[0].pairs, free="intrinsics")


@pytest.mark.slow
def test_motion_counts_in_what_is_shared(tmp_path):
    """Each recording has its own windows."""
    drive = plan_drive("street", 0, 10, weather=False, moving=False)
    pairs = list(photographs(drive, folder=tmp_path))[::3]
    scenes = [sr.Scene("first", drive.rig, pairs[:2]), sr.Scene("second", drive.rig, pairs[2:])]
    each = sr.recalibrate_many(scenes, free=BOTH, motion=True)
    assert [repair.solution.estimate.windows.frames for repair in each] == [((0, 1),), ((0, 1),)]
