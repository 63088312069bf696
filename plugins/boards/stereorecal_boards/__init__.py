"""The boards of a calibration: what they tell of it, as the prior of a repair."""

from stereorecal_boards._board import Board as Board
from stereorecal_boards._covariance import covariance_of_boards as covariance_of_boards
from stereorecal_boards._find_boards import find_boards as find_boards, find_charuco as find_charuco
