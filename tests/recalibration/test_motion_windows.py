"""Motion in a repair: the tracker, which pairs follow each other, and what is refused."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from parts_of_repairs import MOST_WINDOWS, check_odometer, following
from scipy.ndimage import fourier_shift

import stereorecal as sr
from stereorecal import InputError
from stereorecal.recalibration import chosen_frames
from stereorecal.recordings import share_of
from stereorecal.scoring.host import Matches, tracked

RNG = np.random.default_rng(0)
TEXTURE = cv2.GaussianBlur(RNG.uniform(0, 255, (200, 260)).astype(np.float32), (0, 0), 2.0)
TEXTURE = (TEXTURE - TEXTURE.min()) / np.ptp(TEXTURE) * 255.0


def moved(x: float, y: float) -> np.ndarray:
    """The texture, shifted without any interpolation."""
    waves = fourier_shift(np.fft.fft2(TEXTURE), (y, x))
    return np.fft.ifft2(waves).real.clip(0, 255).astype(np.float32)


def test_the_tracker_follows_shifts_to_a_twentieth_of_a_pixel():
    first, second = sr.make_pair(moved(0, 0), moved(-9.25, 0.5)), sr.make_pair(moved(3.5, -2.25), moved(-6.75, -1.75))
    grid = np.stack(np.meshgrid(np.arange(20, 240, 5.0), np.arange(20, 180, 5.0)), axis=-1).reshape(-1, 2)
    matches = Matches(grid, grid - np.array([9.0, 0.0])), Matches(grid, grid - np.array([10.0, 0.0]))
    seen = tracked(first, second, matches, radius=5.0)
    assert len(seen) > 30
    for found, expected in (
        (seen.left[1] - seen.left[0], (3.5, -2.25)),
        (seen.right[0] - seen.left[0], (-9.25, 0.5)),
        (seen.right[1] - seen.left[1], (-10.25, 0.5)),
    ):
        np.testing.assert_allclose(np.median(found, axis=0), expected, atol=0.05)


def taken(*times: float | None) -> list[sr.Pair]:
    """Pairs of these times, none of which is another one again."""
    left, right = moved(0, 0), moved(-9, 0)
    return [replace(sr.make_pair(left + 1e-3 * n, right), time=time) for n, time in enumerate(times)]


def test_times_tell_which_pairs_follow_each_other():
    """Soon after the one before: not at the same time, not long after, not before."""
    times = (0.0, 0.1, 0.2, 0.2, 1.9, 2.0, 1.0, None, 1.2)
    windows = ((0, 1), (1, 2), (4, 5))
    assert following(taken(*times), range(9), None, None) == windows
    assert following(taken(*times), range(9), None, "exact") == ()
    assert following(taken(*times), range(9), False, None) == ()


@pytest.mark.parametrize(("rate", "apart"), [(30, 3), (20, 2), (10, 1), (2, 1)])
def test_of_fast_videos_pairs_follow_that_have_moved(rate, apart):
    """A thirtieth of a second moves nothing by more than it can be measured."""
    pairs = taken(*(1e9 + np.arange(12) / rate).tolist())
    windows = following(pairs, range(12), None, None)
    assert windows
    assert {later - first for first, later in windows} == {apart}


@pytest.mark.parametrize("rate", [100, 30, 10, 3])
def test_of_long_recordings_pairs_are_chosen_that_have_moved(rate):
    pairs = taken(*(np.arange(240) / rate).tolist())
    chosen = chosen_frames(pairs, 8)
    apart = np.diff([pair.time for pair in chosen])
    assert len(chosen) == 8
    assert np.all(apart[::2] >= 0.09)
    assert np.all(apart[::2] <= 0.5)
    assert len(following(chosen, range(8), None, None)) >= 4


def test_pairs_follow_each_other_where_none_between_is_missing():
    assert following(taken(*[None] * 5), (0, 1, 3, 4, 9), True, None) == ((0, 1), (2, 3))
    many = following(taken(*[None] * 100), range(100), True, None)
    assert len(many) == MOST_WINDOWS
    assert many[0] == (0, 1)
    assert many[-1] == (98, 99)


def test_what_cannot_move_is_refused(scene):
    street = scene("street", 3, (320, 240))
    rig, pairs = street.rig, street.pairs
    for options, said in (
        ({"motion": True}, "two consecutive pairs"),
        ({"motion": "yes"}, "motion is 'yes'"),
    ):
        with pytest.raises(sr.InputError, match=said):
            sr.recalibrate(rig, pairs[:1], **options)
    with pytest.raises(sr.InputError, match="exact"):
        sr.recalibrate(rig, [pairs[0], pairs[0]], motion=True, prior="exact")


def test_an_odometer_that_knows_nothing_of_the_pairs_is_refused():
    pairs = taken(0.0, 0.1, 0.2)
    check_odometer(sr.Odometer(np.array([0.0, 0.15]), np.array([0.0, 1.0])), pairs, ((0, 1), (1, 2)))
    in_ms = sr.Odometer(np.array([1000.0, 2000.0]), np.array([0.0, 1.0]))
    with pytest.raises(sr.InputError, match=r"1000 to 2000 s, those of the pairs 0 to 0\.2 s"):
        check_odometer(in_ms, pairs, ((0, 1), (1, 2)))
    with pytest.raises(sr.InputError, match="there are none"):
        check_odometer(in_ms, pairs, ())


@pytest.mark.parametrize("motion", [None, True])
def test_pairs_that_a_recording_repeats_show_no_motion(motion):
    pairs = taken(0.0, 0.1, 0.2, 0.3)
    pairs[2] = replace(pairs[1], time=0.2)
    assert following(pairs, range(4), motion, None) == ((0, 1), (2, 3))


def test_rolling_shutters_need_times():
    """The readout counts as its share of the time between two pairs; where times do not tell it, motion is refused."""
    pairs = [pair.read_out(0.02) for pair in taken(0.0, 0.1)]
    assert following(pairs, range(2), None, None) == ((0, 1),)
    assert share_of(*pairs) == pytest.approx(0.2)
    assert share_of(*taken(None, None)) == 0.0
    for times in ((None, None), (0.0, 0.01), (0.1, 0.0)):
        wrong = [pair.read_out(0.02) for pair in taken(*times)]
        with pytest.raises(InputError, match="rolling shutters read an image in"):
            following(wrong, range(2), True, None)
        assert following(wrong, range(2), False, None) == ()


def test_partners_are_looked_for_where_their_own_pair_matches():
    """Things that come nearer have another disparity a moment later."""
    first, second = sr.make_pair(moved(0, 0), moved(-9.25, 0.5)), sr.make_pair(moved(3.5, -2.25), moved(-14.5, -1.75))
    grid = np.stack(np.meshgrid(np.arange(20, 240, 5.0), np.arange(20, 180, 5.0)), axis=-1).reshape(-1, 2)
    seen = tracked(first, second, (Matches(grid, grid - [9.0, 0.0]), Matches(grid, grid - [18.0, 0.0])), radius=5.0)
    assert len(seen) > 30
    np.testing.assert_allclose(np.median(seen.right[1] - seen.left[1], axis=0), (-18.0, 0.5), atol=0.05)
