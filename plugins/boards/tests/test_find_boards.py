"""Chessboards that are drawn as the cameras of a rig see them, and found again."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from fixtures import data_dir as data_dir
from stereorecal_boards import Board, covariance_of_boards, find_boards, find_charuco

import stereorecal as sr

SIZE = (640, 480)
MATRIX = np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]])
SQUARE = 0.03
FINER = 4


def shown(corners: tuple[int, int], turn: np.ndarray, shift: np.ndarray) -> tuple[sr.Pair, list[np.ndarray]]:
    """A pair of images of a board, and its inner corners in both."""
    columns, rows = corners
    side, pixels, edges = 40, [], []
    squares = (np.add.outer(np.arange(rows + 3), np.arange(columns + 3)) % 2 * 215 + 20).astype(np.uint8)
    squares[[0, -1]] = squares[:, [0, -1]] = 235  # paper around
    drawn = np.kron(squares, np.ones((side, side), np.uint8))
    rotation, points = cv2.Rodrigues(turn)[0], np.mgrid[0:columns, 0:rows].reshape(2, -1).T
    middle = (np.array(corners) - 1) / 2
    for baseline in (0.0, 0.12):
        place = np.column_stack(
            [rotation[:, :2] * SQUARE, shift - rotation[:, :2] @ middle * SQUARE - [baseline, 0, 0]]
        )
        plane = MATRIX @ place
        # Inner corner (i, j) lies between drawn pixels (i + 2) * side - 1 and (i + 2) * side.
        to_board = np.array([[1 / side, 0, -2 + 0.5 / side], [0, 1 / side, -2 + 0.5 / side], [0, 0, 1]])
        # Drawn four times as large, so that pixels are means of what they see.
        finer = np.array([[FINER, 0, (FINER - 1) / 2], [0, FINER, (FINER - 1) / 2], [0, 0, 1]])
        large = cv2.warpPerspective(drawn, finer @ plane @ to_board, tuple(FINER * np.array(SIZE)), borderValue=235)
        pixels.append(cv2.GaussianBlur(cv2.resize(large, SIZE, interpolation=cv2.INTER_AREA), (3, 3), 0.7))
        at = np.column_stack([points, np.ones(len(points))]) @ plane.T
        edges.append(at[:, :2] / at[:, 2:])
    return sr.make_pair(*pixels), edges


@pytest.mark.slow(after=4)
@pytest.mark.parametrize("corners", [(9, 6), (7, 5), (5, 5), (6, 9)], ids=str)
@pytest.mark.parametrize("about", [2.0, 0.1, -1.5])
def test_corners_are_where_they_are_and_in_one_order(corners, about):
    pair, true = shown(corners, np.array([0.3, -0.2, about]), np.array([0.06, 0.0, 0.8]))
    (board,) = find_boards(pair, corners, SQUARE)
    every = np.concatenate(true, axis=1)
    found = np.concatenate([board.left, board.right], axis=1)
    nearest = np.linalg.norm(found[:, None] - every, axis=2)
    assert nearest.min(axis=1).max() < 0.15  # both images at once: the same corner in each
    assert len(set(nearest.argmin(axis=1))) == corners[0] * corners[1]
    # The order is that of the points: a homography takes them there.
    plane, _ = cv2.findHomography(board.points[:, :2], board.left)
    onto = cv2.perspectiveTransform(board.points[None, :, :2], plane)[0]
    assert np.abs(onto - board.left).max() < 0.5
    assert np.linalg.norm(board.points[1] - board.points[0]) == pytest.approx(SQUARE)


def test_pairs_without_a_board_in_both_images_are_skipped():
    pair, _ = shown((9, 6), np.array([0.2, 0.1, 0.0]), np.array([0.06, 0.0, 0.8]))
    empty = np.random.default_rng(0).uniform(100, 140, pair.left.shape).astype(np.float32)
    pairs = [(pair.left, empty), pair, (empty, pair.right)]
    assert len(find_boards(pairs, square=SQUARE)) == 1
    with pytest.raises(sr.InputError, match="none of 2 pairs shows a chessboard with 9x6 inner corners"):
        find_boards([pairs[0], pairs[2]], square=SQUARE)
    with pytest.raises(sr.InputError, match="7x6"):
        find_boards(pair, (7, 6), SQUARE)


def test_charuco_boards_are_found_in_part():
    """Drawn as two cameras see them; the right one sees what the left one lost, and less."""
    board = cv2.aruco.CharucoBoard((8, 6), 0.03, 0.022, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    drawn = cv2.copyMakeBorder(board.generateImage((400, 300)), 90, 90, 120, 120, cv2.BORDER_CONSTANT, value=235)
    hidden = drawn.copy()
    hidden[:, 430:] = 235
    (found,) = find_charuco([(drawn.astype(np.float32), np.roll(hidden, -20, axis=1).astype(np.float32))], board)
    np.testing.assert_allclose(found.left - found.right, np.tile([20.0, 0.0], (len(found.left), 1)), atol=0.2)
    assert 6 <= len(found.points) < 35
    np.testing.assert_allclose(np.ptp(found.left, axis=0) / np.ptp(found.points[:, :2], axis=0), 50 / 0.03, rtol=0.01)
    with pytest.raises(sr.InputError, match="shows the ChArUco board"):
        find_charuco([(np.random.default_rng(0).integers(90, 150, drawn.shape, np.uint8), drawn)], board)


@pytest.mark.parametrize(
    ("corners", "square", "word"),
    [((2, 6), 0.03, "corners"), ((9, 6), 0.0, "metres"), ((9, 6), float("nan"), "metres")],
)
def test_what_makes_no_sense(corners, square, word):
    pair, _ = shown((9, 6), np.zeros(3), np.array([0.06, 0.0, 0.8]))
    with pytest.raises(sr.InputError, match=word):
        find_boards(pair, corners, square)


def test_boards_of_a_real_calibration_fit_it(data_dir: Path):
    folder = data_dir / "boofcv_bumblebee2"
    names = [folder / "calibration_chess" / f"{side}0[1-4].jpg" for side in ("left", "right")]
    boards = find_boards(sr.io.load_pairs(*names), (4, 6), 0.03)
    rig = sr.io.load_scene(folder / "garden01").rig
    assert rig is not None
    assert len(boards) == 4
    said = covariance_of_boards(rig, boards)
    assert (np.abs(said.mean) < 3.5 * np.sqrt(np.diag(said.covariance))).all()
    large = [Board(board.left, board.right, 1.2 * board.points) for board in boards]
    with pytest.raises(sr.InputError, match=r"than the calibration says|do not fit"):
        covariance_of_boards(rig, large)
