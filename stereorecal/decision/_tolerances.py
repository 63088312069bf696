"""What a change must gain, what counts as worse, and how sure that must be: all constants of the decision."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from numbers import Real

import numpy as np

from stereorecal._choices import checked_choice
from stereorecal._errors import InputError
from stereorecal.estimation import JUDGED_AT

_PROBABILITIES = ("alpha", "good_surely")


@dataclass(frozen=True)
class Tolerances:
    """What is asked of a change of calibration. The defaults are the same for all rigs.

    Attributes:
        gain_px: of row error (root mean square over the view) that a repair must gain: what a matcher notices.
        worse_rows_px: of row error that a repair may lose: what repairs that end well lose by noise.
        worse_depth_points: of the error of depth, in percentage points at the farthest distance, likewise.
        alpha: probability of a change for the worse, and of none for the better, at most.
        blind_rows_px: of row error beyond which a matcher's windows show other things: such a rig has no depth to
            lose to one that explains the rows.
        good_rows_px: of row error that good calibrations have.
        good_surely: probability with which they do, at least; and with which a change of what depth reads is for the
            better.
        distances: in baselines, at which rows are judged, besides the nearest that the images show, if that is nearer;
            depth at the farthest of them.

    Raises:
        InputError: if a value makes no sense.
    """

    gain_px: float = 0.05
    worse_rows_px: float = 0.02
    worse_depth_points: float = 1.0
    alpha: float = 0.01
    blind_rows_px: float = 1.5
    good_rows_px: float = 0.3
    good_surely: float = 0.95
    distances: tuple[float, ...] = JUDGED_AT

    def __post_init__(self) -> None:
        for name, value in self.limits.items():
            if not isinstance(value, Real) or isinstance(value, bool) or not np.isfinite(float(value)):
                raise InputError(f"tolerances: {name} is {value!r}; give a number.")
            if name in _PROBABILITIES and not 0.0 < value < 1.0:
                raise InputError(f"tolerances: {name} is {value:g}; a probability lies between 0 and 1.")
            if value < 0.0:
                raise InputError(f"tolerances: {name} is {value:g}; give 0 or more.")
        try:
            distances = tuple(float(distance) for distance in self.distances)
        except (TypeError, ValueError):
            raise InputError(
                f"tolerances: distances are {self.distances!r}; give numbers, such as (5, 10, 30)."
            ) from None
        if not distances or not all(1.0 <= distance < float("inf") for distance in distances):
            raise InputError(
                f"tolerances: distances are {self.distances!r}; give some, in baselines, each 1 or more and finite."
            )
        object.__setattr__(self, "distances", tuple(sorted(set(distances))))

    @property
    def limits(self) -> dict[str, float]:
        """All but the distances, by name."""
        return {name: value for name, value in asdict(self).items() if name != "distances"}


DEFAULT = Tolerances()
LIMITS = DEFAULT.limits


def as_tolerances(given: Tolerances | Mapping[str, object] | None) -> Tolerances:
    """Tolerances, or some of them by name; the others are the default.

    Raises:
        InputError: if a name is unknown, or a value makes no sense.
    """
    if given is None:
        return DEFAULT
    if isinstance(given, Tolerances):
        return given
    if not isinstance(given, Mapping):
        raise InputError(f"tolerances are {given!r}; give sr.Tolerances(...), or values by name.")
    for name in given:
        checked_choice(name, [*LIMITS, "distances"], "tolerance")
    return Tolerances(**given)  # pyright: ignore[reportArgumentType]: checked there
