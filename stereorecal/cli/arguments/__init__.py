"""What can be said on the command line, one module a command.

Nothing here imports JAX, OpenCV or NumPy: help, the version and mistyped options are answered at once.
"""

import argparse
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NoReturn

from stereorecal._version import __version__
from stereorecal.cli._exit_codes import BAD_INPUT
from stereorecal.cli.arguments import (
    _compare,
    _convert,
    _diff,
    _matchers,
    _monitor,
    _recalibrate,
    _reproduce,
    _score,
    _strategies,
)
from stereorecal.cli.arguments._calibrations import TWO_FILES


class _Parser(argparse.ArgumentParser):
    def parse_known_args(self, args=None, namespace=None):  # pyright: ignore[reportIncompatibleMethodOverride]
        """What a command does not know is said by it, not by the parser of all commands."""
        found, others = super().parse_known_args(args, namespace)
        if others:
            self.error(f"unrecognized arguments: {' '.join(others)}{self._hint(others)}")
        return found, others

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"stereorecal: {message}; see {self.prog} --help\n")

    def _hint(self, others: Sequence[str]) -> str:
        known = [name for action in self._actions for name in action.option_strings]
        option = next((word.partition("=")[0] for word in others if word.startswith("-")), None)
        if option is None:
            return f" ({TWO_FILES})" if "--unit" in known else ""
        close = get_close_matches(option, known, 1)
        return f" (did you mean {close[0]}?)" if close else ""


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
    for command in (_recalibrate, _score, _monitor, _diff, _convert, _compare, _reproduce, _strategies, _matchers):
        command.add_to(verbs, common)
    return made
