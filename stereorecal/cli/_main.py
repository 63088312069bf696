"""Parsing, and the border at which exceptions become sentences and exit codes."""

import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from stereorecal._errors import CalibrationWarning, InputError, PairingWarning, PluginError
from stereorecal.cli._commands import options_of
from stereorecal.cli._options import CommonOptions
from stereorecal.cli._signals import BAD_INPUT, FAILURE, INTERRUPTED, interrupted, interruptible
from stereorecal.cli._streams import say, stdout_error

_WITHOUT_PROGRAMS = (("convert", None), ("diff", None), ("strategies", "list"), ("matchers", "list"))  # and actions


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code. Bad input is one sentence on stderr, never a traceback."""
    try:
        options = options_of(sys.argv[1:] if arguments is None else arguments)
    except (InputError, PluginError) as error:  # of a plug-in's command
        return _report_error(error)
    code = _run(options)
    sys.stdout.flush()
    error = stdout_error()
    return code if error is None or code == INTERRUPTED else _report_error(error)


def _run(options: CommonOptions) -> int:
    working = False
    try:
        options.check_words()
        options.check()
        # Not before: what is only asked for help, or mistyped, does not wait for JAX.
        jax_setup = import_module("stereorecal.cli._jax_setup")
        trouble = jax_setup.use_compile_cache()
        if (options.verb, getattr(options, "action", None)) not in _WITHOUT_PROGRAMS:
            jax_setup.set_up_platform()
            if trouble:
                say(trouble)
        with _warnings_as_lines(), interruptible():
            working = True
            return options.run()
    except Exception as error:
        if options.traceback:
            traceback.print_exception(error)
        code = _report_error(error)
        return INTERRUPTED if working and interrupted() else code
    except KeyboardInterrupt:
        return _say("interrupted", INTERRUPTED)


def _report_error(error: Exception) -> int:
    """One sentence on stderr, and the exit code of an error."""
    match error:
        case InputError():
            return _say(error, BAD_INPUT)
        case ImportError(name="cv2"):
            return _say(f"{error}.", BAD_INPUT)
        case PluginError():
            return _say(error, FAILURE)
        case OSError():
            return _say(f"{error.filename or 'output'}: {error.strerror or error}; check the path.", BAD_INPUT)
        case _:
            hint = "see where it comes from with --traceback, and please report it"
            return _say(f"internal error ({error!r}); {hint}.", FAILURE)


def _say(message: object, code: int) -> int:
    say(message)
    return code


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """What looks wrong is one line on stderr, without the line of code that Python would show."""
    ours = (CalibrationWarning, PairingWarning)
    with warnings.catch_warnings():
        for kind in ours:
            warnings.simplefilter("always", kind)
        show_others = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *where: Any) -> None:
            if issubclass(category, ours):
                say(message)
            else:
                show_others(message, category, *where)

        warnings.showwarning = show
        yield
