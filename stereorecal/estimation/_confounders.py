"""Confounders: hypotheses beside the rig, each integrated as the rig alone is.

Twenty parameters explain half of an image that moved better than five do, and a field of small errors that stay
together lets them. What belongs to no rig has a cause: a region that moved, a shutter that rolled, an image that is
late. Each is a few parameters beside θ; where one wins, the rig solved beside it is the answer, and where it ties with
the rig alone the posterior has both. With several frames, a region that all of them have in common, as behind glass:
what moves in one of them is outvoted by the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior, drift_sizes
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._explanations import (
    Explanation,
    Hypothesis,
    best_of,
    explained_by,
    explanations,
    with_common_field,
)
from stereorecal.estimation._groups import PLACES
from stereorecal.estimation._linear_groups import DEVIATIONS, USUAL, LinearGroups, linear_groups, neighbours
from stereorecal.estimation._outlines import Offsets, outlines
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.objectives import RigChart

# Probabilities before any image is seen: of a hundred pairs some have something large that moves, and one is of cameras
# that read row by row, and not in step; images that belong together by their names are late more rarely.
_REGION, _ROLLING, _LATE = 0.05, 0.01, 0.005
# Pixels of row: what moves between two exposures, or while one is read, moves by a row or two; more finds no match.
MOVED = 1.5
ACROSS = 5.0  # of column, likewise: those cost no match
_TAKEN_TOGETHER = (0.0, 0.5, 1.0)  # rows of two images, as shares of their height
# Of the right camera between two exposures, percent of the baseline and degrees: as a vehicle moves in milliseconds,
# unlike a drift, which turns rather than shifts.
_LATE_SHIFT, _LATE_ANGLE = 20.0, 0.3
NEGLIGIBLE = 12.0  # nats below the best: what has no say
_DRIFTING = len(DRIFTING)


@dataclass(frozen=True, eq=False)
class Confounder:
    """Something besides the rig that moves rows of a frame.

    Attributes:
        name: of its kind.
        of_rig: (n, q) what it adds to θ, per unit of each of its parameters.
        of_groups: (g, q) pixels of row of each group, likewise.
        sizes: (q,) standard deviations of these parameters.
        log_prior: natural logarithm of its probability.
    """

    name: str
    of_rig: Float[np.ndarray, "n q"]
    of_groups: Float[np.ndarray, "g q"]
    sizes: Float[np.ndarray, "q"]
    log_prior: float

    @property
    def prior(self) -> tuple[Float[np.ndarray, "q q"], float]:
        """A root of the covariance of its parameters, and the logarithm of its probability."""
        return np.diag(self.sizes), self.log_prior

    def columns(self, rows: LinearGroups) -> Float[np.ndarray, "g q"]:
        """What each of its parameters does to rows."""
        return rows.jacobian @ self.of_rig + self.of_groups


def hypotheses_with_confounders(
    rows: LinearGroups, chart: RigChart, prior: CalibrationPrior, alone: Sequence[Explanation]
) -> list[Hypothesis]:
    """θ beside each confounder that may have a say, for rows near the rig that was fitted alone, against which they are
    weighed."""
    best, kind = best_of(alone)
    searched = _regions(rows, prior, best, kind)
    if len(rows.frames) == 1:  # as the rig moves; where frames show several scenes, it moves otherwise
        searched += [*_rolling(rows, chart), _late(rows)]
    if not searched:
        return []
    misfits = [(deviation, best.misfit[1]) for deviation in DEVIATIONS]
    of_all = {misfit: _likelihoods(rows, searched, misfit) for misfit in misfits}
    tried = []
    for index, confounder in enumerate(searched):
        normals = {misfit: of_all[misfit][index] for misfit in misfits}
        under = explained_by(normals, rows.likelihoods, prior, [best.prior], *confounder.prior)
        tried.append((best_of(under)[0], confounder))
    # Another prior of the calibration may suit a confounder better than it suits the rig alone: twice as far, then.
    again = []
    for one, confounder in _within_nats(tried, best, 2.0 * NEGLIGIBLE):
        normals = {one.misfit: of_all[one.misfit][searched.index(confounder)]}
        under = explained_by(normals, rows.likelihoods, prior, range(len(prior.roots)), *confounder.prior)
        again.append((best_of(under)[0], confounder))
    likely = _within_nats(again, best, NEGLIGIBLE)
    return [_hypothesis_with(rows, chart, prior, confounder, one) for one, confounder in likely]


def _log_evidence(one: Explanation) -> float:
    return float(one.found.log_evidence.max())


def _within_nats(
    tried: list[tuple[Explanation, Confounder]], alone: Explanation, nats: float
) -> list[tuple[Explanation, Confounder]]:
    """The explanations at most so many nats below the best of all."""
    least = max(_log_evidence(one) for one in (alone, *(one for one, _ in tried))) - nats
    return [(one, confounder) for one, confounder in tried if _log_evidence(one) > least]


def _hypothesis_with(
    rows: LinearGroups, chart: RigChart, prior: CalibrationPrior, confounder: Confounder, best_beside: Explanation
) -> Hypothesis:
    """θ beside a confounder, rows linear near its own: the rig alone may be far away, and groups that err alone are
    others."""
    kind = int(best_beside.found.log_evidence.argmax())
    theta, values = best_beside.found.means[kind], best_beside.found.nuisance[kind]
    rows = linear_groups(rows.groups, chart, theta, prior, rows.measured)
    moved = replace(rows, at_zero=rows.at_zero + confounder.columns(rows) @ values)
    rows = replace(rows, deviation=moved.robust(sum(best_beside.misfit), theta))
    deviation, common = best_beside.misfit
    beside = rows.with_columns(confounder.columns(rows))

    def under(deviations: Sequence[float], which: Sequence[int]) -> list[Explanation]:
        misfits = [(deviation, common) for deviation in deviations]
        return explanations(beside, prior, which, misfits, *confounder.prior)

    found = under([deviation], range(len(prior.roots)))
    least = _log_evidence(best_of(found)[0]) - NEGLIGIBLE
    some = [one.prior for one in found if _log_evidence(one) > least]
    found += under([one for one in neighbours(deviation, DEVIATIONS) if one != deviation], some)
    return Hypothesis(beside, found, best_of(found)[0].misfit, *confounder.prior)


def _likelihoods(rows: LinearGroups, confounders: Sequence[Confounder], misfit: tuple[float, float]) -> list[Normal]:
    """Of θ and of the parameters of each confounder."""
    columns = [confounder.columns(rows) for confounder in confounders]
    whole = rows.with_columns(np.column_stack(columns)).normal(misfit[0])
    n, found = rows.jacobian.shape[1], []
    ends = n + np.cumsum([0, *(some.shape[1] for some in columns)])
    for start, end in pairwise(ends):
        where = np.r_[:n, start:end, ends[-1] : len(whole.b)]  # behind the confounders: the field of all frames
        found.append(with_common_field(rows, Normal(whole.a[np.ix_(where, where)], whole.b[where], whole.c), misfit[1]))
    return found


def _rolling(rows: LinearGroups, chart: RigChart) -> list[Confounder]:
    """The right image is read row by row while its camera turns (a left one is nearly the negative): rows move as far
    as they lie from the row that was taken with the other image, the first, middle or last. A shutter never moves all
    rows by as much; a drift does. Derivatives are those near the rig that was fitted alone, also when a confounder is
    fitted anew."""
    right, n = chart.rig.right, rows.jacobian.shape[1]
    down = right.project(rows.groups.right)[:, 1:] / right.size[1]
    # By a pixel of the right image, down and across, as lenses bend it.
    moved = -rows.jacobian[:, [chart.names.index(f"right.{centre}") for centre in ("cy", "cx")]]
    log_prior = float(np.log(_ROLLING / len(_TAKEN_TOGETHER)))
    sizes = np.array([MOVED, ACROSS])
    return [Confounder("rolling", np.zeros((n, 2)), moved * (down - row), sizes, log_prior) for row in _TAKEN_TOGETHER]


def _late(rows: LinearGroups) -> Confounder:
    """One image is late and its camera has moved: a drift of another size."""
    angles, (g, n) = 3, rows.jacobian.shape
    sizes = np.r_[np.full(angles, _LATE_ANGLE), np.full(_DRIFTING - angles, _LATE_SHIFT)]
    return Confounder("late", np.eye(n, _DRIFTING), np.zeros((g, _DRIFTING)), sizes, float(np.log(_LATE)))


def _regions(rows: LinearGroups, prior: CalibrationPrior, best: Explanation, kind: int) -> list[Confounder]:
    """Parts of the view that moved as a whole, in all frames by as much, searched under the drift that the rig alone
    has, and without any."""
    n, places = rows.jacobian.shape[1], np.eye(PLACES[0] * PLACES[1])[rows.groups.place]
    of_places = with_common_field(rows, rows.with_columns(places).normal(USUAL), best.misfit[1])
    of_places, sizes = of_places.around(prior.means[best.prior]), drift_sizes()[0]
    offsets = []
    for drift in {tuple(sizes[kind]), tuple(sizes[0])}:
        offsets.append(_offsets(of_places, np.column_stack([prior.roots[best.prior], np.eye(n, _DRIFTING) * drift])))
    found = []
    for label, log_prior in outlines(offsets, np.any(places, axis=0)):
        columns, size = label[rows.groups.place][:, None].astype(float), np.array([MOVED])
        found.append(Confounder("region", np.zeros((n, 1)), columns, size, float(np.log(_REGION)) + log_prior))
    return found


def _offsets(normal: Normal, of_theta: Float[np.ndarray, "n m"]) -> Offsets:
    """The likelihood of offsets of the places, θ integrated; of_theta: a root of its covariance."""
    n = len(of_theta)
    cross = of_theta.T @ normal.a[:n, n:]
    inner = np.eye(of_theta.shape[1]) + of_theta.T @ normal.a[:n, :n] @ of_theta
    solved = np.linalg.solve(inner, np.column_stack([cross, of_theta.T @ normal.b[:n]]))
    return Offsets(normal.a[n:, n:] - cross.T @ solved[:, :-1], normal.b[n:] - cross.T @ solved[:, -1], MOVED)
