"""The options that judges add to `compare`."""

from importlib import import_module
from typing import Literal

from stereorecal import InputError
from stereorecal.cli import CompareOptions, option, option_group

_JUDGES = "judges: methods compared by data that none of them sees"


@option_group
class JudgeOptions(CompareOptions):
    """The options of `compare`, and those of judges."""

    judge: tuple[str, ...] = option(
        _JUDGES,
        "lidar=FOLDER, boards=FOLDER (see --board-corners, --square), product=FOLDER, motion[=FOLDER], "
        "rendered[=KIND], simulated[=KIND] or walk (repeatable); --strategies then names methods: count, rows, motion, "
        "and strategies, --draws means rides, too, and --frames pairs of rendered and simulated scenes. Only rows of "
        "lidar and of motion=FOLDER are of images that methods get, too",
        (),
        metavar="NAME[=PLACE]",
    )
    preset: Literal["field"] | None = option(
        _JUDGES,
        "field: all rendered judges, and those of --judge, with 10 draws and 4 drives, in an hour",
        metavar="NAME",
    )
    full: bool = option(_JUDGES, "of --preset field: in a night", False)
    board_corners: str | None = option(
        _JUDGES, "inner corners of the chessboards of boards=FOLDER (default: 9x6)", metavar="NxM"
    )
    square: float | None = option(_JUDGES, "side of their squares", metavar="METRES")

    @property
    def judged(self) -> bool:
        """Whether judges compare methods; else it is a comparison of strategies."""
        return bool(self.judge) or self.preset is not None

    def check(self) -> None:
        if self.judged:
            return
        for name in ("full", "square", "board_corners"):
            if getattr(self, name):
                raise InputError(f"--{name.replace('_', '-')} needs --judge or --preset field; add one.")
        super().check()

    def run(self) -> int:
        return import_module("stereorecal_field._compare_field").run(self) if self.judged else super().run()
