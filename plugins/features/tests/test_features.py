"""The feature baseline: it conforms, it finds a rig that is known exactly, and says why where it cannot."""

from dataclasses import replace

import cv2
import jax
import numpy as np
import pytest
from fixtures import once as once, scene as scene
from image_strategies import RIG, OfImages, coast as coast, images_around, repair
from stereorecal_features import Features, _fit
from stereorecal_features._matches import seen_by_both

from stereorecal.geometry import Camera, StereoRig
from stereorecal.objectives import Reach, count_chart
from stereorecal.recordings import Pair
from stereorecal.strategies import Objective, Problem, Status, run_strategy
from stereorecal.synthetic import decalibrate, render
from stereorecal.testing import StrategyConformance

FEATURES = Features()


class TestFeatures(OfImages, StrategyConformance):
    strategy = FEATURES
    lacks = "only 0 matches; 20 are needed"


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(("degrees", "fraction"), [(0.5, 0.01), (2.5, 0.025)])
def test_it_finds_the_rig(coast, degrees, fraction):
    bad = decalibrate(RIG, jax.random.key(3), degrees, fraction)
    outcome, (pitch, yaw, roll, x, y, z) = repair(FEATURES, images_around(bad, coast.pairs[:1]))
    assert outcome.status is Status.CONVERGED
    assert max(pitch, roll) < 0.03
    assert yaw < 0.06
    assert x == pytest.approx(0.0, abs=1e-12)
    assert max(y, z) < 1.5


def test_the_same_seed_gives_the_same_rig_and_another_seed_nearly(coast):
    images = images_around(decalibrate(RIG, jax.random.key(0), 0.5, 0.01), coast.pairs[:1])
    first, again, other = (repair(FEATURES, images, seed=seed)[0] for seed in (0, 0, 2**40 - 5))
    assert np.array_equal(first.best, again.best)
    np.testing.assert_allclose(other.best, first.best, atol=0.01)


def test_the_end_does_not_hang_on_the_start(coast):
    images = images_around(decalibrate(RIG, jax.random.key(0), 0.5, 0.01), coast.pairs[:1])
    near, far = (repair(FEATURES, images, start=np.full(5, z))[0].best for z in (0.0, -1.0))
    np.testing.assert_allclose(far, near, atol=0.01)


def test_frames_are_taken_together(coast):
    """Matches that are too few in each frame are enough in both."""
    images = images_around(decalibrate(RIG, jax.random.key(0), 0.5, 0.01), coast.pairs)
    alone = [repair(Features(min_matches=800), replace(images, pairs=(pair,))) for pair in coast.pairs]
    assert [outcome.status for outcome, _ in alone] == [Status.STALLED] * 2
    outcome, (pitch, yaw, roll, *_) = repair(Features(min_matches=800), images)
    assert outcome.status is Status.CONVERGED
    assert max(pitch, roll) < 0.02
    assert yaw < 0.04


def test_fewer_free_axes(coast):
    """Only what is free moves; the rest is right here, so the answer is too."""
    bad = RIG.with_extrinsics(RIG.extrinsics + np.radians([0.4, 0, -0.7, 0, 0, 0]))
    outcome, error = repair(FEATURES, images_around(bad, coast.pairs[:1], free=("roll", "pitch")))
    assert outcome.best.shape == (2,)
    np.testing.assert_allclose(error, 0.0, atol=0.01)


def test_it_stays_in_the_box(coast):
    """The true pitch lies outside: it goes as far as it may."""
    bad = RIG.with_extrinsics(RIG.extrinsics + np.radians([0.3, 0, 0, 0, 0, 0]))
    images = images_around(bad, coast.pairs[:1], Reach(0.2, 0.001))
    outcome, _ = repair(Features(threshold=3.0), images)
    assert outcome.best[0] == pytest.approx(-1.0, abs=1e-3)
    assert np.abs(outcome.best).max() <= 1.0


def test_on_the_open_sea_it_stalls():
    outcome, _ = repair(FEATURES, images_around(RIG, render("open-sea", 1, rig=RIG).pairs))
    assert outcome.status is Status.STALLED
    assert outcome.message.startswith("only")


def test_images_of_two_places_stall(coast):
    """Matches there are, without the ratio test, but hardly any that agree."""
    strangers = Pair(coast.pairs[0].left, np.ascontiguousarray(coast.pairs[0].right[::-1]))
    outcome, _ = repair(Features(ratio=1.0, min_matches=300, features=3000), images_around(RIG, [strangers]))
    assert outcome.status is Status.STALLED
    assert "matches agree on a pose; 300 are needed" in outcome.message


def test_matches_that_never_settle_stall(coast, monkeypatch):
    """One round cannot show that the next one would choose the same matches."""
    monkeypatch.setattr(_fit, "_ROUNDS", 1)
    images = images_around(decalibrate(RIG, jax.random.key(0), 0.5, 0.01), coast.pairs[:1])
    outcome, (pitch, *_) = repair(FEATURES, images)
    assert outcome.status is Status.STALLED
    assert outcome.message.endswith("not the same ones for 1 rounds")
    assert pitch < 0.05


def test_the_core_judges_it(coast):
    """By the objective's own values, which the strategy did not ask."""
    images = images_around(decalibrate(RIG, jax.random.key(0), 0.5, 0.01), coast.pairs[:1])
    truth = images.chart.coordinates(RIG.extrinsics)
    problem = Problem(5, lambda points: -np.linalg.norm((points - truth)[:, :3], axis=1), images=images)
    run = run_strategy(Features(), Objective(problem), np.zeros(5))
    assert run.value > 0.1 * run.start_value
    assert run.message.endswith(" px")
    assert len(run.trace.values) == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"ratio": 0.0}, "need 0 < ratio <= 1"),
        ({"ratio": 1.1}, "need 0 < ratio <= 1"),
        ({"ratio": np.nan}, "need 0 < ratio <= 1"),
        ({"threshold": 0.0}, "need threshold > 0"),
        ({"threshold": np.nan}, "need threshold > 0"),
        ({"loss_scale": -1.0}, "need loss_scale > 0"),
        ({"contrast": np.inf}, "need contrast > 0"),
        ({"min_matches": 7}, "need 8 <= min_matches <= features"),
        ({"features": 10}, "need 8 <= min_matches <= features"),
    ],
)
def test_options_that_make_no_sense(options, message):
    with pytest.raises(ValueError, match=message):
        Features(**options)


def exact_matches(rig: StereoRig, nearest: float, farthest: float, count=400):
    """Pixels of points in space [m] that both cameras see."""
    draw = np.random.default_rng(0)
    points = draw.uniform([-0.4, -0.3, 1], [0.4, 0.3, 1], (count, 3)) * draw.uniform(nearest, farthest, (count, 1))
    return rig.left.project(points), rig.right.project(points @ rig.rotation.T + rig.translation)


def test_exact_matches_have_no_error():
    left, right = seen_by_both(RIG, [exact_matches(RIG, 2, 30)])
    chart = count_chart(RIG, Reach())
    np.testing.assert_allclose(_fit._sampson(chart, np.zeros(5), left, right), 0.0, atol=1e-4)
    assert np.abs(_fit._sampson(chart, np.full(5, 0.1), left, right)).min() > 0.1


def test_errors_are_pixels():
    """A match whose rows differ by one pixel is half a pixel off in each image, so its error is 1/√2; also where the
    lens shrinks the image to half its size."""
    for coefficients in (np.zeros(0), np.array([-0.05, 0.0, 0.0, 0.0])):
        camera = Camera((640, 480), np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]), coefficients)
        rig = StereoRig(camera, camera, np.array([0, 0, 0, -0.3, 0, 0]))
        pixels, off = np.array([[320.0, 240.0], [320.0, 400.0], [320.0, 60.0]]), np.array([0.0, 1.0])
        seen = seen_by_both(rig, [(pixels, pixels + off)])
        np.testing.assert_allclose(
            np.abs(_fit._sampson(count_chart(rig, Reach()), np.zeros(5), *seen)), 0.5**0.5, rtol=0.01
        )


@pytest.mark.parametrize(("nearest", "farthest", "free", "within"), [(2, 30, 5, 0.02), (18, 40, 3, 0.3)])
def test_the_pose_of_the_essential_matrix(nearest, farthest, free, within):
    """A third of the matches is wrong; in the second case all points lie beyond 50 baselines. The right camera stands a
    little lower and further ahead, so that x is not the whole baseline."""
    rig = RIG.with_extrinsics(np.array([*RIG.extrinsics[:3], -0.356, 0.08, -0.06]))
    pixels, others = exact_matches(rig, nearest, farthest)
    wrong = np.arange(len(pixels)) % 3 == 0
    others[wrong] += np.random.default_rng(1).uniform(-40.0, 40.0, (wrong.sum(), 2))
    left, right = seen_by_both(rig, [(pixels, others)])
    bad = decalibrate(rig, jax.random.key(1), 1.0, 0.01)
    pose, agree = _fit._five_point_pose(images_around(bad), left, right, 0.5, 0)
    assert agree[~wrong].mean() > 0.9
    assert agree[wrong].mean() < 0.1  # some lie on their epipolar line by chance
    truth = count_chart(bad, Reach()).coordinates(rig.extrinsics)
    np.testing.assert_allclose(pose[:free], truth[:free], atol=within)


def test_the_pose_of_noisy_matches():
    """MAGSAC's scale of noise is made for pixels: of rays it takes most noise for none, and the pose is six times as
    far off."""
    pixels, others = exact_matches(RIG, 2, 30)
    errors = []
    for seed in range(6):
        draw = np.random.default_rng(seed)
        noisy = others + draw.normal(0.0, 0.3, others.shape)
        noisy[::3] += draw.uniform(-40.0, 40.0, noisy[::3].shape)
        left, right = seen_by_both(RIG, [(pixels + draw.normal(0.0, 0.3, pixels.shape), noisy)])
        pose, agree = _fit._five_point_pose(images_around(RIG), left, right, 1.0, seed)
        assert np.delete(agree, np.s_[::3]).mean() > 0.95
        turned = np.asarray(count_chart(RIG, Reach()).extrinsics(pose))[:3] - RIG.extrinsics[:3]
        errors.append(np.degrees(np.abs(turned)).max())
    assert np.mean(errors) < 0.3


def test_without_an_essential_matrix_nothing_agrees():
    """All matches are the same one."""
    left, right = seen_by_both(RIG, [(np.full((20, 2), 300.0), np.full((20, 2), 280.0))])
    pose, agree = _fit._five_point_pose(images_around(RIG), left, right, 0.5, 0)
    assert not agree.any()
    np.testing.assert_array_equal(pose, 0.0)


@pytest.mark.parametrize(
    ("coefficients", "beyond"),
    [
        ([-0.3, 0.0, 0.0, 0.0], [[0.0, 0.0], [999.0, 599.0]]),  # no ray leads there
        ([-0.3, 0.04, 0.0, 0.0], [[926.8, 300.0], [73.2, 300.0]]),  # a ray does, but the image has folded before it
    ],
)
def test_pixels_beyond_the_lens_model_are_left_out(coefficients, beyond):
    camera = Camera((1000, 600), np.array([[400.0, 0, 500], [0, 400.0, 300], [0, 0, 1]]), np.array(coefficients))
    rig = StereoRig(camera, camera, np.array([0, 0, 0, -0.3, 0, 0]))
    inside = np.array([[500.0, 300.0], [740.0, 300.0]])
    pixels = np.concatenate([inside, beyond])
    left, right = seen_by_both(rig, [(pixels, pixels)])
    assert len(left) == len(right) == 2
    np.testing.assert_allclose(camera.project(left.rays), inside, atol=1e-3)


def test_matches_are_those_of_opencv(coast):
    """The same as its brute-force matcher finds, with Lowe's test and the mutual check."""
    pair = coast.pairs[0]
    sift = cv2.SIFT.create(nfeatures=300, contrastThreshold=0.04, enable_precise_upscale=True)
    (a, words_a), (b, words_b) = (
        sift.detectAndCompute(np.rint(image).astype(np.uint8), None) for image in (pair.left, pair.right)
    )
    mutual = {(m.queryIdx, m.trainIdx) for m in cv2.BFMatcher(cv2.NORM_L2, crossCheck=True).match(words_a, words_b)}
    for ratio in (1.0, 0.8):
        lowe = cv2.BFMatcher(cv2.NORM_L2).knnMatch(words_a, words_b, k=2)
        near = {(m.queryIdx, m.trainIdx) for m, n in lowe if m.distance < ratio * n.distance} & mutual
        left, right = Features(features=300, contrast=0.04, ratio=ratio).matched(pair.left, pair.right)
        assert len(left) == len(near)
        assert set(map(tuple, left)) == {a[i].pt for i, _ in near}
        assert set(map(tuple, right)) == {b[i].pt for _, i in near}


def test_features_lie_where_they_are():
    """Blobs at known places: no shift by a fraction of a pixel."""
    draw = np.random.default_rng(0)
    y, x = np.mgrid[:200, :200].astype(float)
    centres = np.stack(np.meshgrid(np.arange(30, 180, 35), np.arange(30, 180, 35)), -1).reshape(-1, 2)
    centres = centres + draw.uniform(-0.5, 0.5, centres.shape)
    image = draw.uniform(0, 20, (200, 200))
    for column, row in centres:
        image += 200 * np.exp(-((x - column) ** 2 + (y - row) ** 2) / 18.0)
    image = image.clip(0, 255).astype(np.float32)
    found, _ = Features(features=500).matched(image, image)
    apart = found[:, None] - centres
    near = apart[np.arange(len(found)), np.linalg.norm(apart, axis=-1).argmin(1)]
    hits = near[np.linalg.norm(near, axis=1) < 1.0]
    assert len(hits) > 10
    np.testing.assert_allclose(np.median(hits, axis=0), 0.0, atol=0.08)


@pytest.mark.parametrize("good", ["start", "pose"])
def test_the_better_of_two_starts_counts(coast, monkeypatch, good):
    """Only one of them leads to the rig: the other one stays where it is."""
    images = images_around(decalibrate(RIG, jax.random.key(0), 0.5, 0.01), coast.pairs[:1])
    corner, best = np.full(5, 0.9), repair(FEATURES, images)[0].best
    find, refine = _fit._five_point_pose, _fit._refined

    def found(*arguments):
        return corner if good == "start" else best, find(*arguments)[1]

    def stuck(chart, left, right, start, loss_scale):
        end = refine(chart, left, right, start, loss_scale)
        if np.array_equal(start, corner):
            end.x, end.cost = corner, np.inf
        return end

    monkeypatch.setattr(_fit, "_five_point_pose", found)
    monkeypatch.setattr(_fit, "_refined", stuck)
    outcome, _ = repair(FEATURES, images, start=np.zeros(5) if good == "start" else corner)
    assert outcome.status is Status.CONVERGED
    np.testing.assert_allclose(outcome.best, best, atol=0.01)
