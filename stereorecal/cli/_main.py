"""Parsing, and the border at which exceptions become sentences and exit codes."""

import signal
import sys
import threading
import traceback
from collections.abc import Sequence
from importlib import import_module

from stereorecal._errors import InputError, StrategyError
from stereorecal.cli._exit_codes import BAD_INPUT, FAILURE, INTERRUPTED
from stereorecal.cli.arguments import parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code. Bad input is one sentence on stderr, never a traceback."""
    options = parser().parse_args(arguments)
    _interrupt_on_sigterm()
    try:
        # Not before: what is only asked for help, or mistyped, does not wait for JAX.
        import_module("stereorecal.cli._compiled").keep_compiled_programs()
        return import_module(f"stereorecal.cli._{options.verb}").run(options)
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
