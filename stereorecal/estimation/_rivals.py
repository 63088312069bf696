"""Rival explanations of misfit: hypotheses beside the rig, each integrated as the rig alone is.

Twenty parameters explain half of an image that moved better than five do, and a field of small errors that stay
together lets them. What belongs to no rig has a cause: a region that moved, a shutter that rolled, an image that is
late. Each is a few parameters of one frame beside θ; where one wins, the rig solved beside it is the answer, and where
it ties with the rig alone the posterior has both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._drift import drift_sizes
from stereorecal.estimation._evidence import Normal, explained, without
from stereorecal.estimation._explanations import Explanation, LinearRows, best_of, linear_rows
from stereorecal.estimation._groups import PLACES
from stereorecal.estimation._misfit import DEVIATIONS, alike
from stereorecal.estimation._outlines import Offsets, outlines
from stereorecal.estimation._parameters import DRIFTING
from stereorecal.estimation._posterior import root
from stereorecal.objectives import RigChart

# Probabilities before any image is seen: of a hundred pairs some have something large that moves, and some are of one
# camera that reads row by row; images that belong together by their names are late more rarely.
_REGION, _ROLLING, _LATE = 0.05, 0.05, 0.02
# Pixels of row: what moves between two exposures, or while one is read, moves by a row or two; more finds no match.
MOVED = 1.5
# Of the right camera between two exposures, percent of the baseline and degrees: as a vehicle moves in milliseconds,
# unlike a drift, which turns rather than shifts.
_LATE_SHIFT, _LATE_ANGLE = 20.0, 0.3
_SEARCHED_AT = 0.07  # pixels of misfit beside a region, while its outline is searched: that of most good pairs, or more
_FRAMES = 3  # those that fit worst, in which regions are searched
_FAR = 12.0  # nats below the best: what has no say
_N = PLACES[0] * PLACES[1]
_DRIFTING = len(DRIFTING)
_ROOT_OF_FIELD = root(alike(np.arange(_N)))


@dataclass(frozen=True, eq=False)
class Rival:
    """Something besides the rig that moves rows of a frame.

    Attributes:
        name: of its kind.
        frame: index of the frame among those of `LinearRows`.
        of_rig: (n, q) what it adds to θ in that frame, per unit of each of its parameters.
        of_places: (p, q) pixels of row at each place, likewise.
        sizes: (q,) standard deviations of these parameters.
        log_prior: natural logarithm of its probability.
    """

    name: str
    frame: int
    of_rig: Float[np.ndarray, "n q"]
    of_places: Float[np.ndarray, "p q"]
    sizes: Float[np.ndarray, "q"]
    log_prior: float

    def moved(self, rows: LinearRows, values: Float[np.ndarray, "q"]) -> LinearRows:
        """Rows that what it does has been added to."""
        here, at_zero = rows.frames[self.frame], rows.at_zero.copy()
        by_place = (self.of_places @ values)[rows.groups.place[here]]
        at_zero[here] += rows.jacobian[here] @ (self.of_rig @ values) + by_place
        return replace(rows, at_zero=at_zero)


@dataclass(frozen=True, eq=False)
class Beside:
    """θ beside a rival: explanations for `mixture`, of which the rival's probability is a part."""

    rival: Rival
    several: list[Explanation]


def beside_rivals(
    rows: LinearRows, chart: RigChart, prior: CalibrationPrior, alone: Sequence[Explanation]
) -> list[Beside]:
    """θ beside each rival that may have a say.

    Args:
        rows: near the rig that was fitted alone.
        chart: the map from θ to rigs.
        prior: of the calibration.
        alone: the rig alone, which rivals are weighed against.
    """
    best, kind = best_of(alone)
    of_all = {d: _likelihoods(rows, d) for d in {*DEVIATIONS, _SEARCHED_AT}}
    worst = _worst(rows, best.found.means[kind])
    searched = [_rolling(rows, worst[0]), _late(rows, worst[0])]
    for frame in worst[:_FRAMES]:
        around = [one.around(prior.means[best.prior]) for one in of_all[_SEARCHED_AT]]
        searched += _regions(rows, around, frame, prior.roots[best.prior], kind)
    tried = []
    for rival in searched:
        under = [
            one
            for d in DEVIATIONS
            for one in _explained(of_all[d], rows.told, rival, prior, [best.prior], (d, best.misfit[1]))
        ]
        tried.append((best_of(under)[0], rival))
    # Another prior of the calibration may suit a rival better than it suits the rig alone: twice as far, then.
    tried = _with_a_say(tried, best, 2.0 * _FAR)
    every = range(len(prior.roots))
    tried = [
        (best_of(_explained(of_all[one.misfit[0]], rows.told, rival, prior, every, one.misfit))[0], rival)
        for one, rival in tried
    ]
    return [_solved(rows, chart, prior, rival, one) for one, rival in _with_a_say(tried, best, _FAR)]


def _log_evidence(one: Explanation) -> float:
    return float(one.found.log_evidence.max())


def _with_a_say(
    tried: list[tuple[Explanation, Rival]], alone: Explanation, far: float
) -> list[tuple[Explanation, Rival]]:
    """Those at most so many nats below the best of all."""
    least = max(_log_evidence(one) for one in (alone, *(one for one, _ in tried))) - far
    return [(one, rival) for one, rival in tried if _log_evidence(one) > least]


def _solved(rows: LinearRows, chart: RigChart, prior: CalibrationPrior, rival: Rival, near: Explanation) -> Beside:
    """All explanations beside a rival, linear near its own θ: the rig alone may be far away, and groups that err alone
    are others."""
    kind = int(near.found.log_evidence.argmax())
    theta, values = near.found.means[kind], near.found.nuisance[kind]
    rows = linear_rows(rows.groups, chart, theta, rows.beams)
    rows = replace(rows, deviation=rival.moved(rows, values).robust(sum(near.misfit), theta))
    at, common = DEVIATIONS.index(near.misfit[0]), near.misfit[1]
    every = range(len(prior.roots))
    found = _explained(_likelihoods(rows, DEVIATIONS[at]), rows.told, rival, prior, every, near.misfit)
    least = _log_evidence(best_of(found)[0]) - _FAR
    some = [one.prior for one in found if _log_evidence(one) > least]
    for beside in {max(at - 1, 0), min(at + 1, len(DEVIATIONS) - 1)} - {at}:
        deviation = DEVIATIONS[beside]
        found += _explained(_likelihoods(rows, deviation), rows.told, rival, prior, some, (deviation, common))
    return Beside(rival, found)


def _likelihoods(rows: LinearRows, misfit: float) -> list[Normal]:
    """Of θ and of offsets of all places, for each frame."""
    return [
        replace(
            rows,
            jacobian=np.column_stack([rows.jacobian, np.eye(_N)[rows.groups.place]]),
            frames=[frame],
        ).normal(misfit)
        for frame in rows.frames
    ]


def _explained(
    of_frames: Sequence[Normal],
    told: Sequence[tuple[float, Normal]],
    rival: Rival,
    prior: CalibrationPrior,
    which: Sequence[int],
    misfit: tuple[float, float],
) -> list[Explanation]:
    """θ beside a rival for some of the covariances of the calibration's prior, and all kinds of drift."""
    sizes, weights = _kinds_of_drift()
    normal, nuisance = _beside(of_frames, rival, misfit[1]), np.diag(rival.sizes)
    found = []
    for (log_prior, of_beams), index in product(told, which):
        both = normal + of_beams.with_nuisance(len(nuisance))
        logs = np.log(weights * prior.weights[index]) + log_prior + rival.log_prior
        under = explained(both, prior.roots[index], prior.means[index], nuisance, sizes, logs)
        found.append(Explanation(misfit, index, under, both, nuisance))
    return found


_kinds_of_drift = cache(drift_sizes)


def _beside(of_frames: Sequence[Normal], rival: Rival, common: float) -> Normal:
    """The likelihood of θ and of the parameters of a rival; the field that all frames have in common is integrated."""
    n, q = rival.of_rig.shape
    fields = _N if len(of_frames) > 1 else 0
    # θ, the rival's, the common field; to θ and offsets of a frame.
    plain = np.zeros((n + _N, n + q + fields))
    plain[:n, :n] = np.eye(n)
    plain[n:, n + q :] = np.eye(_N)[:, :fields]
    own = plain.copy()
    own[:, n : n + q] = np.concatenate([rival.of_rig, rival.of_places])
    total = Normal(np.zeros((n + q + fields,) * 2), np.zeros(n + q + fields), 0.0)
    for index, normal in enumerate(of_frames):
        to = own if index == rival.frame else plain
        total = total + Normal(to.T @ normal.a @ to, to.T @ normal.b, normal.c)
    return without(total, common * _ROOT_OF_FIELD) if fields else total


def _worst(rows: LinearRows, theta: Float[np.ndarray, "n"]) -> list[int]:
    """Frames, the one with the largest residuals first."""
    residual = rows.residual(theta)
    return sorted(range(len(rows.frames)), key=lambda i: -float(np.mean(residual[rows.frames[i]] ** 2)))


def _rolling(rows: LinearRows, frame: int) -> Rival:
    """One image is read row by row while its camera turns: rows move as far as they lie down the image. Which row was
    taken with the other image is not known: it may be the first or the last."""
    down = (np.arange(_N) // PLACES[0] + 0.5) / PLACES[1] - 0.5
    columns = np.column_stack([down, np.ones(_N)])
    sizes = np.array([MOVED, 0.5 * MOVED])
    return Rival("rolling", frame, np.zeros((rows.jacobian.shape[1], 2)), columns, sizes, float(np.log(_ROLLING)))


def _late(rows: LinearRows, frame: int) -> Rival:
    """One image is late and its camera has moved: a drift of another size, of this frame alone."""
    columns = np.eye(rows.jacobian.shape[1])[:, :_DRIFTING]
    angles = 3
    sizes = np.r_[np.full(angles, _LATE_ANGLE), np.full(_DRIFTING - angles, _LATE_SHIFT)]
    return Rival("late", frame, columns, np.zeros((_N, _DRIFTING)), sizes, float(np.log(_LATE)))


def _regions(
    rows: LinearRows, of_frames: Sequence[Normal], frame: int, calibration: Float[np.ndarray, "n n"], kind: int
) -> list[Rival]:
    """Parts of a frame that moved as a whole, searched under the drift that the rig alone has, and without any."""
    n = rows.jacobian.shape[1]
    present = np.isin(np.arange(_N), rows.groups.place[rows.frames[frame]])
    sizes = drift_sizes()[0]
    offsets = []
    for drift in {tuple(sizes[kind]), tuple(sizes[0])}:
        of_theta = np.column_stack([calibration, np.eye(n)[:, :_DRIFTING] * drift])
        offsets.append(_offsets(of_frames, frame, of_theta))
    found = []
    here = float(np.log(_REGION / len(rows.frames)))
    for label, log_prior in outlines(offsets, present):
        columns, sizes = label[:, None].astype(float), np.array([MOVED])
        found.append(Rival("region", frame, np.zeros((n, 1)), columns, sizes, here + log_prior))
    return found


def _offsets(of_frames: Sequence[Normal], frame: int, of_theta: Float[np.ndarray, "n m"]) -> Offsets:
    """The likelihood of offsets of the places of a frame, θ integrated; of_theta: a root of its covariance."""
    n = len(of_theta)
    a, b = (sum(part) for part in zip(*((one.a[:n, :n], one.b[:n]) for one in of_frames), strict=True))
    here = of_frames[frame]
    cross = of_theta.T @ here.a[:n, n:]
    inner = np.eye(of_theta.shape[1]) + of_theta.T @ a @ of_theta
    solved = np.linalg.solve(inner, np.column_stack([cross, of_theta.T @ b]))
    return Offsets(here.a[n:, n:] - cross.T @ solved[:, :-1], here.b[n:] - cross.T @ solved[:, -1], MOVED)
