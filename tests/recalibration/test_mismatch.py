"""Images that cannot be of a rig: the mistake is named, and corrected where that is asked for."""

import pickle
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import jax
import numpy as np
import pytest
from fixtures import SAD_48
from parts_of_repairs import mismatch_of

from stereorecal import InputError, recalibrate
from stereorecal.geometry import StereoRig
from stereorecal.io import load_scene
from stereorecal.matching import SAD
from stereorecal.recalibration import Condition, Reason, fixed, health, recalibrate_many
from stereorecal.recordings import Pair, Scene, make_pair
from stereorecal.scoring import pyramid
from stereorecal.synthetic import KINDS, decalibrate

SIZE, SAD_ANY = (320, 240), SAD()


def scaled(rig: StereoRig, ratio: float) -> StereoRig:
    def of(camera):
        matrix = np.diag([ratio, ratio, 1.0]) @ camera.matrix
        matrix[:2, 2] += 0.5 * (ratio - 1.0)
        return replace(camera, matrix=matrix)

    return replace(rig, left=of(rig.left), right=of(rig.right))


def late(pairs: list[Pair], by: int) -> list[Pair]:
    """The right images came so many frames later; the first have none."""
    both = zip(pairs[max(by, 0) :], pairs[max(-by, 0) :], strict=False)
    return [replace(pair, right=other.right, origin=None) for pair, other in both]


def middle(rig: StereoRig, pairs: Sequence[Pair]) -> tuple[StereoRig, list[Pair]]:
    """The middle of what a wide rig sees, of the size of which programs are compiled already."""
    (width, height), size = SIZE, rig.left.size
    whole = (size[0] * height // size[1], height)
    first = (whole[0] - width) // 2
    shift, seen = np.array([[1.0, 0.0, -first], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), slice(first, first + width)
    resized = rig.resized(whole)
    left, right = (replace(of, size=SIZE, matrix=shift @ of.matrix) for of in (resized.left, resized.right))
    cut = [Pair(one.left[:, seen], one.right[:, seen], one.name) for one in (pair.resized(whole) for pair in pairs)]
    return replace(resized, left=left, right=right), cut


def answer(rig: StereoRig, pairs: list[Pair]) -> str:
    """What is said of images that are not to be accepted."""
    try:
        solution = recalibrate(rig, pairs)
    except InputError as error:
        return str(error)
    assert not solution.accepted
    return solution.verdict


@pytest.fixture
def rig_and_pairs(scene):
    """A rig, and its pairs of three places."""
    scenes = [scene(kind, 0, SIZE) for kind in ("street", "harbour", "coast")]
    return scenes[0].rig, [one.pairs[0] for one in scenes]


def by_half_a_turn(image: np.ndarray) -> np.ndarray:
    return np.rot90(image, 2).copy()


SPOILED = {
    "scaled": lambda rig, pairs: (scaled(rig, 0.5), pairs),
    "early": lambda rig, pairs: (rig, late(pairs, 1)),
    "late": lambda rig, pairs: (rig, late(pairs, -1)),
    "exchanged": lambda rig, pairs: (rig, [replace(p, left=p.right, right=p.left, origin=None) for p in pairs]),
    "turned": lambda rig, pairs: (
        rig,
        [replace(p, left=by_half_a_turn(p.left), right=by_half_a_turn(p.right), origin=None) for p in pairs],
    ),
}


@pytest.mark.parametrize("cause", SPOILED)
def test_what_a_mistake_has_spoiled_comes_back(rig_and_pairs, cause):
    rig, pairs = rig_and_pairs
    wrong, spoiled = SPOILED[cause](rig, pairs)
    found, corrected = fixed(wrong, tuple(spoiled), cause)
    for one, other in ((found.left, rig.left), (found.right, rig.right)):
        np.testing.assert_allclose(one.matrix, other.matrix, rtol=1e-12)
    expected = pairs[1:2] if cause in ("early", "late") else pairs  # the first and the last have no partner
    for one, other in zip(corrected, expected, strict=True):
        np.testing.assert_array_equal(one.left, other.left)
        np.testing.assert_array_equal(one.right, other.right)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("look", [health, recalibrate])
@pytest.mark.parametrize(("by", "name", "when"), [(1, "early", "later"), (-1, "late", "earlier")])
def test_frames_that_are_one_aside_are_named(data_dir: Path, look, by, name, when):
    given = load_scene(data_dir / "kitti_odometry/suburb_drive", limit=3)
    rig, pairs = middle(given.rig, given.pairs)
    said = look(rig, late(pairs, by), matcher=SAD_48)
    assert f"right images one frame {when}" in said.verdict
    assert len(said.verdict.split()) <= 12
    assert f"--fix {name}" in said.advice


@pytest.mark.parametrize(("exchanged", "named"), [(0.2, "early"), (0.7, "exchanged")])
def test_the_likelier_mistake_is_named_unless_it_explains_little(scene, monkeypatch, exchanged, named):
    """Right images one frame later match by six tenths, as they are hardly at all."""
    shown = scene("harbour", 0, SIZE)
    pairs = [shown.pairs[0], replace(shown.pairs[0])]

    def covered(rig, given, images, matcher):
        if len(given) < len(pairs):
            return 0.6
        return 0.01 if given[0].left is pairs[0].left else exchanged

    monkeypatch.setattr("stereorecal.recalibration._mismatch._covered", covered)
    motion = SimpleNamespace(turned=False, aside=True)
    monkeypatch.setattr("stereorecal.scoring.host.refuse_swapped_images", lambda images: motion)
    found = mismatch_of(pyramid(shown.rig, pairs), SAD_ANY, 0.01)
    assert found.cause.name == named


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_drift_is_no_mistake(scene, kind, seed):
    shown = scene(kind, seed, (640, 480))
    bad = decalibrate(shown.rig, jax.random.key(seed), 2.5, 0.02)
    assert mismatch_of(pyramid(bad, shown.pairs), SAD_ANY, 0.0) is None


def test_what_nothing_says_how_to_correct(scene):
    shown = scene("harbour", 0, SIZE)
    for name in ("scaled", "late"):  # K fits, and there is one pair
        with pytest.raises(InputError, match=f"how to correct '{name}'"):
            fixed(shown.rig, shown.pairs, name)


@pytest.mark.slow
def test_no_exchanged_pair_is_accepted_and_no_true_pair_named(data_dir: Path):
    every = certain = 0
    for calibration in sorted(data_dir.glob("*/*/calib.json")):
        if (given := load_scene(calibration.parent)).rig is None:
            continue
        every += 1
        pair = given.pairs[0]
        assert mismatch_of(pyramid(given.rig, [pair]), SAD_ANY, 0.0) is None, given.name
        said = answer(given.rig, [replace(pair, left=pair.right, right=pair.left, origin=None)])
        assert "look exchanged" in said or "left and right exchanged" in said, given.name
        certain += "look exchanged" in said
    assert certain >= 18, "exit code 2, not 5"
    assert every > 18


@pytest.mark.slow
def test_images_of_two_moments_on_the_move(data_dir: Path):
    given = load_scene(data_dir / "kitti_odometry/suburb_drive")
    wrong = [replace(a, right=b.right, origin=None) for a, b in zip(given.pairs[:8:2], given.pairs[1:9:2], strict=True)]
    for said in (health(given.rig, wrong), recalibrate(given.rig, wrong[:1])):
        assert "two moments" in said.verdict
    found = health(given.rig, wrong)
    assert found.condition is Condition.WRONG_INPUT
    assert found.reason is not Reason.ALREADY_GOOD
    assert found.to_dict()["mismatch"]["two_moments"] is True


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("look", [health, recalibrate])
@pytest.mark.parametrize(("size", "ratio"), [(SIZE, 0.5), ((640, 480), 0.5), ((640, 480), 2.0)])
def test_k_of_another_size_of_a_real_rig(data_dir: Path, look, size, ratio):
    given = load_scene(data_dir / "boofcv_bumblebee2/garden01")
    said = look(scaled(given.rig.resized(size), ratio), [pair.resized(size) for pair in given.pairs])
    _, share = said.verdict.split(f"with K scaled by {1 / ratio:g} ")
    assert 70 <= int(share.removesuffix(" %.")) < 90
    assert "--fix scaled" in said.advice
    assert not any(word in str(said) for word in ("rows differ", "misfit", "not determined")), "of chance matches"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed", "ratio", "degrees"),
    [("street", 0, 2.0, 2.5), ("street", 1, 1.5, 1.0), ("harbour", 0, 1.5, 2.5), ("harbour", 1, 0.5, 1.0)],
)
def test_k_of_another_size_of_a_rig_that_drifted(scene, kind, seed, ratio, degrees):
    """Lenses and rotations are free enough to match half of the images all the same."""
    shown = scene(kind, seed, (640, 480))
    bad = decalibrate(scaled(shown.rig, ratio), jax.random.key(seed), degrees, 0.008 * degrees)
    assert f"with K scaled by {1 / ratio:.3g} " in answer(bad, shown.pairs)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["coast", "harbour", "street"])  # that part of an open sea is sky
def test_a_part_of_larger_images_is_no_mistake(scene, kind):
    """Though its principal points lie as in images of another size."""
    shown, size = scene(kind, 0, (640, 480)), (480, 360)
    rig = replace(shown.rig, left=replace(shown.rig.left, size=size), right=replace(shown.rig.right, size=size))
    bad = decalibrate(rig, jax.random.key(0), 1.0, 0.008)
    seen = slice(size[1]), slice(size[0])
    (pair,) = shown.pairs
    assert recalibrate(bad, [make_pair(pair.left[seen], pair.right[seen])]).accepted


@pytest.mark.slow
def test_late_images_whose_times_explain_a_motion_are_not_accepted(data_dir: Path):
    given = load_scene(data_dir / "kitti_odometry/suburb_drive")
    wrong = [replace(a, right=b.right, origin=None) for a, b in zip(given.pairs, given.pairs[1:], strict=False)][::5]
    assert not recalibrate(given.rig, wrong).accepted


@pytest.mark.slow
def test_what_cannot_be_of_the_rig_takes_no_part_in_a_joint_estimate(data_dir: Path):
    given = load_scene(data_dir / "kitti_odometry/suburb_drive")
    late = [replace(a, right=b.right, origin=None) for a, b in zip(given.pairs[:8:2], given.pairs[1:9:2], strict=True)]
    true, wrong = Scene("true", given.rig, given.pairs[10:13]), Scene("late", given.rig, tuple(late))
    first, second = recalibrate_many([true, wrong])
    assert first.solution.accepted
    assert not second.solution.accepted
    assert second.solution.mismatch is not None
    assert len(pickle.dumps(second.solution.mismatch)) < 2000, "no images travel with it"


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "degrees"), [("street", 0.0), ("street", 1.0), ("harbour", 0.0), ("coast", 2.5)])
def test_images_that_are_rectified_already_are_named(scene, kind, degrees):
    """Also where another rig explains them; and no fix is offered: nothing says with which camera matrices."""
    shown = scene(kind, 0, (640, 480))
    rig, size, rectified = shown.rig, shown.rig.left.size, []
    cameras = [(np.asarray(camera.matrix), np.asarray(camera.distortion)) for camera in (rig.left, rig.right)]
    shift = np.array(rig.translation, float)[:, None]
    *turns, left, right = cv2.stereoRectify(*cameras[0], *cameras[1], size, np.array(rig.rotation, float), shift)[:4]
    seen = zip(cameras, turns, (left, right), (shown.pairs[0].left, shown.pairs[0].right), strict=True)
    for (matrix, lens), turn, new, image in seen:
        maps = cv2.initUndistortRectifyMap(matrix, lens, turn, new, size, cv2.CV_32FC1)
        rectified.append(cv2.remap(np.asarray(image, np.float32), *maps, cv2.INTER_LINEAR))
    bad = decalibrate(rig, jax.random.key(0), degrees, 0.008 * degrees)
    said = recalibrate(bad, [make_pair(*rectified)])
    assert "as rectified images" in said.verdict
    assert "rectified already" in said.advice
    assert "--fix" not in said.advice
    with pytest.raises(InputError, match="how to correct 'rectified'"):
        fixed(bad, (make_pair(*rectified),), "rectified")
