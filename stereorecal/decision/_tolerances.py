"""What a change must gain, what counts as worse, how sure that must be, and what images must show: all numbers of the
decision."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from numbers import Real

import numpy as np

from stereorecal._errors import InputError, checked_choice
from stereorecal.estimation import Matters

_SHARES = ("leaves", "better", "harm", "predicts", "good_surely")


@dataclass(frozen=True)
class Tolerances:
    """What is asked of a change of calibration. The defaults are the same for all rigs.

    Attributes:
        rows_px: of row error, that a matcher notices: the unit of the loss, and more than this is worse.
        depth_points: the same of the error of depth, in percentage points.
        leaves: share of the expected loss that a repair leaves, at most; it gains one unit of it, at least.
        better: probability that the loss falls, at least.
        harm: probability that rows, or depth ahead at the farthest distance, become worse, at most.
        predicts: row error of parts of the images that were left out, under what the rest says, at most, as a share of
            theirs under the initial calibration; and the share of what the candidate gains on them that is there, too,
            at least.
        good_rows_px: row error of a good calibration, at most, where images show something.
        good_surely: probability of that, at least.
        distances: in baselines, at which rows and depth count over the view.

    Raises:
        InputError: if a value makes no sense.
    """

    rows_px: float = 0.05
    depth_points: float = 1.0
    leaves: float = 0.7
    better: float = 0.9
    harm: float = 0.02
    predicts: float = 0.8
    good_rows_px: float = 0.3
    good_surely: float = 0.95
    distances: tuple[float, ...] = Matters().distances

    def __post_init__(self) -> None:
        for name, value in self.limits.items():
            if not isinstance(value, Real) or isinstance(value, bool) or not np.isfinite(float(value)):
                raise InputError(f"tolerances: {name} is {value!r}; give a number.")
            if name in _SHARES and not 0.0 < value < 1.0:
                raise InputError(f"tolerances: {name} is {value:g}; it lies between 0 and 1.")
            if value <= 0.0:
                raise InputError(f"tolerances: {name} is {value:g}; give more than 0.")
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

    @property
    def matters(self) -> Matters:
        """What counts as an error."""
        return Matters(self.rows_px, self.depth_points, self.distances)


DEFAULT = Tolerances()
STEPS = 8  # in which a change of depth is made
COSTS = (4.0, 16.0, 64.0)  # times that its square may cost: half the change each
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


@dataclass(frozen=True)
class Enough:
    """What images must show for a verdict.

    Attributes:
        matches: correspondences: five parameters from fewer would be guessing.
        covered: share of the image that they cover: good rigs cover a half, chance matches a twentieth.
        places: tiles of a frame that show something.
        of_texture: share of what has texture that an aligned rig covers: a half and more; rigs a degree out a fifth.
            Below twice this, mistakes in the input are looked for.
        lost: of what the candidate matches, what it may lose where the initial calibration matches: 0 to 0.11 where
            repairs end well.
        reach: how far a candidate may lie away, in reaches: the search goes so far.
        misfit_px: systematic errors in no parameter: more is no rig.
    """

    matches: int = 60
    covered: float = 0.1
    places: int = 6
    of_texture: float = 0.25
    lost: float = 0.15
    reach: float = 2.0
    misfit_px: float = 0.8


ENOUGH = Enough()
