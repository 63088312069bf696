"""The options that boards add to `python -m stereorecal recalibrate`."""

import math
import re
from collections.abc import Sequence
from typing import Any

from stereorecal import InputError
from stereorecal.cli import RIG, CommonOptions, option, option_group


@option_group
class BoardOptions(CommonOptions):
    """A repair whose calibration is known by its boards."""

    boards: tuple[str, str] | None = option(
        RIG,
        "chessboard images of the initial calibration: a file, a folder or 'left/*.png' each; needs --square",
        metavar=("LEFT", "RIGHT"),
    )
    board_corners: str | None = option(RIG, "inner corners of the chessboard (default: 9x6)", metavar="NxM")
    square: float | None = option(RIG, "side of its squares, as in the calibration", metavar="METRES")

    def check(self) -> None:
        super().check()
        if self.boards is None:
            if self.board_corners is not None or self.square is not None:
                raise InputError("--board-corners and --square belong to --boards; leave them out.")
            return
        if self.square is None:
            raise InputError("--boards needs --square, the side of a square in metres, such as 0.03.")
        if not (math.isfinite(self.square) and self.square > 0.0):
            raise InputError(f"--square is {self.square}; give metres, such as 0.03.")
        board_corners(self.board_corners)
        if getattr(self, "prior", None) is not None:
            raise InputError("--boards say what the calibration left, and --prior says it too; give one.")
        if (fix := getattr(self, "fix", None)) in ("exchanged", "turned"):
            raise InputError(f"--fix {fix} changes images alone; with --boards, change the files.")

    def known_of(self, rigs: Sequence[Any]) -> Any:
        """What the boards tell of the calibration of all recordings.

        Raises:
            InputError: if an image cannot be read, none shows a board, or they are of another rig.
        """
        if self.boards is None or self.square is None:
            return super().known_of(rigs)  # pyright: ignore[reportAttributeAccessIssue]
        from stereorecal.io import load_pairs
        from stereorecal_boards._covariance import covariance_of_boards
        from stereorecal_boards._find_boards import find_boards

        first = rigs[0]
        if first is None or any(rig is None or (rig.extrinsics != first.extrinsics).any() for rig in rigs):
            raise InputError("--boards are those of one calibration; give recordings that have it.")
        boards = find_boards(load_pairs(*self.boards), board_corners(self.board_corners), self.square)
        measured = getattr(self, "ranges", None) is not None or getattr(self, "odometer", None) is not None
        # Squares of another size than stated are common, and what measures lengths tells.
        return covariance_of_boards(first, boards, squares=1.0 if measured else 0.15)


def board_corners(text: str | None) -> tuple[int, int]:
    """The corners inside of a chessboard, columns and rows, of --board-corners; by default 9x6.

    Raises:
        InputError: if it is no such text.
    """
    found = re.fullmatch(r"([1-9]\d{0,2})x([1-9]\d{0,2})", "9x6" if text is None else text)
    if found is None:
        raise InputError(f"--board-corners is {text!r}; give the corners inside of the board, such as 9x6.")
    return int(found[1]), int(found[2])
