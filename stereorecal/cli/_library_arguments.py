"""Options as the arguments that the library takes."""

from collections.abc import Iterable, Iterator
from typing import Any

from stereorecal._errors import InputError, checked_choice
from stereorecal.cli._option_values import shortened
from stereorecal.cli._shared_options import DecisionOptions, ToleranceOptions, ViewOptions
from stereorecal.decision import LIMITS, Tolerances, as_tolerances
from stereorecal.estimation import check_prior
from stereorecal.geometry import checked_view_arguments
from stereorecal.matching import as_matcher
from stereorecal.objectives import Parameters, as_parameters
from stereorecal.recalibration import HealthOptions, as_distances


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
        "distances": distances(options.distances),
    }


def distances(text: str | None) -> str | None:
    """Those of --distances, checked.

    Raises:
        InputError: if one is no distance.
    """
    as_distances(text)
    return text


def tolerances(options: ToleranceOptions) -> Tolerances:
    """Those of --tolerances.

    Raises:
        InputError: if a name is unknown, or a value makes no sense.
    """
    found: dict[str, object] = {}
    for name, value, part in _assigned(options.tolerances, (*LIMITS, "distances"), "tolerance"):
        refusal = f"--tolerances has {part}; give NAME=NUMBER, such as harm=0.01, or distances=5:10:30 in baselines."
        several = name == "distances"
        found[name] = tuple(_number(n, refusal) for n in value.split(":")) if several else _number(value, refusal)
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


def free(text: str | None) -> Parameters:
    """Names and groups, comma separated; the default of the library where nothing is said."""
    if text is None:
        return as_parameters(None)
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise InputError(f"--free is {text!r}; name parameters or groups, such as extrinsics,intrinsics.")
    return as_parameters(names)
