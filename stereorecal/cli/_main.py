"""Parsing, and the border at which exceptions become sentences and exit codes."""

import argparse
import signal
import sys
import threading
from collections.abc import Sequence
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
    verbs = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (_recalibrate, _score, _compare, _reproduce, _strategies):
        command.add_to(verbs)
    options = parser.parse_args(arguments)
    _interrupt_on_sigterm()
    keep_compiled_programs()
    try:
        return options.run(options)
    except InputError as error:
        return _say(error, BAD_INPUT)
    except StrategyError as error:
        return _say(error, FAILURE)
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)
    except OSError as error:
        return _say(f"{error.filename or 'output'}: {error.strerror or error}; check the path.", BAD_INPUT)
    except Exception as error:
        return _say(f"internal error, please report it: {error!r}", FAILURE)


def _say(message: object, code: int) -> int:
    print(f"stereorecal: {message}", file=sys.stderr)
    return code


def _interrupt_on_sigterm() -> None:
    """SIGTERM is treated as Ctrl-C: what is finished is printed and saved."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)
