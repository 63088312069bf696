"""What is taken for image pairs, and what is refused in one sentence."""

import subprocess
import sys

import numpy as np
import pytest

import stereorecal as sr
from stereorecal import InputError
from stereorecal.recordings import Pair, as_pairs, make_pair

CALL = "give pairs such as sr.io.load_pairs('left/*.png', 'right/*.png'), or tuples (left, right) of arrays."


def image(seed: int, dtype: type = np.uint8, channels: int = 0) -> np.ndarray:
    shape = (16, 24, channels) if channels else (16, 24)
    return np.random.default_rng(seed).integers(0, 255, shape).astype(dtype)


LEFT, RIGHT = image(0), image(1)
PAIR = make_pair(LEFT, RIGHT, name="mine")


@pytest.mark.parametrize("given", [PAIR, [PAIR], (PAIR,)])
def test_pairs_are_themselves(given):
    assert as_pairs(given) == (PAIR,)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("channels", [0, 3])
@pytest.mark.parametrize("wrap", [lambda p: p, lambda p: [p], lambda p: (p,), lambda p: [list(p)]])
def test_tuples_of_arrays_are_pairs(dtype, channels, wrap):
    left, right = image(0, dtype, channels), image(1, dtype, channels)
    (pair,) = as_pairs(wrap((left, right)))
    grey_levels = dtype in (np.float32, np.float64) and not channels  # up to 255: they stay as they are
    expected = Pair(left.astype(np.float32), right.astype(np.float32)) if grey_levels else make_pair(left, right)
    np.testing.assert_array_equal(pair.left, expected.left)
    np.testing.assert_array_equal(pair.right, expected.right)
    assert pair.left.dtype == np.float32
    assert pair.name == "pair 0"


def test_the_arrays_of_a_pair_are_that_pair():
    """And darker ones are not made brighter."""
    (again,) = as_pairs((PAIR.left / 2, PAIR.right / 2))
    np.testing.assert_array_equal(again.left, PAIR.left / 2)
    (unit,) = as_pairs((PAIR.left / 255, PAIR.right / 255))  # floats up to 1 are no grey levels
    assert max(unit.left.max(), unit.right.max()) == 255.0


def test_a_list_of_two_arrays_is_one_pair_and_two_tuples_are_two():
    assert len(as_pairs([LEFT, RIGHT])) == 1
    assert [pair.name for pair in as_pairs([(LEFT, RIGHT), (image(2), image(3))])] == ["pair 0", "pair 1"]


def test_kinds_may_be_mixed():
    both = as_pairs([PAIR, (LEFT, RIGHT)])
    assert [pair.name for pair in both] == ["mine", "pair 1"]
    np.testing.assert_array_equal(both[0].left, both[1].left)
    assert as_pairs([]) == ()  # which is left to those who need one


@pytest.mark.parametrize(
    ("given", "what"),
    [
        ("left/*.png", "pairs is a str"),
        (b"left.png", "pairs is a bytes"),
        (LEFT, "pairs is an array of shape (16, 24)"),
        (np.stack([LEFT, RIGHT]), "pairs is an array of shape (2, 16, 24)"),
        (None, "pairs is a NoneType"),
        (7, "pairs is a int"),
        ({"left": LEFT}, "pairs is a dict"),
        (iter([PAIR]), "pairs is a list_iterator"),
        (["left.png", "right.png"], "pair 0 is a str"),
        ([LEFT], "pair 0 is an array of shape (16, 24)"),
        ([PAIR, LEFT], "pair 1 is an array of shape (16, 24)"),
        ([(LEFT, RIGHT, RIGHT)], "pair 0 is a tuple"),
        ([PAIR, None], "pair 1 is a NoneType"),
        ([(LEFT.tolist(), RIGHT.tolist())], "pair 0 is a tuple of list and list"),
    ],
)
def test_what_is_none_is_refused_in_one_sentence(given, what):
    with pytest.raises(InputError) as refusal:
        as_pairs(given)
    assert str(refusal.value) == f"{what}; {CALL}"


@pytest.fixture(scope="module")
def small(scene):
    given = scene(size=(160, 120))
    (pair,) = given.pairs
    return given.rig, pair, (pair.left.round().astype(np.uint8), pair.right.round().astype(np.uint8))


@pytest.mark.parametrize("matcher", ["sad", "bm", "sgbm"])
def test_score_takes_arrays_and_names(small, matcher):
    """Rendered images are whole grey levels, so that bytes lose nothing."""
    rig, _, arrays = small
    exact = Pair(*(side.astype(np.float32) for side in arrays), name="bytes")
    scores = [sr.score(rig, given, matcher=matcher) for given in (exact, [exact], arrays, [arrays])]
    assert len(set(scores)) == 1
    assert scores[0].count > 3000


def test_everything_that_takes_pairs_takes_arrays(small):
    rig, _, arrays = small
    matcher = sr.SAD(num_disparities=24)
    count = sr.score(rig, arrays, matcher=matcher).count
    assert int(sr.count(sr.prepare(rig, arrays), rig.extrinsics, matcher)) == pytest.approx(count, abs=2)
    assert sr.objective(rig, arrays, matcher=matcher).value(np.zeros(5)) == count
    assert sr.disparity(rig, arrays, matcher=matcher).valid.sum() == count
    assert sr.rectify(rig, arrays)[0].shape == (120, 160)
    assert sr.health(rig, arrays, matcher=matcher).score_before.count == count
    assert sr.with_disparity_range("sgbm", rig, arrays).num_disparities >= 16


AS_A_USER = """
import numpy as np, stereorecal as sr
rig = sr.synthetic.default_rig().resized((160, 120))
for function in (sr.score, sr.prepare, sr.objective, sr.health, sr.recalibrate, sr.rectify, sr.disparity):
    for given in ("left/*.png", np.ones((120, 160), np.uint8), None, ["left.png"]):
        try:
            function(rig, given)
            print(function.__name__, "took it")
        except sr.InputError as error:
            print(error)
images = tuple(np.random.default_rng(0).integers(0, 255, (2, 120, 160), np.uint8))
for function in (sr.score, sr.objective, sr.health, sr.recalibrate):
    for matcher in (sr.SGBM, 48):
        try:
            function(rig, images, matcher=matcher)
            print(function.__name__, "took it")
        except sr.InputError as error:
            print(error)
"""


def test_every_front_door_says_so():
    """As users run it: without the checks of types that this suite makes."""
    told = subprocess.run([sys.executable, "-c", AS_A_USER], capture_output=True, text=True, check=True).stdout
    said = told.splitlines()
    shapes = ["pairs is a str", "pairs is an array of shape (120, 160)", "pairs is a NoneType", "pair 0 is a str"]
    assert said[: 7 * 4] == 7 * [f"{what}; {CALL}" for what in shapes]
    assert [line.split(";")[0] for line in said[28:]] == 4 * ["matcher is the class SGBM", "matcher is a int"]


@pytest.mark.parametrize("function", [sr.score, sr.prepare, sr.objective, sr.health, sr.recalibrate])
def test_no_pair_at_all(small, function):
    with pytest.raises(InputError, match="no image pair was given; give at least one"):
        function(small[0], [])
