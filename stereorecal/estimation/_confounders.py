"""Confounders: hypotheses beside the rig, each integrated as the rig alone is.

Twenty parameters explain half of an image that moved better than five do, and a field of small errors that stay
together lets them. What belongs to no rig has a cause: a region that moved, a shutter that rolled, an image that is
late. Each is a few parameters beside θ; where one wins, the rig solved beside it is the answer, and where it ties with
the rig alone the posterior has both. With several frames, a region that all of them have in common, as behind glass, or
another one in each.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import pairwise
from operator import add

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.estimation._calibration_prior import drift_sizes
from stereorecal.estimation._evidence import ALONE, Explanation, Normal, Nuisances, marginal
from stereorecal.estimation._explanations import NEGLIGIBLE, Hypothesis, best_of, explained_by, hypothesis_near
from stereorecal.estimation._groups import PLACES
from stereorecal.estimation._linear_groups import DEVIATIONS, USUAL, LinearGroups
from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._outlines import MOVED, outlines
from stereorecal.estimation._rig_parameters import DRIFTING

# Probabilities before any image is seen: of a hundred pairs some have something large that moves, and one is of cameras
# that read row by row, and not in step; images that belong together by their names are late more rarely.
_REGION, _ROLLING, _LATE = 0.05, 0.01, 0.005
_ACROSS = 5.0  # pixels of column, as `MOVED` of row: those cost no match
_TAKEN_TOGETHER = (0.0, 0.5, 1.0)  # rows of two images, as shares of their height
# Of the right camera between two exposures, percent of the baseline and degrees: as a vehicle moves in milliseconds,
# unlike a drift, which turns rather than shifts.
_LATE_SIZES = np.array([0.3, 0.3, 0.3, 20.0, 20.0])
_DRIFTING = len(DRIFTING)
_SEARCHED = (USUAL, 0.0)  # the misfit under which regions of single frames are searched

_Region = tuple[Int[np.ndarray, "g"], Bool[np.ndarray, "p"], float]  # groups, places, log of its probability


@dataclass(frozen=True, eq=False)
class Confounder:
    """Something besides the rig that moves rows of a frame.

    Attributes:
        nuisances: its parameters.
        columns: (g, q) what each of them does to rows that are linear near some θ.
    """

    nuisances: Nuisances
    columns: Callable[[LinearGroups], Float[np.ndarray, "g q"]]


def hypotheses_with_confounders(rows: LinearGroups, alone: Sequence[Explanation]) -> list[Hypothesis]:
    """θ beside each confounder that may have a say, for rows near the rig that was fitted alone, against which they are
    weighed."""
    best, model = best_of(alone), rows.model
    searched = [*_regions(rows, best)]
    if len(rows.frames) == 1:  # as the rig moves; where frames show several scenes, it moves otherwise
        searched += [*_rolling(rows), _late()]
    if not searched:
        return []
    misfits = [(deviation, best.misfit[1]) for deviation in DEVIATIONS]
    of_all = {misfit: _likelihoods(rows, searched, misfit) for misfit in misfits}

    def tried(index: int, misfits: Sequence[tuple[float, float]], which: Sequence[int]) -> Explanation:
        normals = {misfit: of_all[misfit][index] for misfit in misfits}
        return best_of(explained_by(model, normals, rows.likelihoods, which, searched[index].nuisances))

    found = {index: tried(index, misfits, [best.prior]) for index in range(len(searched))}
    # Another prior of the calibration may suit a confounder better than it suits the rig alone: twice as far, then.
    near, every = _within_nats(found, best, 2.0 * NEGLIGIBLE), range(len(model.prior.roots))
    again = {index: tried(index, [one.misfit], every) for index, one in near.items()}
    likely = _within_nats(again, best, NEGLIGIBLE)
    return [_hypothesis_with(rows, searched[index], one) for index, one in likely.items()]


def _within_nats(tried: dict[int, Explanation], alone: Explanation, nats: float) -> dict[int, Explanation]:
    """The explanations at most so many nats below the best of all."""
    least = max(one.most for one in (alone, *tried.values())) - nats
    return {index: one for index, one in tried.items() if one.most > least}


def _hypothesis_with(rows: LinearGroups, confounder: Confounder, likely: Explanation) -> Hypothesis:
    """θ beside a confounder, rows linear near its own: the rig alone may be far away, and groups that err alone are
    others."""
    rows = rows.model.linear(rows.groups, likely.theta)
    columns, (deviation, common) = confounder.columns(rows), likely.misfit
    moved = replace(rows, at_zero=rows.at_zero + columns @ likely.nuisance_means[likely.best])
    robust = moved.robust(deviation + common, likely.theta).deviation
    rows = replace(rows, deviation=robust).beside(confounder.nuisances, columns)
    return hypothesis_near(rows, likely.misfit)


def _likelihoods(rows: LinearGroups, confounders: Sequence[Confounder], misfit: tuple[float, float]) -> list[Normal]:
    """The likelihoods of θ and of the parameters of each confounder."""
    columns = [confounder.columns(rows) for confounder in confounders]
    whole, n = replace(rows, jacobian=np.column_stack([rows.jacobian, *columns])).normal(misfit), rows.jacobian.shape[1]
    ends = n + np.cumsum([0, *(some.shape[1] for some in columns)])
    return [whole.of(np.r_[:n, start:end]) for start, end in pairwise(ends)]


def _rolling(rows: LinearGroups) -> Iterator[Confounder]:
    """The right image is read row by row while its camera turns (a left one is nearly the negative): rows move as far
    as they lie from the row that was taken with the other image, the first, middle or last. A shutter never moves all
    rows by as much; a drift does. Derivatives are those near the rig that was fitted alone, also when a confounder is
    fitted anew."""
    chart = rows.model.chart
    right = chart.rig.right
    nuisances = Nuisances(np.array([MOVED, _ACROSS]), float(np.log(_ROLLING / len(_TAKEN_TOGETHER))))
    down = right.project(rows.groups.right)[:, 1:] / right.size[1]
    # By a pixel of the right image, down and across, as lenses bend it.
    moved = -rows.jacobian[:, [chart.names.index(f"right.{centre}") for centre in ("cy", "cx")]]
    for row in _TAKEN_TOGETHER:
        yield Confounder(nuisances, lambda _, columns=moved * (down - row): columns)


def _late() -> Confounder:
    """One image is late and its camera has moved: a drift of another size."""
    return Confounder(Nuisances(_LATE_SIZES, float(np.log(_LATE))), lambda rows: rows.jacobian[:, :_DRIFTING])


def _regions(rows: LinearGroups, best: Explanation) -> Iterator[Confounder]:
    """Parts of the view that moved as a whole: in all frames by as much, searched under the drift that the rig alone
    has, and without any; or in each another one."""
    sizes, of_both = drift_sizes()[0], rows.beside_places.normal((USUAL, best.misfit[1]))
    offsets = [
        _offsets(of_both, rows.model.prior, best, np.array(drift))
        for drift in {tuple(sizes[best.best]), tuple(sizes[0])}
    ]
    for _, label, log_prior in outlines(offsets, _present(rows)):
        yield _moved([(np.arange(len(rows.groups)), label, log_prior)], rows)
    if len(rows.frames) > 1 and (own := _regions_of_frames(rows, best, sizes[best.best])):
        yield _moved(own, rows)


def _regions_of_frames(rows: LinearGroups, best: Explanation, drift: Float[np.ndarray, "5"]) -> list[_Region]:
    """The region of each frame that gains by one, beside what the other frames tell with theirs."""
    frames = [rows.of(np.isin(np.arange(len(rows.groups)), frame)) for frame in rows.frames]
    told, found = [alone.normal(_SEARCHED) for alone in frames], {}
    of_all = reduce(add, told)
    for index, alone in list(enumerate(frames)) * 2:  # the first ones anew, beside what moved in the last ones
        others, told[index] = of_all - told[index], alone.normal(_SEARCHED)
        found.pop(index, None)
        of_both = alone.beside_places.normal(_SEARCHED) + others.with_nuisance(PLACES[0] * PLACES[1])
        offsets = _offsets(of_both, rows.model.prior, best, drift)
        for log_evidence, label, log_prior in outlines([offsets], _present(alone))[:1]:
            if log_evidence + np.log(_REGION) > 0.0:
                found[index] = rows.frames[index], label, log_prior
                beside = alone.beside(ALONE, label[alone.groups.place][:, None].astype(float))
                told[index] = marginal(beside.normal(_SEARCHED), np.array([[MOVED]]))
        of_all = others + told[index]
    return list(found.values())


def _moved(regions: Sequence[_Region], rows: LinearGroups) -> Confounder:
    """Regions that moved, each by itself."""
    columns = np.zeros((len(rows.groups), len(regions)))
    for column, (which, label, _) in zip(columns.T, regions, strict=True):
        column[which] = label[rows.groups.place[which]]
    log_prior = sum(float(np.log(_REGION)) + log_prior for *_, log_prior in regions)
    return Confounder(Nuisances(np.full(len(regions), MOVED), log_prior), lambda _: columns)


def _offsets(of_both: Normal, prior: Mixture, best: Explanation, drift: Float[np.ndarray, "5"]) -> Normal:
    """The likelihood of an offset of each place by that of θ and of these, θ integrated under a drift of these
    sizes."""
    n = prior.means.shape[1]
    of_places = of_both.around(prior.means[best.prior]).of(np.r_[n : len(of_both.b), :n])
    return marginal(of_places, np.column_stack([prior.roots[best.prior], np.eye(n, _DRIFTING) * drift]))


def _present(rows: LinearGroups) -> Bool[np.ndarray, "p"]:
    return np.isin(np.arange(PLACES[0] * PLACES[1]), rows.groups.place)
