"""What the words of options come to, with sentences that say what is wrong; nothing here imports JAX.

Each refuses what makes no sense with an `InputError` that names the option's flag.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import Any

from stereorecal._errors import InputError, checked_choice
from stereorecal._plugins import MATCHER_NAMES, install_line

NONE_INSTALLED = f"no strategy is installed; run: {install_line('compass')}"
_NUMBER = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*"
_NAME = r"([^,]*[^,\s][^,]*)"


def shortened(text: str) -> str:
    """A value in quotes, for a message."""
    return repr(text if len(text) <= 40 else f"{text[:40]}…")


def of_form(form: str, give: str, made: Callable[..., Any]) -> Callable[[str, str], Any]:
    """What reads words of a form, a regular expression: what is made of its groups; `give` says what else to give."""

    def read(text: str, flag: str) -> Any:
        if (found := re.fullmatch(form, text, re.ASCII)) is None:
            raise InputError(f"{flag} is {shortened(text)}; give {give}.")
        return made(*found.groups())

    return read


degrees_and_fraction = of_form(
    f"{_NUMBER},{_NUMBER}",
    "degrees and a fraction of the baseline, such as 0.5,0.01",
    lambda *two: tuple(map(float, two)),
)
number_or_all = of_form(
    r"all|0*([1-9]\d{0,8})", "a positive number or all", lambda number: None if number is None else int(number)
)
image_size = of_form(
    r"([1-9]\d{0,6})x([1-9]\d{0,6})", "width and height in pixels, such as 640x480", lambda *two: tuple(map(int, two))
)
parameter_names = of_form(
    r"(\s*[^,\s]+\s*(?:,\s*[^,\s]+\s*)*)",  # one way to match: others would be tried one by one
    "names of parameters or groups, such as extrinsics,intrinsics",
    lambda names: [name.strip() for name in names.split(",")],
)
camera_pair = of_form(
    f"{_NAME},{_NAME}",
    "the left and the right camera of the file, such as cam1,cam0, or right,left to exchange them",
    lambda left, right: (left.strip(), right.strip()),
)
_slice_parts = of_form(
    r"(\d{0,9})(?::(\d{0,9}))?(?::(\d{0,9}))?",
    "numbers of pairs, from 0 on, such as 10:50 or ::5",
    lambda *parts: parts,
)


def slice_of_pairs(text: str, flag: str) -> slice:
    """A:B:N as Python has it, without negative numbers; a number alone is one pair."""
    first, stop, step = (int(part) if part else None for part in _slice_parts(text, flag))
    if ":" not in text and first is not None:
        stop = first + 1
    if step == 0 or (stop is not None and stop <= (first or 0)):
        raise InputError(f"{flag} {text} selects nothing; give numbers of pairs, from 0 on, such as 10:50 or ::5.")
    return slice(first or 0, stop, step or 1)


def seed(number: int, flag: str) -> int:
    """A seed that every generator takes."""
    if not 0 <= number < 2**32:
        raise InputError(f"{flag} is {number}; give a whole number within 0 and 2^32 - 1.")
    return number


def yes_or_no(text: str, flag: str) -> bool | None:
    """on and off; None for auto, which leaves it to the library."""
    return {"auto": None, "on": True, "off": False}[text]


def tolerances(text: str, flag: str) -> dict[str, object]:
    """Numbers by name, "distances" several; the library knows which there are."""
    found: dict[str, object] = {}
    for name, value, part in _assigned(text, flag):
        refusal = f"{flag} has {part}; give NAME=NUMBER, such as harm=0.01, or distances=5:10:30 in baselines."
        several = name == "distances"
        found[name] = tuple(_number(n, refusal) for n in value.split(":")) if several else _number(value, refusal)
    return found


def view_arguments(text: str, flag: str) -> dict[str, Any]:
    """Arguments of `sr.view` by name."""
    found: dict[str, Any] = {}
    for name, value, part in _assigned(text, flag):
        checked_choice(name, ("projection", "field"), f"argument of {flag}")
        refusal = f"{flag} has {part}; give degrees, such as field=140."
        found[name] = _number(value, refusal) if name == "field" else value
    return found


def camera_names(words: Sequence[str], flag: str) -> list[str]:
    """One name, or two: two words, or one with a comma in it, which a pipeline may have as well."""
    names = words[0].split(",") if len(words) == 1 and "!" not in words[0] else list(words)
    if len(names) > 2 or not all(names):
        raise InputError(f"{flag} is {' '.join(words)!r}; give one name, or two, such as 0,1.")
    return names


def schedule_name(text: str, flag: str) -> str:
    """The name of a schedule, or NAME:STRATEGY."""
    name, colon, strategy = text.partition(":")
    checked_choice(name, ("default", "count"), flag)
    if colon:
        import_module("stereorecal.strategies").check_installed(strategy)
    return text


def matcher_name(text: str, flag: str) -> str:
    """The name of an installed matcher."""
    MATCHER_NAMES.check(text)
    return text


def strategy_names(text: str) -> list[str]:
    """The names of installed strategies in "a,b" or "all"."""
    strategies = import_module("stereorecal.strategies")
    names = list(strategies.strategies()) if text == "all" else [n for n in (n.strip() for n in text.split(",")) if n]
    if not names:
        raise InputError(NONE_INSTALLED if text == "all" else "--strategies names none; give names or all.")
    for name in names:
        strategies.check_installed(name)
    return list(dict.fromkeys(names))


def _assigned(text: str, flag: str) -> Iterator[tuple[str, str, str]]:
    """Each name of "NAME=VALUE,…", its value, and both as they were given."""
    names: set[str] = set()
    for part in text.split(","):
        name, _, value = (piece.strip() for piece in part.partition("="))
        if name in names:
            raise InputError(f"{flag} has {shortened(name)} twice; give it once.")
        names.add(name)
        yield name, value, shortened(part)


def _number(text: str, refusal: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(refusal) from None
