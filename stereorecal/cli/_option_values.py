"""Values of options, parsed with sentences that say what is wrong."""

from collections.abc import Iterable, Iterator
from typing import Any

from stereorecal._choices import checked_choice
from stereorecal._errors import InputError
from stereorecal.cli._shared_options import DecisionOptions, PairOptions, ToleranceOptions, ViewOptions
from stereorecal.decision import LIMITS, Tolerances, as_tolerances
from stereorecal.estimation import check_prior
from stereorecal.geometry import checked_view_arguments
from stereorecal.matching import as_matcher
from stereorecal.objectives import Parameters, as_parameters
from stereorecal.recalibration import HealthOptions


def degrees_and_fraction(text: str, option: str) -> tuple[float, float]:
    """ "DEG,FRACTION"."""
    try:
        degrees, fraction = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"{option} is {text!r}; give degrees and a fraction of the baseline, such as 0.5,0.01."
        ) from None
    return degrees, fraction


def health_options(options: DecisionOptions) -> HealthOptions:
    """What `sr.health` and `sr.recalibrate` take.

    Raises:
        InputError: if a value makes no sense.
    """
    check_prior(options.prior)
    return {
        "matcher": as_matcher(options.matcher),
        "view": view(options),
        "prior": options.prior,
        "motion": {"auto": None, "on": True, "off": False}[options.motion],
        "tolerances": tolerances(options),
    }


def tolerances(options: ToleranceOptions) -> Tolerances:
    """Those of --tolerances and --distances.

    Raises:
        InputError: if a name is unknown, or a value makes no sense.
    """
    found: dict[str, object] = {}
    for name, value, part in _assigned(options.tolerances, LIMITS, "tolerance"):
        found[name] = _number(value, f"--tolerances has {part}; give NAME=NUMBER, such as alpha=0.001.")
    if options.distances is not None:
        refusal = f"--distances is {shortened(options.distances)}; give baselines, such as 5,10,30."
        found["distances"] = tuple(_number(part, refusal) for part in options.distances.split(","))
    return as_tolerances(found)


def view(options: ViewOptions) -> dict[str, Any]:
    """The arguments of `sr.view` that --view names.

    Raises:
        InputError: if a name is unknown, or a value makes no sense.
    """
    found: dict[str, Any] = {}
    for name, value, part in _assigned(options.view, ("projection", "field"), "argument of --view"):
        refusal = f"--view has {part}; give degrees, such as field=140."
        found[name] = _number(value, refusal) if name == "field" else value
    return checked_view_arguments(found)


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


def seed(number: int) -> int:
    """A seed that every generator takes.

    Raises:
        InputError: if it is negative or too large.
    """
    if not 0 <= number < 2**32:
        raise InputError(f"--seed is {number}; give a whole number within 0 and 2^32 - 1.")
    return number


def stretch(options: PairOptions) -> slice:
    """The pairs that --from, --to and --every select."""
    if options.every < 1:
        raise InputError(f"--every is {options.every}; give 1 for every pair, 2 for every second.")
    if options.first < 0 or (options.stop is not None and options.stop <= options.first):
        raise InputError("--from and --to are numbers of pairs, from 0 on; --to must be the larger one.")
    return slice(options.first, options.stop, options.every)


def limit(text: str | None, default: int | None) -> int | None:
    """A positive number, "all" for None, or the default."""
    if text is None or text == "all":
        return default if text is None else None
    return positive(text, f"--limit is {shortened(text)}; give a positive number or all.")


def frame_limit(text: str | None, default: str = "all") -> int | None:
    """A positive number, or None for all."""
    text = default if text is None else text
    if text == "all":
        return None
    return positive(text, f"--frames is {shortened(text)}; give a positive number or all.")


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


def free(text: str | None) -> Parameters:
    """Names and groups, comma separated; the default of the library where nothing is said."""
    if text is None:
        return as_parameters(None)
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise InputError(f"--free is {text!r}; name parameters or groups, such as extrinsics,intrinsics.")
    return as_parameters(names)


def board_corners(text: str | None) -> tuple[int, int]:
    """The corners inside of a chessboard, columns and rows, of --board-corners; by default 9x6.

    Raises:
        InputError: if it is no such text.
    """
    if text is None:
        return 9, 6
    refusal = f"--board-corners is {shortened(text)}; give the corners inside of the board, such as 9x6."
    parts = text.split("x")
    if len(parts) != 2:
        raise InputError(refusal)
    columns, rows = (positive(part, refusal) for part in parts)
    return columns, rows
