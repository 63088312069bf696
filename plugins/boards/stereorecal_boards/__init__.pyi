from ._board import Board as Board
from ._covariance import covariance_of_boards as covariance_of_boards
from ._find_boards import find_boards as find_boards, find_charuco as find_charuco
from ._options import board_corners as board_corners
