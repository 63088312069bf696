"""Images that cannot be of a rig: the mistake is named, and corrected where that is asked for."""

import pickle
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import pytest
from parts_of_repairs import mismatch_of

from stereorecal import InputError, recalibrate
from stereorecal.geometry import StereoRig
from stereorecal.io import load_scene
from stereorecal.matching import SAD
from stereorecal.recalibration import Condition, Reason, fixed, health, recalibrate_many
from stereorecal.recordings import Pair, Scene
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
    """Of three places, by one rig."""
    scenes = [scene(kind, 0, SIZE) for kind in ("street", "harbour", "coast")]
    return scenes[0].rig, [one.pairs[0] for one in scenes]


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("ratio", [0.5, 2.0, 1.5])
def test_k_of_another_size_is_corrected(rig_and_pairs, ratio):
    rig, (pair, *_) = rig_and_pairs
    corrected, same = fixed(scaled(rig, ratio), (pair,), "scaled")
    assert same == (pair,)
    for one, other in ((corrected.left, rig.left), (corrected.right, rig.right)):
        np.testing.assert_allclose(one.matrix, other.matrix, rtol=1e-12)


@pytest.mark.parametrize(("by", "name"), [(1, "early"), (-1, "late")])
def test_frames_that_are_one_aside_are_corrected(rig_and_pairs, by, name):
    rig, pairs = rig_and_pairs
    wrong = late(pairs, by)
    with pytest.raises(InputError, match="different things"):
        health(rig, wrong)
    (corrected,) = fixed(rig, tuple(wrong), name)[1]
    assert corrected.left is pairs[1].left
    assert corrected.right is pairs[1].right


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("look", [health, recalibrate])
@pytest.mark.parametrize(("by", "name", "when"), [(1, "early", "later"), (-1, "late", "earlier")])
def test_frames_that_are_one_aside_are_named(data_dir: Path, look, by, name, when):
    given = load_scene(data_dir / "kitti_odometry/suburb_drive", limit=3)
    said = look(given.rig, late(list(given.pairs), by))
    assert f"right images one frame {when}" in said.verdict
    assert len(said.verdict.split()) <= 12
    assert f"--fix {name}" in said.advice


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_drift_is_no_mistake(scene, kind, seed):
    shown = scene(kind, seed, (640, 480))
    bad = decalibrate(shown.rig, jax.random.key(seed), 2.5, 0.02)
    assert mismatch_of(pyramid(bad, shown.pairs), SAD_ANY, 0.0) is None


def test_exchanged_images_are_corrected(scene):
    shown = scene("harbour", 0, SIZE)
    (pair,) = shown.pairs
    wrong = (replace(pair, left=pair.right, right=pair.left, origin=None),)
    rig, (corrected,) = fixed(shown.rig, wrong, "exchanged")
    assert rig is shown.rig
    assert corrected.left is pair.left
    assert corrected.right is pair.right
    assert health(rig, [corrected]).healthy


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
        assert "swapped" in said or "left and right exchanged" in said, given.name
        certain += "swapped" in said
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
    assert found.as_dict()["mismatch"]["two_moments"] is True


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("look", [health, recalibrate])
@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_k_of_another_size_of_a_real_rig(data_dir: Path, look, ratio):
    given = load_scene(data_dir / "boofcv_bumblebee2/garden01")
    said = look(scaled(given.rig, ratio), given.pairs)
    assert f"with K scaled by {1 / ratio:g} 7" in said.verdict, "and seven tenths match"
    assert "--fix scaled" in said.advice


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
