"""All numbers of the decision: what a change must gain, what counts as worse, how sure that must be, and what the
images must show."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from numbers import Real

import numpy as np

from stereorecal._errors import InputError, checked_choice
from stereorecal.estimation import Matters

_SHARES = ("leaves", "better", "harm", "predicts", "good_surely")


@dataclass(frozen=True)
class Tolerances:
    """What is asked of a change of calibration. The defaults are the same for all rigs.

    Attributes:
        rows_px: the epipolar error [px] that a matcher notices. It is the unit of the loss; a mean that grows by more
            is worse.
        depth_points: the same for the depth error, in percentage points.
        gains: the least fall of the expected loss, in its units.
        leaves: the largest share of the expected loss that a repair may leave.
        better: the least probability that the loss falls.
        harm: the largest probability that the epipolar error, or the depth error ahead at the farthest distance,
            becomes worse.
        predicts: parts of the images are left out in turn, and predicted by the rest. This is the largest share of
            their epipolar error that may remain, and the least share of the candidate's gain on them to be predicted.
        good_rows_px: the largest epipolar error [px] of a good calibration, where the images show something.
        good_surely: the least probability of that.
        distances: in baselines, at which epipolar and depth errors count over the view.

    Raises:
        InputError: if a value makes no sense.
    """

    rows_px: float = 0.05
    depth_points: float = 1.0
    gains: float = 1.0
    leaves: float = 0.7
    better: float = 0.9
    harm: float = 0.02
    predicts: float = 0.8
    good_rows_px: float = 0.3
    good_surely: float = 0.95
    distances: tuple[float, ...] = Matters().distances

    def __post_init__(self) -> None:
        for name in LIMITS:
            value: float = getattr(self, name)
            if not isinstance(value, Real) or isinstance(value, bool) or not np.isfinite(float(value)):
                raise InputError(f"tolerances: {name} is {value!r}; give a number.")
            if name in _SHARES and not 0.0 < value < 1.0:
                raise InputError(f"tolerances: {name} is {value:g}; it lies between 0 and 1.")
            if value <= 0.0:
                raise InputError(f"tolerances: {name} is {value:g}; give more than 0.")
        try:
            distances = tuple(float(distance) for distance in self.distances)
        except (TypeError, ValueError):
            distances = ()
        if not distances or not all(1.0 <= distance < float("inf") for distance in distances):
            raise InputError(
                f"tolerances: distances are {self.distances!r}; give some, in baselines, each 1 or more and finite, "
                "such as (5, 10, 30)."
            )
        object.__setattr__(self, "distances", tuple(sorted(set(distances))))

    @property
    def matters(self) -> Matters:
        """The units of the loss, and the distances."""
        return Matters(self.rows_px, self.depth_points, self.distances)


LIMITS = {field.name: field.default for field in fields(Tolerances) if field.name != "distances"}
DEFAULT = Tolerances()
STEPS = 8  # in which a change of depth is made
COSTS = (4.0, 16.0, 64.0)  # times that its square may cost: half the change each


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
        matches: the least number of correspondences.
        covered: the least share of the image that they cover, where they may be chance, which covers a twentieth.
        places: the least number of tiles of a frame that show something.
        of_texture: the least share of the textured image that matches cover: under an aligned rig they cover a half and
            more, under one that is a degree off a fifth. Below twice this, what matches by chance is measured, and
            mistakes in the input are looked for.
        by_chance: the least number of times as many matches as with the rows off: 17 to 500 where repairs end well, 1
            to 2.4 where they are off by a period of bricks or slats.
        lost: the largest share of its matches that a candidate may lose where the initial calibration matches; 0 to
            0.11 where repairs end well.
        reach: the largest distance of a candidate, in reaches.
        lens_change: the largest change of a focal length or k1, in standard deviations of the worst calibrations.
        misfit_px: the largest systematic epipolar error [px] that no parameter explains.
    """

    matches: int = 60
    covered: float = 0.1
    places: int = 6
    of_texture: float = 0.25
    by_chance: float = 5.0
    lost: float = 0.15
    reach: float = 2.0
    lens_change: float = 2.0
    misfit_px: float = 0.8


ENOUGH = Enough()
