"""Options as the arguments that the library takes, and as the settings in the JSON."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import asdict
from importlib import import_module
from typing import Any

from stereorecal._errors import InputError, checked_choice
from stereorecal.cli._option_values import degrees_and_fraction, shortened
from stereorecal.cli._options import CommonOptions
from stereorecal.decision import LIMITS, Tolerances, as_tolerances
from stereorecal.geometry import checked_view_arguments
from stereorecal.objectives import Reach
from stereorecal.recalibration import Settings
from stereorecal.strategies import Budget


def library_options(options: CommonOptions, names: Collection[str]) -> dict[str, Any]:
    """By name, those options of the library that a command has and that were given.

    Args:
        names: of the library's options.

    Raises:
        InputError: if a value makes no sense, or a file cannot be read.
    """
    found = {}
    for name, field in options.__dataclass_fields__.items():
        if name in names and (value := getattr(options, name)) is not None:
            module, _, reader = field.metadata["reads"].partition(":")
            found[name] = getattr(import_module(module), reader)(value) if module else value
    return found


def settings_as_json(options: CommonOptions, settings: Settings, names: Collection[str]) -> dict[str, Any]:
    """The settings in the JSON, by name: what was computed with where that is numbers, else the words.

    Args:
        names: of the library's options.
    """
    used = {name: value for name, value in settings.options.items() if name in names}
    words = {name: getattr(options, name, value) for name, value in used.items()}
    numbers = {name: asdict(value) for name, value in used.items() if isinstance(value, Reach | Budget | Tolerances)}
    return {**words, **numbers, "matcher": {"name": words["matcher"], **asdict(settings.matcher)}}


def motion(text: str) -> bool | None:
    """Whether --motion asks for it; None leaves it to the library."""
    return {"auto": None, "on": True, "off": False}[text]


def reach(text: str) -> tuple[float, float]:
    """Degrees and fraction of the baseline of --reach.

    Raises:
        InputError: if it is not two numbers.
    """
    return degrees_and_fraction(text, "--reach")


def tolerances(text: str | None) -> Tolerances:
    """Those of --tolerances.

    Raises:
        InputError: if a name is unknown, or a value makes no sense.
    """
    found: dict[str, object] = {}
    for name, value, part in _assigned(text, (*LIMITS, "distances"), "tolerance"):
        refusal = f"--tolerances has {part}; give NAME=NUMBER, such as harm=0.01, or distances=5:10:30 in baselines."
        several = name == "distances"
        found[name] = tuple(_number(n, refusal) for n in value.split(":")) if several else _number(value, refusal)
    return as_tolerances(found)


def view(text: str | None) -> dict[str, Any]:
    """The arguments of `sr.view` that --view names.

    Raises:
        InputError: if a name is unknown, or a value makes no sense.
    """
    found: dict[str, Any] = {}
    for name, value, part in _assigned(text, ("projection", "field"), "argument of --view"):
        refusal = f"--view has {part}; give degrees, such as field=140."
        found[name] = _number(value, refusal) if name == "field" else value
    return checked_view_arguments(found)


def free(text: str) -> list[str]:
    """Names and groups, comma separated.

    Raises:
        InputError: if one is empty.
    """
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise InputError(f"--free is {text!r}; name parameters or groups, such as extrinsics,intrinsics.")
    return names


def _assigned(text: str | None, names: Iterable[str], what: str) -> Iterator[tuple[str, str, str]]:
    """Of "NAME=VALUE,…": each name, which has to be one of `names`, its value, and both as they were given."""
    for part in [] if text is None else text.split(","):
        name, _, value = (piece.strip() for piece in part.partition("="))
        yield checked_choice(name, names, what), value, shortened(part)


def _number(text: str, refusal: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(refusal) from None
