"""A count belongs to its candidate: it does not know which others were asked with it, or in which order."""

from dataclasses import dataclass

import machine
import numpy as np
import pytest
from fixtures import SAD_48
from hypothesis import given, settings, strategies as st
from parts_of_estimates import counts_at_once

from stereorecal.geometry import Camera, StereoRig, view, with_unit_baseline
from stereorecal.matching import BM, SAD, AbstractMatcher, Disparity
from stereorecal.recordings import Pair
from stereorecal.scoring import ScoringData, prepare
from stereorecal.scoring.host import counts, counts_by_tile, disparities

SAD_24 = SAD(num_disparities=24)
angles = st.floats(-0.05, 0.05)
shifts = st.floats(-0.05, 0.05)
candidates = st.lists(st.tuples(angles, angles, angles, st.just(0.0), shifts, shifts), min_size=1, max_size=6)


@settings(max_examples=max(4, settings.default.max_examples // 5))
@given(offsets=candidates, asked=st.sampled_from([((160, 120), SAD_24), ((320, 240), SAD_48)]), data=st.data())
def test_batch_size_and_order_do_not_matter(scene, offsets, asked, data):
    """Counts are the same in any batch and order, of frames that are matched whole and in blocks."""
    size, matcher = asked
    given_scene = scene("harbour", 0, size)
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = with_unit_baseline(given_scene.rig.extrinsics) + np.array(offsets)
    order = np.array(data.draw(st.permutations(range(len(points)))))
    cut = data.draw(st.integers(0, len(points)))
    together = counts(prepared, points, matcher)
    shuffled = counts(prepared, points[order], matcher)
    parts = np.concatenate([counts(prepared, part, matcher) for part in (points[:cut], points[cut:])])
    alone = [int(counts(prepared, point[None], matcher)[0]) for point in points]
    assert np.array_equal(shuffled, together[order])
    assert np.array_equal(parts, together)
    assert np.array_equal(alone, together)


@pytest.mark.parametrize("matcher", [SAD_48, BM(num_disparities=48)])
def test_no_candidates_no_counts(scene, matcher):
    given_scene = scene()
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    assert counts(prepared, np.zeros((0, 6)), matcher).shape == (0,)


@pytest.mark.slow
def test_all_at_once_as_one_by_one(scene):
    """The way of a GPU: the last of three batches of 64 is padded."""
    given_scene = scene("harbour", 0, (80, 60))
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = with_unit_baseline(given_scene.rig.extrinsics) + np.linspace(0, 0.02, 130)[:, None] * np.eye(6)[0]
    at_once, one_by_one = (f(prepared, points, SAD_48) for f in (counts_at_once, counts))
    assert at_once.shape == (130,)
    np.testing.assert_allclose(at_once, one_by_one, rtol=2e-3)  # two programs round differently
    assert counts_at_once(prepared, points[:0], SAD_48).shape == (0,)


# --- blocks of rows -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reading(AbstractMatcher):
    """Reads the number of each row, and says the first and the last one that it was given with it."""

    reach: int | None = 0

    @property
    def halo(self) -> int | None:
        return self.reach

    def match(self, left, right):
        rows = np.rint(256.0 * left[:, 8] + left[:, 16])
        told = np.column_stack([rows, np.full_like(rows, rows[0]), np.full_like(rows, rows[-1])])
        values = np.zeros(left.shape, np.float32)
        values[:, :3] = told
        return Disparity(values, np.ones(left.shape, bool))

    search = match


@pytest.fixture(scope="module")
def numbered() -> ScoringData:
    """487 rows with their numbers in the left image."""
    camera = Camera((24, 487), np.array([[100.0, 0.0, 11.5], [0.0, 100.0, 243.0], [0.0, 0.0, 1.0]]))
    rig = StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -0.1, 0.0, 0.0]))
    image = np.zeros((487, 24), np.float32)
    image[:, 5:11], image[:, 13:20] = (np.arange(487)[:, None] // 256), (np.arange(487)[:, None] % 256)
    return prepare(rig, [Pair(image, 255.0 - image)], view(rig))


def told_by(matcher: Reading, numbered: ScoringData, cores: int) -> np.ndarray:
    """For each row what `Reading` tells."""
    with machine.cores(cores):
        (found,) = disparities(numbered, np.array([0.0, 0.0, 0.0, -1.0, 0.0, 0.0]), matcher)
    rows, first, last = found.values[:, :3].T.astype(int)
    np.testing.assert_array_equal(rows, np.arange(487))
    return np.stack([first, last])


@given(reach=st.integers(0, 40), cores=st.integers(1, 64), block_size=st.sampled_from([3, 11, 31]))
def test_every_row_is_matched_once_and_with_its_halo(numbered, reach, cores, block_size):
    first, last = told_by(Reading(reach=reach, block_size=block_size), numbered, cores)
    assert len(set(last - first)) == 1  # one program for all
    assert (first <= np.maximum(0, np.arange(487) - reach)).all()
    assert (last >= np.minimum(486, np.arange(487) + reach)).all()
    assert len(set(first)) <= cores


@pytest.mark.parametrize(("cores", "expected"), [(1, 1), (2, 2), (3, 3), (64, 4)])
def test_there_are_as_many_blocks_as_cores_unless_their_halos_cost_a_tenth(numbered, cores, expected):
    first, last = told_by(Reading(reach=6, block_size=11), numbered, cores)
    assert len(set(first)) == expected
    assert set(last - first + 1) == {min(487, -(-487 // expected) + 12)}


def test_the_texture_check_needs_its_window_whatever_the_matcher_needs(numbered):
    first, last = told_by(Reading(reach=0, block_size=11), numbered, 2)
    np.testing.assert_array_equal(last - first + 1, 244 + 12)


def test_a_matcher_that_looks_everywhere_sees_the_frame_whole(numbered):
    first, last = told_by(Reading(reach=None), numbered, 8)
    assert (first.max(), last.min()) == (0, 486)


@pytest.mark.slow
def test_blocks_change_nothing(scene):
    """The middle one of three has a halo on both sides."""
    given_scene = scene("harbour", 0, (320, 480))
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    extrinsics = with_unit_baseline(given_scene.rig.extrinsics)
    found = []
    for number in (1, 3):
        with machine.cores(number):
            found += disparities(prepared, extrinsics, SAD_48)
    for name in ("values", "valid"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


@pytest.mark.parametrize("size", [(160, 120), (168, 124)])
def test_tiles_add_up(scene, size):
    """Tiles add up in sizes that eight by six of them divide evenly or not; and each counts its own pixels."""
    given_scene = scene("harbour", 0, size, 2)
    data = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = with_unit_baseline(given_scene.rig.extrinsics) + np.array([[0.0] * 6, [0.01, 0, 0, 0, 0, 0]])
    tiles = counts_by_tile(data, points, BM(num_disparities=24))
    assert tiles.shape == (2, 2, 48)
    np.testing.assert_array_equal(tiles.sum(axis=(1, 2)), counts(data, points, BM(num_disparities=24)))
    valid = disparities(data, points[0], BM(num_disparities=24))[1].valid
    height, width = valid.shape
    assert tiles[0, 1, 8 * 1 + 3] == valid[height // 6 : 2 * height // 6, 3 * width // 8 : 4 * width // 8].sum()
