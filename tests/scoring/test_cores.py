"""Work spread over the cores: in order, one level deep, and errors come through."""

import threading
from dataclasses import dataclass, field

import numpy as np
import pytest
from machine import cores

from stereorecal import MatcherError
from stereorecal.geometry import with_unit_baseline
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.recordings import Pair
from stereorecal.scoring import ScoringData, prepare
from stereorecal.scoring.host import counts_by_tile
from stereorecal.synthetic import default_rig

RIG = default_rig().resized((160, 120))
MAIN = threading.main_thread()


@pytest.fixture(autouse=True)
def two_cores():
    with cores(2):
        yield


@dataclass(frozen=True)
class Watched(AbstractMatcher):
    """Finds all that is bright, once it has said on which thread it looks at which frame."""

    seen: list = field(default_factory=list, compare=False)
    fails_at: int | None = None

    def match(self, left, right):
        frame = int(np.rint(left[60, 80]))
        self.seen.append((threading.current_thread(), frame))
        if frame == self.fails_at:
            raise ValueError("three")
        return Disparity(np.zeros(left.shape, np.float32), np.asarray(left) > 100.0)

    search = match


@pytest.fixture(scope="module")
def frames() -> list[ScoringData]:
    """Data of one to five pairs, whose middles are as bright as their numbers; their edges come and go with a pitch."""
    pairs = []
    for number in range(5):
        left = np.where(np.abs(np.arange(120.0) - 60.0)[:, None] < 50.0, number, 200.0) * np.ones((120, 160))
        pairs.append(Pair(left.astype(np.float32), np.float32(255.0) - left.astype(np.float32)))
    return [prepare(RIG, pairs[:number]) for number in range(1, 6)]


def candidates(number: int) -> np.ndarray:
    pitch = np.linspace(-0.05, 0.05, number)[:, None] * np.eye(6)[0]
    return with_unit_baseline(RIG.extrinsics) + pitch


def test_order_is_kept_and_threads_are_used(frames):
    matcher, points = Watched(), candidates(20)
    found = counts_by_tile(frames[0], points, matcher).sum(axis=(1, 2))
    assert len(matcher.seen) == 20
    assert MAIN not in {thread for thread, _ in matcher.seen}
    assert len(set(found)) > 10
    np.testing.assert_array_equal(found, [counts_by_tile(frames[0], one[None], matcher).sum() for one in points])


def test_a_piece_of_such_work_stays_on_its_thread(frames):
    """Else pieces would wait for pieces, for ever: all frames of a candidate, one after the other."""
    matcher = Watched()
    counts_by_tile(frames[4], candidates(8), matcher)
    for thread in {thread for thread, _ in matcher.seen}:
        of_thread = [frame for one, frame in matcher.seen if one is thread]
        assert of_thread == [*range(5)] * (len(of_thread) // 5)


def test_errors_come_through(frames):
    with pytest.raises(MatcherError, match="three"):
        counts_by_tile(frames[4], candidates(6), Watched(fails_at=3))
    assert len(counts_by_tile(frames[4], candidates(3), Watched())) == 3
