"""Ranges: the length of the baseline, what they cannot harm, and what is said of those that make no sense."""

import cv2
import numpy as np
import pytest
from parts_of_repairs import match_ranges

import stereorecal as sr
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import with_measured_range
from stereorecal.synthetic import ranges as measured

RIG = sr.synthetic.default_rig()
SIZE = (320, 240)
SMALL = RIG.resized(SIZE)


@pytest.fixture(scope="module")
def harbour(scene) -> sr.Scene:
    return scene("harbour", 2, RIG.left.size)


def longer(rig: sr.StereoRig, percent: float) -> sr.StereoRig:
    return rig.with_extrinsics(np.concatenate([rig.extrinsics[:3], rig.extrinsics[3:] * (1 + percent / 100)]))


def some(number: int = 60, noise: float = 0.01, draw: int = 0) -> list[sr.Range]:
    pixels, metres = measured("harbour", 2, number=number, noise=noise, draw=draw)
    return [
        sr.Range(0, tuple(pixel), far, 0.01 * far) for pixel, far in zip(pixels.tolist(), metres.tolist(), strict=True)
    ]


@pytest.fixture(scope="module")
def small(scene) -> sr.Scene:
    return scene("harbour", 2, SIZE)


def of_small(times: float = 1.0, pair: sr.Pair | int = 0) -> list[sr.Range]:
    pixels, metres = measured("harbour", 2, rig=SMALL, number=60)
    return [sr.Range(pair, tuple(p), times * m) for p, m in zip(pixels.tolist(), metres.tolist(), strict=True)]


def test_disparities_err_as_their_deviations_say(scene):
    """Disparities of single pixels, whose ranges have no noise, err by about a deviation."""
    pixels, metres = measured("harbour", 1, rig=SMALL, number=200, noise=0.0)
    images = pyramid(SMALL, scene("harbour", 1, SIZE).pairs)
    ranges = [sr.Range(images.pairs[0], tuple(p), far, 1e-9) for p, far in zip(pixels.tolist(), metres, strict=True)]
    seen = match_ranges(images.at(1.0), SMALL, with_measured_range(None, images), images.pairs, ranges)
    assert len(seen.metres) > 0.5 * len(ranges)
    apart = np.abs(seen.residuals(SMALL))  # in deviations of the disparity, nothing else being uncertain
    surer = seen.matching < np.median(seen.matching)
    for some in (surer, ~surer):  # this scene has .95 and .96; six others .6 to 1.4
        assert 0.5 < 1.4826 * np.median(apart[some]) < 1.7
    assert np.mean(apart > 4.0) < 0.08


def test_depth_along_the_axis_is_that_of_the_same_points_along_the_ray(small):
    pixels, metres = measured("harbour", 2, rig=SMALL, number=60, noise=0.0)
    images = pyramid(SMALL, small.pairs)
    slant = np.linalg.norm(np.asarray(SMALL.left.rays(pixels)), axis=1)

    def matched(metres, along):
        given = zip(pixels.tolist(), metres.tolist(), strict=True)
        ranges = [sr.Range(images.pairs[0], tuple(p), far, along=along) for p, far in given]
        return match_ranges(images.at(1.0), SMALL, with_measured_range(None, images), images.pairs, ranges)

    by_ray, by_axis = matched(metres, "ray"), matched(metres / slant, "axis")
    assert slant.max() > 1.1
    assert not match_ranges(images.at(1.0), SMALL, with_measured_range(None, images), images.pairs, [])
    np.testing.assert_allclose(by_axis.metres, by_ray.metres)
    np.testing.assert_allclose(by_axis.sigma, by_ray.sigma)
    with pytest.raises(sr.InputError, match='along the "ray" or along the optical "axis"'):
        sr.Range(0, (1, 2), 3.0, along="z")


@pytest.mark.parametrize(
    ("percent", "times"), [(-3.0, 3.0), *(pytest.param(-5.0, times, marks=pytest.mark.slow) for times in (3.0, 0.4))]
)
def test_ranges_of_other_things_have_no_say(small, percent, times):
    """A fifth of them belongs elsewhere."""
    wrong = [sr.Range(0, r.left_pixel, times * r.metres) if i % 5 == 0 else r for i, r in enumerate(of_small())]
    found = sr.recalibrate(longer(SMALL, percent), small.pairs, ranges=wrong)
    assert abs(100 * (found.rig.baseline / SMALL.baseline - 1)) < 1.0


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("percent", [3.0, -3.0, 0.0])
@pytest.mark.parametrize("prior", [None, "exact"])
def test_a_repair_with_ranges(small, prior, percent):
    """A baseline that is off is repaired though rows are as good as before, which alone are no reason; where intrinsics
    are exact, too, but then depth is not known after it."""
    bad = longer(SMALL, percent)
    solution = sr.recalibrate(bad, small.pairs, ranges=of_small(), prior=prior)
    assert abs(sr.difference(solution.rig, SMALL).depth_error_percent[10]) < 1.5  # which intrinsics tell as well
    if not percent:
        assert solution.reason is sr.Reason.ALREADY_GOOD
        assert solution.rig is bad
        return
    assert solution.reason is sr.Reason.IMPROVED
    assert solution.uncertainty.names[5] == "baseline"
    assert solution.ranges.contradict < 0.2 * solution.ranges.matched
    assert (solution.prior.known is None) == (prior == "exact")
    assert sr.recalibrate(bad, small.pairs, prior=prior).reason is sr.Reason.ALREADY_GOOD


@pytest.mark.slow
def test_ranges_of_one_recording_are_no_reason_for_another(small):
    """A shutter that rolls in one image poses as a drift; the recording keeps its extrinsics, and learns the length of
    the baseline."""
    street = sr.synthetic.render("street", 3, rig=SMALL)
    pair, bad = street.pairs[0], longer(SMALL, 3.0)
    lines, columns = np.mgrid[: SIZE[1], : SIZE[0]].astype(np.float32)
    right = cv2.remap(np.asarray(pair.right), columns + 5 * lines / SIZE[1] - 2.5, lines, cv2.INTER_CUBIC)
    rolled = sr.make_pair(pair.left, np.clip(right, 0, 255), name="rolled")
    given_scenes = [sr.Scene("harbour", bad, small.pairs), sr.Scene("street", bad, (rolled,))]
    alone = sr.recalibrate(bad, [rolled])
    first, second = sr.recalibrate_many(given_scenes, ranges=of_small(pair=small.pairs[0]))
    assert first.solution.reason is sr.Reason.IMPROVED
    np.testing.assert_array_equal(second.solution.rig.rotation, alone.rig.rotation)
    assert second.solution.rig.baseline == pytest.approx(first.solution.rig.baseline, rel=5e-4)
    np.testing.assert_allclose(
        second.solution.rig.translation / second.solution.rig.baseline, alone.rig.translation / alone.rig.baseline
    )


@pytest.mark.slow
def test_a_repair_outlives_bad_ranges(small):
    """In feet: the drift is repaired as without them, and they are named; they have no say in what is expected."""
    off = SMALL.with_extrinsics(SMALL.extrinsics + np.array([*np.radians([0.5, 0.3, -0.4]), 0, 0, 0]))
    solution = sr.recalibrate(off, small.pairs, ranges=of_small(3.2808))
    assert solution.reason is sr.Reason.IMPROVED
    assert abs(solution.rig.baseline / SMALL.baseline - 1) < 0.01
    assert sr.difference(solution.rig, SMALL).row_error_median < 0.1
    seen = solution.ranges
    assert seen.given == 60
    assert 2 * seen.contradict > seen.matched > 20
    assert "check their units" in str(solution)
    alone = sr.recalibrate(off, small.pairs).expected.depth_percent[30]
    told = solution.expected.depth_percent[30]
    assert told.high - told.low == pytest.approx(alone.high - alone.low, rel=0.2)


@pytest.mark.slow
def test_beside_what_was_saved(small):
    bad = longer(SMALL, 3.0)
    first = sr.recalibrate(bad, small.pairs, ranges=of_small())
    assert first.reason is sr.Reason.IMPROVED
    length = first.estimate.names.index("baseline")
    low, high = first.estimate.intervals[length]
    apart = abs(100 * (SMALL.baseline / bad.baseline - 1) - (low + high) / 2)  # which a yaw may stand for
    assert apart < 0.75 * (high - low)  # three deviations
    depth = [sr.difference(rig, SMALL).depth_error_percent for rig in (bad, first.rig)]
    assert all(abs(depth[1][at]) < 0.7 * abs(depth[0][at]) for at in (5, 10, 30))
    street = sr.synthetic.render("street", 3, rig=SMALL)
    second = sr.recalibrate(first.rig, street.pairs, prior=first.prior, free=("extrinsics", "baseline"))
    assert second.prior_use.name == "saved"
    low, high = second.estimate.intervals[length]
    apart = abs(100 * (SMALL.baseline / first.rig.baseline - 1) - (low + high) / 2)
    assert apart < 0.75 * (high - low)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ((0, (10.0, 10.0), -1.0), "metres"),
        ((0, (10.0, 10.0), float("nan")), "metres"),
        ((0, (10.0, 10.0), 1.0, 0.0), "positive"),
        ((0, (10.0, float("nan")), 1.0), "column, row"),
    ],
)
def test_ranges_that_make_no_sense(values, said):
    with pytest.raises(sr.InputError, match=said):
        sr.Range(*values)


@pytest.mark.slow
def test_names_that_several_pairs_have(harbour):
    """Scene folders call every pair the same."""
    street = sr.synthetic.render("street", 3)
    scenes = [
        sr.Scene(s.name, longer(RIG, 2.0), tuple(sr.Pair(p.left, p.right, "left.png") for p in s.pairs))
        for s in (harbour, street)
    ]
    with pytest.raises(sr.InputError, match="2 pairs have that name"):
        sr.recalibrate_many(scenes, ranges=[sr.Range("left.png", (50.0, 50.0), 3.0)])
    with pytest.raises(sr.InputError, match="no such pair was given"):
        sr.recalibrate_many(scenes, ranges=[sr.Range(0, (50.0, 50.0), 3.0)])
    named = [sr.Range(f"{harbour.name}/left.png", r.left_pixel, r.metres) for r in some()]
    for repair in sr.recalibrate_many(scenes, ranges=named):
        assert abs(100 * (repair.solution.rig.baseline / RIG.baseline - 1)) < 0.8


def test_ranges_of_nothing(small):
    with pytest.raises(sr.InputError, match="no such pair was given"):
        sr.recalibrate(SMALL, small.pairs, ranges=[sr.Range("other", (1.0, 1.0), 3.0)])
    with pytest.raises(sr.InputError, match="outside of the 320x240 image"):
        sr.recalibrate(SMALL, small.pairs, ranges=[sr.Range(0, (320.0, 1.0), 3.0)])
