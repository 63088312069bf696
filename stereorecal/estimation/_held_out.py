"""What a part of the images says of a rig that the rest tells: parts are left out, one after the other.

In closed form: the rest's normal equations are those of its own rows, whose covariance is a block of the whole one; its
posterior is that of every hypothesis beside every prior, as the estimate's is; and rows are linear near the estimate.
Nuisance parameters are estimated anew from the rest, and not applied to the part, which may be the one that moved.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._explanations import Hypothesis, mixture
from stereorecal.estimation._groups import PLACES, Groups
from stereorecal.estimation._posterior import Posterior

_THIRDS = 3
_PLACES = 4  # at most: so many times as many frames, and each of these is left out with the others of its fourth
_FEWEST = 6  # groups in a part, and in the rest


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
    """Thirds of the view over all frames, by columns and by rows; and frames, where these do not all show the same."""
    row, column = np.divmod(groups.place, PLACES[0])
    for kind, of_kind, number in (("columns", column, PLACES[0]), ("rows", row, PLACES[1])):
        third = of_kind * _THIRDS // number
        yield from ((f"{kind} {index + 1} of {_THIRDS}", third == index) for index in range(_THIRDS))
    scenes = np.unique(groups.frame)
    for part in range(min(len(scenes), _PLACES) if len(scenes) > 1 else 0):
        some = scenes[part::_PLACES]
        frames = np.flatnonzero(np.isin(groups.first, some)).tolist()
        yield f"frames {', '.join(map(str, frames))}", np.isin(groups.frame, some)


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
