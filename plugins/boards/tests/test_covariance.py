"""Boards of the calibration: what they tell of it, what they do not, and what is refused."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from simulated_rows import chart as chart, rig as rig
from stereorecal_boards import Board, covariance_of_boards

import stereorecal as sr
from stereorecal import CalibrationCovariance
from stereorecal.geometry import rotation_from_vector, turned_pixels

NOISE = 0.15
GRID = np.column_stack([np.mgrid[0:9, 0:6].reshape(2, -1).T, np.zeros(54)])


def seen_by(rig: sr.StereoRig, points: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> list[np.ndarray]:
    """Pixels in both images, by OpenCV."""
    at = points @ cv2.Rodrigues(np.asarray(turn, float))[0].T + shift
    poses = ((np.eye(3), np.zeros(3)), (np.asarray(rig.R), np.asarray(rig.T)))
    return [
        cv2.projectPoints(at, cv2.Rodrigues(R)[0], T, camera.matrix, camera.distortion)[0].reshape(-1, 2)
        for camera, (R, T) in zip((rig.left, rig.right), poses, strict=True)
    ]


def views(rig: sr.StereoRig, number: int = 12, seed: int = 0, noise: float = NOISE, square: float = 0.03) -> list:
    """Boards that fill a third of the image."""
    rng, boards = np.random.default_rng(seed), []
    points = square * GRID
    while len(boards) < number:
        shift = np.array([*rng.uniform(-0.2, 0.2, 2), rng.uniform(0.5, 1.0)]) - [0.06, 0.07, 0.0]
        pixels = seen_by(rig, points, rng.uniform(-0.6, 0.6, 3), shift)
        if all(((some > 5) & (some < np.array(rig.left.size) - 6)).all() for some in pixels):
            boards.append(Board(*(some + rng.normal(0.0, noise, some.shape) for some in pixels), points))
    return boards


@pytest.fixture(scope="module")
def boards(rig) -> list:
    return views(rig)


@pytest.fixture(scope="module")
def found(chart, boards) -> CalibrationCovariance:
    return covariance_of_boards(chart.rig, boards)


def covariance(said: CalibrationCovariance) -> np.ndarray:
    return np.asarray(said.covariance)


def deviations_apart(chart, said: CalibrationCovariance, rig: sr.StereoRig) -> float:
    """How far a rig is from what is said of it: its mean squared deviation, over all directions."""
    where = [chart.names.index(name) for name in said.names]
    off = chart.coordinates_of(rig)[where] - said.mean
    return float(off @ np.linalg.solve(covariance(said), off)) / len(off)


def moved(board: Board, left=0.0, right=0.0) -> Board:
    return Board(board.left + left, board.right + right, board.points)


# --- what they tell -------------------------------------------------------------------------------------------


def test_what_a_calibration_left_is_found(rig, chart):
    """Boards of another rig near the given one, as its calibration would have left it."""
    rng = np.random.default_rng(1)
    left = {"pitch": 0.1, "yaw": 0.2, "roll": 0.1, "y": 0.2, "z": 0.5, "f": 0.3, "cx": 2.0, "cy": 1.5, "k1": 0.005}
    sigmas = np.array([left.get(name.split(".")[-1], 0.0) for name in chart.names])
    for seed in range(3):
        truth = chart.rig_at(sigmas * rng.normal(size=chart.dim))
        said = covariance_of_boards(chart.rig, views(truth, seed=seed))
        assert deviations_apart(chart, said, truth) < 2.0
        assert deviations_apart(chart, said, rig) > 10.0


def test_of_boards_of_the_given_rig_nothing_is_left_but_their_noise(rig, chart, found):
    assert tuple(found.names) == tuple(chart.names)
    assert deviations_apart(chart, found, rig) < 2.0
    one, twelve = (
        np.sqrt(np.diag(covariance(prior))) for prior in (covariance_of_boards(chart.rig, views(rig, 1)), found)
    )
    assert (twelve < one).all()
    assert np.median(twelve / one) < 0.7


def test_spread_is_that_of_calibrations_of_other_noise(rig, chart):
    """Sets of boards: answers differ as much as each of them says, along what boards know best."""
    said = [covariance_of_boards(chart.rig, views(rig, 5, seed)) for seed in range(12)]
    narrow = [chart.names.index(name) for name in ("roll", "y", "left.f", "right.f")]
    apart = np.array([one.mean[narrow] for one in said])
    stated = np.sqrt(np.mean([np.diag(covariance(one))[narrow] for one in said], axis=0))
    ratio = np.sqrt(np.mean(apart**2, axis=0)) / stated
    assert (ratio > 0.3).all()
    assert (ratio < 1.4).all()


@settings(max_examples=4, deadline=None)
@given(turn=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), shift=st.floats(-2.0, 2.0), seed=st.integers(0, 9))
def test_nothing_depends_on_the_frame_of_the_board_or_the_order_of_corners(rig, chart, turn, shift, seed):
    boards = views(rig, 4, seed)
    order = np.random.default_rng(seed).permutation(54)
    turned = np.asarray(rotation_from_vector(np.array(turn)))
    others = [Board(b.left[order], b.right[order], b.points[order] @ turned.T + shift) for b in boards]
    one, other = (covariance_of_boards(chart.rig, some) for some in (boards, others[::-1]))
    scales = np.sqrt(np.diag(covariance(one)))
    np.testing.assert_allclose(one.mean / scales, other.mean / scales, rtol=0, atol=0.05)
    np.testing.assert_allclose(
        covariance(one) / np.outer(scales, scales), covariance(other) / np.outer(scales, scales), rtol=0, atol=0.05
    )


def test_noisier_boards_tell_less(rig, chart, found):
    noisy = covariance_of_boards(chart.rig, views(rig, noise=4 * NOISE))
    ratio = np.sqrt(np.diag(covariance(noisy)) / np.diag(covariance(found)))
    roll = chart.names.index("roll")
    assert 3.0 < ratio[roll] < 5.0
    assert (ratio > 0.95).all()


def test_boards_that_contradict_each_other_tell_less(rig, chart, found):
    """The roll is less certain where all right corners of each board are shifted, as by a mount that gives; yet single
    corners fit their board as well as ever, and no noise of theirs shows it."""
    rng = np.random.default_rng(5)
    shaken = [moved(board, right=[0.0, shift]) for board, shift in zip(views(rig), rng.normal(0, 1.0, 12), strict=True)]
    said = covariance_of_boards(chart.rig, shaken)
    roll = chart.names.index("roll")
    assert covariance(said)[roll, roll] > 3.0**2 * covariance(found)[roll, roll]


def test_a_few_wrong_corners_change_nothing(chart, found, boards):
    rng = np.random.default_rng(2)
    spoiled = []
    for board in boards:
        left, right = board.left.copy(), board.right.copy()
        left[rng.integers(54)] += rng.uniform(10, 60, 2)
        right[rng.integers(54)] -= rng.uniform(5, 30, 2)
        spoiled.append(Board(left, right, board.points))
    said = covariance_of_boards(chart.rig, spoiled)
    scales = np.sqrt(np.diag(covariance(found)))
    assert (np.abs(said.mean - found.mean) < 0.5 * scales).all()
    assert (np.sqrt(np.diag(covariance(said))) < 1.3 * scales).all()


def test_squares_stay_as_uncertain_as_they_were(chart, found):
    """Printed squares are off by 0.15 %; no board of them tells the length of the baseline better."""
    length = chart.names.index("baseline")
    assert np.sqrt(covariance(found)[length, length]) > 0.15


def test_a_baseline_that_is_known_stays_known(rig, boards):
    """A covariance that names other parameters says that the baseline is exact."""
    said = covariance_of_boards(rig, boards, CalibrationCovariance(("yaw", "right.cx"), np.diag([0.25, 25.0])))
    assert set(said.names) == {"yaw", "right.cx"}
    assert (np.sqrt(np.diag(covariance(said))) < [0.25, 2.5]).all()


def test_a_lens_of_many_coefficients_is_seen_through_too(rig):
    from lenses import LENSES

    from stereorecal.estimation import rig_parameters

    camera = sr.Camera(rig.left.size, rig.left.matrix, np.array(LENSES[14]))
    other = rig_parameters(sr.StereoRig(camera, camera, rig.extrinsics))
    said = covariance_of_boards(other.rig, views(other.rig, 5))
    assert deviations_apart(other, said, other.rig) < 2.0


def test_targets_need_not_be_flat(rig, chart):
    rng = np.random.default_rng(3)
    boards = []
    for index in range(12):
        points = 0.03 * GRID + [0.0, 0.0, 1.0] * rng.uniform(0.0, 0.1, (54, 1))
        pixels = seen_by(rig, points, rng.uniform(-0.4, 0.4, 3), np.array([-0.06, -0.07, 0.6 + 0.03 * index]))
        boards.append(Board(*(some + rng.normal(0.0, NOISE, some.shape) for some in pixels), points))
    said = covariance_of_boards(chart.rig, boards)
    assert deviations_apart(chart, said, rig) < 2.0


# --- what is refused ------------------------------------------------------------------------------------------


def swapped(board: Board) -> Board:
    """Rows and columns exchanged."""
    order = np.arange(54).reshape(9, 6).T.ravel()
    return Board(board.left[order], board.right[order], board.points)


def mirrored_right(board: Board) -> Board:
    return Board(board.left, board.right[::-1], board.points)


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("size", [0.8, 1.08, 0.93, 1.25])
def test_squares_of_another_length(chart, boards, size):
    others = [Board(board.left, board.right, size * board.points) for board in boards]
    word = "shorter" if size < 1.0 else "longer"
    with pytest.raises(sr.InputError, match=f"{word} than the calibration says|do not fit the calibration"):
        covariance_of_boards(chart.rig, others)


@pytest.mark.parametrize("spoil", [swapped, mirrored_right], ids=lambda one: one.__name__)
def test_corners_in_another_order(chart, boards, spoil):
    with pytest.raises(sr.InputError, match="do not fit the calibration"):
        covariance_of_boards(chart.rig, [spoil(board) for board in boards])


@pytest.mark.parametrize("spoil", [swapped, mirrored_right], ids=lambda one: one.__name__)
def test_one_board_that_does_not_fit_is_named(chart, boards, spoil):
    with pytest.raises(sr.InputError, match="board 4 does not fit the rig as the others do"):
        covariance_of_boards(chart.rig, [*boards[:4], spoil(boards[4]), *boards[5:]])


def test_another_rig(rig, chart):
    other = sr.StereoRig(rig.left, rig.right, np.add(rig.extrinsics, [0.03, 0.0, 0.05, 0.0, 0.0, 0.0]))
    with pytest.raises(sr.InputError, match="do not fit the calibration"):
        covariance_of_boards(chart.rig, views(other))


def test_other_images(chart, boards):
    with pytest.raises(sr.InputError, match="board 1 has corners outside of the 640x480 images"):
        covariance_of_boards(chart.rig, [boards[0], moved(boards[1], left=400.0)])
    with pytest.raises(sr.InputError, match="no board was given"):
        covariance_of_boards(chart.rig, [])


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"left": np.zeros((5, 2))}, "the same n corners"),
        ({"points": np.zeros((54, 2))}, "the same n corners"),
        ({"right": np.zeros(108)}, "the same n corners"),
        ({"left": np.full((54, 2), np.nan)}, "NaN"),
        ({"points": GRID * 30.0}, "in metres"),
        ({"points": GRID * [1.0, 0.0, 0.0]}, "on one line"),
        ({"left": np.ones((5, 2)), "right": np.ones((5, 2)), "points": np.ones((5, 3))}, "at least 6"),
    ],
)
def test_what_is_no_board(boards, change, word):
    values = {"left": boards[0].left, "right": boards[0].right, "points": boards[0].points} | change
    with pytest.raises(sr.InputError, match=word):
        Board(**values)


# --- a repair -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_ranges_correct_squares_of_another_size():
    """The boards agree with a baseline that is too long, and ranges do not."""
    true = sr.synthetic.default_rig().resized((320, 240))
    bad = true.with_extrinsics(np.concatenate([true.extrinsics[:3], 1.03 * true.extrinsics[3:]]))
    scene = sr.synthetic.render("harbour", 2, rig=true)
    pixels, metres = sr.synthetic.ranges("harbour", 2, rig=true, number=60)
    ranges = [sr.Range(0, tuple(p), m) for p, m in zip(pixels.tolist(), metres.tolist(), strict=True)]
    known = covariance_of_boards(bad, views(bad, noise=0.05, square=0.03), squares=3.0)
    found = sr.recalibrate(bad, scene.pairs, prior=known, ranges=ranges)
    assert found.accepted
    low, high = found.estimate.intervals[found.estimate.names.index("baseline")]
    assert low < 100 * (true.baseline / bad.baseline - 1) < high  # which a yaw may stand for
    before, after = (sr.difference(rig, true).depth_error_percent for rig in (bad, found.rig))
    assert all(abs(after[at]) < 0.7 * abs(before[at]) for at in (5, 10, 30))


@pytest.mark.parametrize("turns", [(1, 1), (0, 2)], ids=["one above the other", "right upside down"])
def test_boards_are_in_images_as_they_were_taken(rig, boards, found, turns):
    """The covariance is that of the rig as it is matched, side by side."""
    taken = replace(rig, turns=turns).as_taken()
    other = sr.StereoRig.from_rotation(taken.left, taken.right, taken.rotation, taken.translation)
    sizes, back = (rig.left.size, rig.right.size), (-turns[0], -turns[1])
    moved = [
        Board(*map(turned_pixels, (board.left, board.right), sizes, back), board.points)  # as those cameras see it
        for board in boards
    ]
    said = covariance_of_boards(other, moved)
    assert said.names == found.names
    np.testing.assert_allclose(covariance(said), covariance(found), rtol=1e-3, atol=1e-12)
