"""Errors, and checks of what people name that raise them."""

import difflib
import glob
import inspect
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path


class InputError(ValueError):
    """Data or options of the caller cannot be used; the message is one sentence that says what to do.

    The command line turns it into exit code 2.
    """


class UnsupportedModelError(InputError):
    """A model of a lens that is not known (omnidirectional, equirectangular, ...), or coefficients that are not its."""


class NeedNotMet(InputError):
    """The objective does not offer what a strategy needs; in a comparison, a SKIPPED row."""


class PluginError(RuntimeError):
    """A plug-in cannot be loaded, or crashed; the message names its distribution and version."""


class StrategyError(PluginError):
    """A strategy cannot be loaded, or crashed; the message names its distribution and version."""


class MatcherError(PluginError):
    """A matcher cannot be loaded, or crashed; the message names its distribution and version."""


class BudgetExhausted(Exception):
    """Raised by an objective whose budget is spent. A strategy lets it pass."""


class CalibrationWarning(UserWarning):
    """A calibration can be used but looks wrong; the message is one sentence.

    The command line prints it as a line and goes on.
    """


class PairingWarning(UserWarning):
    """Images are paired that may not correspond; the message is one sentence.

    The command line prints it as a line and goes on.
    """


def warn(message: str, category: type[Warning]) -> None:
    """Warn; the warning points at the line that called this library, or a distribution of its own."""
    frame, depth = inspect.currentframe(), 1
    while frame is not None and str(frame.f_globals.get("__name__")).startswith("stereorecal"):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(message, category, stacklevel=depth)


def checked_choice(name: str, names: Iterable[str], what: str) -> str:
    """`name`, if it is one of `names`.

    Args:
        what: what the name is of, for the message.

    Raises:
        InputError: otherwise; the message suggests the nearest name.
    """
    names = list(names)
    if name in names:
        return name
    close = difflib.get_close_matches(str(name), names, 1)
    hint = f"did you mean {close[0]}?" if close else f"choose one of: {', '.join(names)}."
    raise InputError(f"unknown {what} {name!r}; {hint}")


def check_exists(place: str | PathLike[str], what: str) -> None:
    """Refuse a place that does not exist, unless it is a pattern such as "left/*.png".

    Args:
        what: what should be there, for the message.

    Raises:
        InputError: names the place.
    """
    if not Path(place).exists() and glob.escape(str(place)) == str(place):
        raise InputError(f"{place}: there is no such {what}; check the path.")


def existing_folder(folder: str | PathLike[str]) -> Path:
    """The folder.

    Raises:
        InputError: if there is none of this name.
    """
    if Path(folder).is_file():
        raise InputError(f"{folder}: this is a file; give the folder of the recording.")
    if not Path(folder).is_dir():
        raise InputError(f"{folder}: there is no such folder; check the path.")
    return Path(folder)


@contextmanager
def as_input_error(kind: type[Exception]) -> Iterator[None]:
    """Around what raises such an error where the user can do something about it.

    Raises:
        InputError: in its place.
    """
    try:
        yield
    except kind as error:
        raise InputError(str(error)) from error


@contextmanager
def extra(name: str, purpose: str) -> Iterator[None]:
    """Around imports of what the extra `name` installs.

    Raises:
        InputError: if it is not installed; says the install line.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise InputError(
            f"{purpose} needs {error.name}, which is not installed; run: pip install 'stereorecal[{name}]'"
        ) from error
