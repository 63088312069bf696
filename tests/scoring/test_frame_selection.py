"""A few frames that stand for many: textured, and spread over the recording."""

from dataclasses import replace

import numpy as np
from hypothesis import given, strategies as st

from stereorecal.recordings import Pair
from stereorecal.scoring import pyramid, select_frames


def pair(contrast: float, name: str) -> Pair:
    noise = np.random.default_rng(0).uniform(-1, 1, (48, 64)).astype(np.float32)
    image = np.kron(noise[:12, :16], np.ones((4, 4), np.float32)) * contrast + 128
    return Pair(image, image, name)


@given(contrasts=st.lists(st.floats(0.01, 20), min_size=1, max_size=12, unique=True), most=st.integers(1, 12))
def test_the_best_of_each_stretch(contrasts, most):
    pairs = [pair(c, str(i)) for i, c in enumerate(contrasts)]
    chosen = [int(p.name) for p in select_frames(pairs, most)]
    assert chosen == sorted(chosen)
    assert len(chosen) == min(most, len(pairs))
    assert int(np.argmax(contrasts)) in chosen
    stretch = len(pairs) / len(chosen)
    assert all(abs(c - stretch * (i + 0.5)) <= stretch / 2 + 1 for i, c in enumerate(chosen))


@given(
    contrasts=st.lists(st.floats(0.01, 20), min_size=2, max_size=16, unique=True),
    most=st.integers(2, 12),
    apart=st.sets(st.integers(0, 15)),
)
def test_the_best_of_each_stretch_with_a_neighbour(contrasts, most, apart):
    """Some pairs do not follow the one before."""
    pairs = [pair(c, str(i)) for i, c in enumerate(contrasts)]
    chosen = [int(p.name) for p in select_frames(pairs, most, lambda first, second: int(second.name) not in apart)]
    assert chosen == sorted(set(chosen))
    assert len(chosen) <= most
    if len(pairs) <= most:
        assert len(chosen) == len(pairs)
        return
    best = [int(p.name) for p in select_frames(pairs, most // 2)]
    assert set(best) <= set(chosen)
    for number in set(chosen) - set(best):  # the next one that follows, or one that it follows
        assert any(
            max(number, other) not in apart and (number < other or set(range(other + 1, number)) <= apart)
            for other in best
        )


def test_the_neighbour_is_the_last_one_that_is_far_enough_before():
    """Where what follows must be some pairs away, and the best one is too near to the end to have one after it."""
    pairs = [pair(20.0 if number == 6 else 1.0 + 0.1 * number, str(number)) for number in range(8)]
    chosen = select_frames(pairs, 2, lambda first, second: int(second.name) - int(first.name) >= 3)
    assert [one.name for one in chosen] == ["3", "6"]


def test_a_foggy_frame_is_not_looked_at(scene):
    given = scene(frames=2)
    assert given.rig is not None
    fog = replace(given.pairs[0], left=given.pairs[0].left * 0.01 + 120, right=given.pairs[0].right * 0.01 + 120)
    images = pyramid(given.rig, [fog, given.pairs[1]])
    np.testing.assert_array_equal(images.at(1.0, 1).left[0], given.pairs[1].left)
    assert len(images.at(1.0).left) == 2
    assert images.at(1.0, 7) is images.at(1.0)
