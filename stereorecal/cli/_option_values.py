"""What options state, parsed with sentences that say what is wrong; nothing here takes time to import."""

from importlib import import_module

from stereorecal._errors import InputError

NONE_INSTALLED = (
    "no strategy is installed; run: pip install 'stereorecal[default]' (in a clone: pip install -e plugins/compass)"
)


def degrees_and_fraction(text: str, option: str) -> tuple[float, float]:
    """ "DEG,FRACTION"."""
    try:
        degrees, fraction = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"{option} is {text!r}; give degrees and a fraction of the baseline, such as 0.5,0.01."
        ) from None
    return degrees, fraction


def seed(number: int) -> int:
    """A seed that every generator takes.

    Raises:
        InputError: if it is negative or too large.
    """
    if not 0 <= number < 2**32:
        raise InputError(f"--seed is {number}; give a whole number within 0 and 2^32 - 1.")
    return number


def limit(text: str | None, default: int | None, option: str = "--limit") -> int | None:
    """A positive number, "all" for None, or the default."""
    if text is None or text == "all":
        return default if text is None else None
    return positive(text, f"{option} is {shortened(text)}; give a positive number or all.")


def frame_limit(text: str | None, default: str = "all") -> int | None:
    """That of --frames: a positive number, or None for all."""
    return limit(default if text is None else text, None, "--frames")


def slice_of_pairs(text: str | None) -> slice:
    """The pairs that --pairs names: "A:B:N" as Python has it, without negative numbers; a number alone is one pair.

    Raises:
        InputError: if it makes no sense, or selects nothing.
    """
    parts = (text or ":").split(":")
    if len(parts) > 3 or not all(not part or (part.isdecimal() and len(part) < 10) for part in parts):
        raise InputError(f"--pairs is {shortened(text or '')}; give numbers of pairs, from 0 on, such as 10:50 or ::5.")
    first, stop, step = (int(part) if part else None for part in (*parts, "", "")[:3])
    if len(parts) == 1 and first is not None:
        stop = first + 1
    if step == 0 or (stop is not None and stop <= (first or 0)):
        raise InputError(f"--pairs {text} selects nothing; give numbers of pairs, from 0 on, such as 10:50 or ::5.")
    return slice(first or 0, stop, step or 1)


def positive(text: str, refusal: str) -> int:
    """A positive whole number below a thousand million.

    Raises:
        InputError: the refusal.
    """
    if not text.isdecimal() or len(text) > 9 or int(text) < 1:
        raise InputError(refusal)
    return int(text)


def shortened(text: str) -> str:
    """In quotes, for a message."""
    return repr(text if len(text) <= 40 else f"{text[:40]}…")


def camera_pair(text: str | None) -> tuple[str, str] | None:
    """The left and the right camera of --cameras.

    Raises:
        InputError: if it is not two names.
    """
    if text is None:
        return None
    names = [name.strip() for name in text.split(",")]
    if len(names) != 2 or not all(names):
        raise InputError(
            f"--cameras is {shortened(text)}; give the left and the right camera of the file, such as cam1,cam0, or "
            "right,left to exchange them."
        )
    return names[0], names[1]


def strategy_names(text: str) -> list[str]:
    """ "a,b" or "all".

    Raises:
        InputError: if there is none, or one is not installed.
    """
    strategies = import_module("stereorecal.strategies")
    names = list(strategies.strategies()) if text == "all" else [n for n in (n.strip() for n in text.split(",")) if n]
    if not names:
        raise InputError(NONE_INSTALLED if text == "all" else "--strategies names none; give names or all.")
    for name in names:
        strategies.check_installed(name)
    return list(dict.fromkeys(names))
