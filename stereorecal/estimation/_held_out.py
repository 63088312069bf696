"""What a part of the images says of a rig that the rest tells: parts are left out, one after the other.

In closed form: the rest's normal equations are those of its own rows, whose covariance is a block of the whole one; its
posterior is that of every hypothesis beside every prior, as the estimate's is; and rows are linear near the estimate.
Nuisance parameters are estimated anew from the rest, and not applied to the part, which may be the one that moved.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._explanations import Hypothesis, mixture
from stereorecal.estimation._groups import PLACES, Groups
from stereorecal.estimation._posterior import Posterior

_THIRDS = 3
_PLACES = 4  # at most: so many times as many frames, and each of these is left out with the others of its fourth
_FEWEST = 6  # groups in a part, and in the rest
_SAME_PLACE = 1.0  # pixels of disparity: what a matcher tells apart


@dataclass(frozen=True)
class HeldOut:
    """|Row differences| of a part, on average over its correspondences; pixels.

    Attributes:
        name: of the part.
        count: of its correspondences.
        before: under the initial rig.
        after: under the candidate of the rest.
        fitted: under the candidate of all.
    """

    name: str
    count: int
    before: float
    after: float
    fitted: float


def parts_of(groups: Groups) -> Iterator[tuple[str, Bool[np.ndarray, "g"]]]:
    """Thirds of the view over all frames, by columns and by rows; and places, where frames show several."""
    row, column = np.divmod(groups.place, PLACES[0])
    for kind, of_kind, number in (("columns", column, PLACES[0]), ("rows", row, PLACES[1])):
        third = of_kind * _THIRDS // number
        yield from ((f"{kind} {index + 1} of {_THIRDS}", third == index) for index in range(_THIRDS))
    places = frames_by_place(groups)
    for part in range(min(len(places), _PLACES) if len(places) > 1 else 0):
        frames = [frame for place in places[part::_PLACES] for frame in place]
        yield f"frames {', '.join(map(str, frames))}", np.isin(groups.frame, frames)


def rests(
    groups: Groups, hypotheses: Sequence[Hypothesis], prior: CalibrationPrior
) -> Iterator[tuple[str, Bool[np.ndarray, "g"], Posterior]]:
    """Each part that shows enough, and what the rest knows of θ."""
    likely = [index for index, weight in enumerate(prior.weights) if weight > 0.0]
    for name, inside in parts_of(groups):
        if min(np.count_nonzero(inside), np.count_nonzero(~inside)) < _FEWEST:
            continue
        several = [one for some in hypotheses for one in some.explained(prior, likely, some.rows.of(~inside))]
        yield name, inside, mixture(several)


def frames_by_place(groups: Groups) -> list[tuple[int, ...]]:
    """Numbers of the frames, those of the same place together. Frames between which half of what both show hardly
    changes its disparity err alike: neither tests what the other says."""
    frames = np.unique(groups.frame)
    disparity = np.stack([_disparities(groups.of(groups.frame == frame)) for frame in frames])
    found: list[list[int]] = []
    for index in range(len(frames)):
        same = (place for place in found if any(_same_disparity(disparity[index], disparity[other]) for other in place))
        place = next(same, None)
        found.append([index]) if place is None else place.append(index)
    return [tuple(frames[place].tolist()) for place in found]


def _disparities(groups: Groups) -> Float[np.ndarray, "p"]:
    """At each place of the view, on average; NaN where nothing is shown."""
    size = int(np.prod(PLACES))
    number = np.bincount(groups.place, groups.count, size)
    total = np.bincount(groups.place, groups.count * groups.disparity, size)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def _same_disparity(one: Float[np.ndarray, "p"], other: Float[np.ndarray, "p"]) -> bool:
    both = np.isfinite(one) & np.isfinite(other)
    return bool(both.any()) and float(np.median(np.abs(one - other)[both])) < _SAME_PLACE
