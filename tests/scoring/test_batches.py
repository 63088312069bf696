"""A count belongs to its candidate: it does not know which others were asked with it, or in which order."""

from dataclasses import dataclass
from typing import ClassVar

import machine
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.geometry import view, with_unit_baseline
from stereorecal.matching import BM, SAD
from stereorecal.scoring import prepare
from stereorecal.scoring.host import _disparities, counts, counts_at_once, counts_by_tile, disparities

SAD_24, SAD_32 = SAD(num_disparities=24), SAD(num_disparities=32)
SMALL, LARGE = ((160, 120), SAD_24), ((320, 240), SAD_32)
angles = st.floats(-0.05, 0.05)
shifts = st.floats(-0.05, 0.05)
candidates = st.lists(st.tuples(angles, angles, angles, st.just(0.0), shifts, shifts), min_size=1, max_size=6)


@settings(max_examples=max(4, settings.default.max_examples // 5))
@given(offsets=candidates, asked=st.sampled_from([SMALL, LARGE]), data=st.data())
def test_batch_size_and_order_do_not_matter(scene, offsets, asked, data):
    """Small frames share a call of one program, larger ones have each candidate on its own."""
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


def test_candidates_differ(scene):
    """Else the property above would hold for a constant."""
    given_scene = scene()
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = with_unit_baseline(given_scene.rig.extrinsics) + np.array([[0.002 * i, 0, 0, 0, 0, 0] for i in range(4)])
    assert len(set(counts(prepared, points, SAD_32))) == 4


@pytest.mark.parametrize("matcher", [SAD_32, BM(num_disparities=32)])
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
    at_once, one_by_one = (f(prepared, points, SAD_32) for f in (counts_at_once, counts))
    assert at_once.shape == (130,)
    np.testing.assert_allclose(at_once, one_by_one, rtol=2e-3)  # two programs round differently
    assert counts_at_once(prepared, points[:0], SAD_32).shape == (0,)


# --- blocks of rows -----------------------------------------------------------------------------------------


@settings(max_examples=40)
@given(height=st.integers(16, 2000), cores=st.integers(1, 64), block_size=st.sampled_from([3, 11, 31]))
def test_blocks_cover_every_row_once_with_their_halo(height, cores, block_size):
    matcher = SAD(block_size=block_size)
    with machine.cores(cores):
        blocks = _disparities.blocks(height, matcher)
    rows = [np.arange(height)[block.given] for block in blocks]
    assert len({len(seen) for seen in rows}) == 1  # one program for all
    kept = [seen[block.used] for seen, block in zip(rows, blocks, strict=True)]
    np.testing.assert_array_equal(np.concatenate(kept), np.arange(height))
    for seen, own in zip(rows, kept, strict=True):
        assert seen[0] <= max(0, own[0] - matcher.halo)
        assert seen[-1] >= min(height - 1, own[-1] + matcher.halo)


@dataclass(frozen=True)
class RowByRow(SAD):
    """A matcher whose own search needs no other row."""

    halo: ClassVar[int] = 0


def test_the_texture_check_needs_its_window_whatever_the_matcher_needs():
    with machine.cores(2):
        first, second = _disparities.blocks(480, RowByRow(block_size=11))
    assert first.given == slice(0, 252)
    assert second.used == slice(12, 252)


def test_a_matcher_that_looks_everywhere_sees_the_frame_whole():
    with machine.cores(8):
        assert len(_disparities.blocks(2000, BM())) == 1


@pytest.mark.slow
def test_blocks_change_nothing(scene):
    """The middle one of three has a halo on both sides."""
    given_scene = scene("harbour", 0, (320, 480))
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    extrinsics = with_unit_baseline(given_scene.rig.extrinsics)
    found = []
    for number in (1, 3):
        with machine.cores(number):
            assert len(_disparities.blocks(480, SAD_32)) == number
            found += disparities(prepared, extrinsics, SAD_32)
    for name in ("values", "valid"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


@pytest.mark.parametrize("size", [(160, 120), (200, 130)])
def test_tiles_add_up(scene, size):
    """Of sizes that eight by six tiles divide evenly or not; and each counts its own pixels."""
    given_scene = scene("harbour", 0, size, 2)
    data = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = with_unit_baseline(given_scene.rig.extrinsics) + np.array([[0.0] * 6, [0.01, 0, 0, 0, 0, 0]])
    tiles = counts_by_tile(data, points, BM(num_disparities=24))
    assert tiles.shape == (2, 2, 48)
    np.testing.assert_array_equal(tiles.sum(axis=(1, 2)), counts(data, points, BM(num_disparities=24)))
    valid = disparities(data, points[0], BM(num_disparities=24))[1].valid
    height, width = valid.shape
    assert tiles[0, 1, 8 * 1 + 3] == valid[height // 6 : 2 * height // 6, 3 * width // 8 : 4 * width // 8].sum()
