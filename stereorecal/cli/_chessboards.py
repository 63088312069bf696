"""The chessboards of the calibration, as the command line names them."""

import math

from stereorecal._errors import InputError
from stereorecal.cli import _option_values
from stereorecal.cli._repair_commands import RecalibrateOptions
from stereorecal.estimation import is_exact
from stereorecal.io import load_pairs
from stereorecal.recordings import Board, find_boards


def check_boards_asked(options: RecalibrateOptions) -> None:
    """Refuse what makes no sense together, before anything is read.

    Raises:
        InputError: says what to do.
    """
    if options.boards is None:
        if options.board_corners is not None or options.square is not None:
            raise InputError("--board-corners and --square belong to --boards; leave them out.")
        return
    if options.square is None:
        raise InputError("--boards needs --square, the side of a square in metres, such as 0.03.")
    if not (math.isfinite(options.square) and options.square > 0.0):
        raise InputError(f"--square is {options.square}; give metres, such as 0.03.")
    _corners(options)
    if is_exact(options.prior):
        raise InputError(
            "--boards determine the errors that the calibration left, and --prior exact says that there are none; "
            "give one."
        )


def boards_of(options: RecalibrateOptions) -> tuple[Board, ...] | None:
    """The boards in the images that --boards names; None without any.

    Raises:
        InputError: if an image cannot be read, or none shows a board.
    """
    if options.boards is None or options.square is None:
        return None
    return find_boards(load_pairs(*options.boards), _corners(options), options.square)


def _corners(options: RecalibrateOptions) -> tuple[int, int]:
    return _option_values.board_corners(options.board_corners)
