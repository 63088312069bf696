"""Parsing, and the border at which exceptions become sentences and exit codes."""

import argparse
import signal
import sys
import threading
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from typing import NoReturn

from stereorecal._errors import InputError, StrategyError
from stereorecal.cli import _compare, _recalibrate, _reproduce, _score, _strategies
from stereorecal.cli._compiled import keep_compiled_programs
from stereorecal.cli._exit_codes import BAD_INPUT, FAILURE, INTERRUPTED


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code. Bad input is one sentence on stderr, never a traceback."""
    parser = _Parser(
        prog="python -m stereorecal",
        description="Repair the extrinsic calibration of a stereo rig from ordinary images.",
    )
    parser.add_argument("--version", action="version", version=f"stereorecal {version('stereorecal')}")
    # Before the command or after it: a default there would undo what was said before.
    common = argparse.ArgumentParser(add_help=False)
    for place, default in ((parser, False), (common, argparse.SUPPRESS)):
        help_text = "show where an error comes from"
        place.add_argument("--traceback", action="store_true", default=default, help=help_text)
    verbs = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (_recalibrate, _score, _compare, _reproduce, _strategies):
        command.add_to(verbs, common)
    options = parser.parse_args(arguments)
    _interrupt_on_sigterm()
    keep_compiled_programs()
    try:
        return options.run(options)
    except Exception as error:
        if options.traceback:
            traceback.print_exception(error)
        return _said(error)
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)


def _said(error: Exception) -> int:
    """One sentence on stderr, and the exit code of an error."""
    match error:
        case InputError():
            return _say(error, BAD_INPUT)
        case StrategyError():
            return _say(error, FAILURE)
        case OSError():
            return _say(f"{error.filename or 'output'}: {error.strerror or error}; check the path.", BAD_INPUT)
        case _:
            hint = "see where it comes from with --traceback, and please report it"
            return _say(f"internal error ({error!r}); {hint}.", FAILURE)


def _say(message: object, code: int) -> int:
    print(f"stereorecal: {message}", file=sys.stderr)
    return code


def _interrupt_on_sigterm() -> None:
    """SIGTERM is treated as Ctrl-C: what is finished is printed and saved."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)
