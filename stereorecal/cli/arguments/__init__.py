"""What can be said on the command line, one module a command.

Nothing here imports JAX, OpenCV or NumPy: help, the version and mistyped options are answered at once.
"""

import argparse
from typing import NoReturn

from stereorecal._version import __version__
from stereorecal.cli._exit_codes import BAD_INPUT
from stereorecal.cli.arguments import _compare, _convert, _diff, _monitor, _recalibrate, _reproduce, _score, _strategies
from stereorecal.cli.arguments._calibrations import TWO_FILES


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        if message.startswith("unrecognized arguments: ") and not message.partition(": ")[2].startswith("-"):
            message += f" ({TWO_FILES})"
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """The parser of the command line; `verb` of what it returns names the command's module in `stereorecal.cli`."""
    made = _Parser(
        prog="python -m stereorecal",
        description="Repair the extrinsic calibration of a stereo rig from ordinary images.",
    )
    made.add_argument("--version", action="version", version=f"stereorecal {__version__}")
    # Before the command or after it: a default there would undo what was said before.
    common = argparse.ArgumentParser(add_help=False)
    for place, default in ((made, False), (common, argparse.SUPPRESS)):
        help_text = "show where an error comes from"
        place.add_argument("--traceback", action="store_true", default=default, help=help_text)
    verbs = made.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (_recalibrate, _score, _monitor, _diff, _convert, _compare, _reproduce, _strategies):
        command.add_to(verbs, common)
    return made
