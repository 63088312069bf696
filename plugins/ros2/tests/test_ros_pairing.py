"""Pairs by stamps: bounded, counted, and the same as a search of all stamps would find."""

from hypothesis import given, strategies as st
from stereorecal_ros import LEFT, MOST, RIGHT, Pairing

MS = 1_000_000
SECOND = 1000 * MS


def fed(pairing: Pairing, *images: tuple[int, int]) -> tuple[Pairing, list[tuple[int, int]]]:
    """After images, each a side and a stamp, which is the item, too; and the pairs."""
    pairs = []
    for side, stamp in images:
        pairing, pair = pairing.with_image(side, stamp, stamp)
        pairs += [] if pair is None else [pair]
    return pairing, pairs


@st.composite
def recordings(draw):
    """Two sides of about 30 Hz with jitter and gaps, and an order of arrival that keeps that of each side."""
    sides: list[list[int]] = []
    for _ in range(2):
        numbers = sorted(draw(st.sets(st.integers(0, 30), max_size=20)))
        sides.append([33 * MS * number + draw(st.integers(0, 8 * MS)) for number in numbers])
    tolerance = draw(st.integers(0, 8 * MS))
    # One side is late by a few images at most.
    late = draw(st.integers(-2 * 33 * MS, 2 * 33 * MS))
    arrivals = sorted((stamp + late * side, side, stamp) for side in (LEFT, RIGHT) for stamp in sides[side])
    return sides, tolerance, [(side, stamp) for _, side, stamp in arrivals]


@given(recordings())
def test_pairs_are_those_of_a_search_of_all_stamps(recording):
    (left, right), tolerance, arrivals = recording
    wanted = [(one, other) for one in left for other in right if abs(one - other) <= tolerance]
    pairing, pairs = fed(Pairing(tolerance), *arrivals)
    assert pairs == wanted
    assert pairing.paired == len(pairs)
    waiting = sum(map(len, pairing.waiting))
    assert 2 * len(pairs) + pairing.unpaired + waiting == len(left) + len(right)
    assert pairing.late == pairing.jumps == 0


@given(st.lists(st.tuples(st.sampled_from([LEFT, RIGHT]), st.integers(-(10**12), 10**12)), max_size=60))
def test_whatever_comes_is_bounded_and_counted(arrivals):
    pairing = Pairing(5 * MS)
    for number, (side, stamp) in enumerate(arrivals, start=1):
        pairing, pair = pairing.with_image(side, stamp, stamp)
        assert pair is None or abs(pair[0] - pair[1]) <= 5 * MS
        assert all(len(side) <= MOST for side in pairing.waiting)
        waiting = sum(map(len, pairing.waiting))
        assert 2 * pairing.paired + pairing.unpaired + pairing.late + waiting == number


def test_a_silent_side_keeps_no_more_than_a_few():
    pairing, pairs = fed(Pairing(5 * MS), *((LEFT, number * 33 * MS) for number in range(1000)))
    assert pairs == []
    assert len(pairing.waiting[LEFT]) == MOST
    assert pairing.unpaired == 1000 - MOST
    assert pairing.apart is None


def test_stamps_that_lie_apart_are_told():
    pairing, pairs = fed(Pairing(5 * MS), (LEFT, 0), (RIGHT, 16 * MS), (LEFT, 33 * MS), (RIGHT, 49 * MS))
    assert pairs == []
    assert pairing.apart == 16 * MS


def test_left_stays_left():
    for images in ([(LEFT, 1), (RIGHT, 2)], [(RIGHT, 2), (LEFT, 1)]):
        assert fed(Pairing(5 * MS), *images)[1] == [(1, 2)]


def test_time_that_jumps_back():
    start = [(side, 100 * SECOND + number * 100 * MS) for number in range(3) for side in (LEFT, RIGHT)]
    again = [(side, number * 100 * MS) for number in range(3) for side in (LEFT, RIGHT)]
    pairing, pairs = fed(Pairing(5 * MS), *start, *again)
    assert pairing.jumps == 1
    assert len(pairs) == 6
    twice, pairs = fed(Pairing(5 * MS), *start, *start[-2:])
    assert twice.late == 2
    assert len(pairs) == 3
