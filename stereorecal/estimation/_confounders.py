"""Confounders: hypotheses beside the rig, each integrated as the rig alone is.

Twenty parameters explain half of an image that moved better than five do, and a field of small errors that stay
together lets them. What belongs to no rig has a cause: a region that moved, a shutter that rolled, an image that is
late. Each is a few parameters beside θ; where one wins, the rig solved beside it is the answer, and where it ties with
the rig alone the posterior has both. With several frames, a region that all of them have in common, as behind glass:
what moves in one of them is outvoted by the others.

Of regions all rectangles are tried, and what grows of the best. Evidence is of the outline alone, everything else
integrated, so parameters and outline need not take turns. Half of the probability is for rectangles, all alike: images
are cut along their rows and columns, and what moves is often as wide as high. The other half has a price for each edge,
what a closed walk on a lattice takes to be told.

With windows of motion, a late shutter: the right camera sees each pair from where the rig is a little later. The θ of a
pair is then θ + τ e, e being what the rig's own motion in a second makes of the extrinsics: rows and windows tell τ as
they tell θ. Where all pairs move alike, only the sum is told, and the posterior says that, too.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce
from itertools import pairwise
from operator import add

import numpy as np
from jaxtyping import Bool, Float

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
from stereorecal.estimation._groups import PLACES, Groups
from stereorecal.estimation._linear_groups import DEVIATIONS, USUAL, LinearGroups, linear_groups
from stereorecal.estimation._motion import Window, Windows, root_and_mean, together, window
from stereorecal.estimation._motion_residuals import Motion
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.geometry import StereoRig, euler_from_rotation, rotation_from_vector, vector_from_rotation
from stereorecal.objectives import RigChart

_EDGE = 1.0  # nats: closed walks of n steps on a square lattice are about 2.64ⁿ many
_FEWEST = 4  # places inside, and outside: fewer are outliers
_RARER = 4  # power of the share that stood still: what moves covers a sixth of an image on average, hardly ever most
_STEPS = 60  # of single places that change sides
_ALIKE = 0.1  # of the places: outlines that differ by less are one
_KEPT = 2  # outlines: a region, and its rival
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
_N = PLACES[0] * PLACES[1]
_DRIFTING = len(DRIFTING)
_LATE_SHUTTER = 0.005  # probability: as of an image that is late among single pairs
_DELAY = 0.3  # of the time between two pairs: standard deviation
_MOTION_STEP = 0.01  # of a motion, for derivatives
_DELAY_ROUNDS, _DELAY_SETTLED = 6, 0.01  # standard deviations of the delay
_FEWEST_MOVING = 2  # windows that move: one says nothing that the rig does not


@dataclass(frozen=True, eq=False)
class Offsets:
    """The log likelihood of row offsets o of all places of a frame: -½ (oᵀ a o - 2 bᵀ o).

    Attributes:
        a: (p, p).
        b: (p,).
        size: standard deviation of the offset of a region, pixels.
    """

    a: Float[np.ndarray, "p p"]
    b: Float[np.ndarray, "p"]
    size: float

    def gain(self, pull: Float[np.ndarray, "s"], stiff: Float[np.ndarray, "s"]) -> Float[np.ndarray, "s"]:
        """Log evidence of an offset of the places l over that of none, for bᵀl and lᵀ a l."""
        return 0.5 * pull**2 / (stiff + 1.0 / self.size**2) - 0.5 * np.log1p(self.size**2 * np.maximum(stiff, 0.0))


def outlines(several: Iterable[Offsets], present: Bool[np.ndarray, "p"]) -> list[tuple[Bool[np.ndarray, "p"], float]]:
    """The most probable outlines that differ, what moved on the one side or on the other, and the logarithm of the
    prior probability of each: rows alone cannot tell which side of an outline stood still; by likelihoods of offsets
    under priors of θ, of the places that have rows."""
    found = sorted((one for offsets in several for one in _searched(offsets, present)), key=lambda one: -one[0])
    chosen = []
    for _, log_prior, label in found:
        difference = [(label != one)[present].mean() for one, _ in chosen]
        if all(_ALIKE < share < 1.0 - _ALIKE for share in difference):
            chosen.append((label, log_prior))
    return [
        (side, log_prior + _RARER * float(np.log1p(-side.sum() / present.sum())))
        for label, log_prior in chosen[:_KEPT]
        for side in (label, present & ~label)
    ]


def _searched(offsets: Offsets, present: Bool[np.ndarray, "p"]) -> Iterator[tuple[float, float, Bool[np.ndarray, "p"]]]:
    """Log evidence, log prior and outline: the best rectangle, the best one that the rest moved around, and what grows
    of both."""
    whole = present.astype(float)
    of_whole = offsets.a @ whole
    pull, stiff = _sums(offsets.b), _squares(offsets.a)
    log_prior = -float(np.log(2.0 * 2.0 * len(pull)))
    rest_pull, rest_stiff = offsets.b @ whole - pull, whole @ of_whole - 2.0 * _sums(of_whole) + stiff
    number = _sums(whole)
    fits = (number >= _FEWEST) & (number <= whole.sum() - _FEWEST)
    if not fits.any():
        return
    for gains, around in ((offsets.gain(pull, stiff), False), (offsets.gain(rest_pull, rest_stiff), True)):
        index = int(np.where(fits, gains, -np.inf).argmax())
        label = present & (_rectangle(index) != around)
        yield float(gains[index]) + log_prior, log_prior, label
        yield _grown(offsets, label, present)


def _grown(
    offsets: Offsets, label: Bool[np.ndarray, "p"], present: Bool[np.ndarray, "p"]
) -> tuple[float, float, Bool[np.ndarray, "p"]]:
    """Single places change sides, the one that gains most first, while that helps."""
    side, adjacency = label.astype(float), _neighbours() * present * present[:, None]
    degree, own = adjacency.sum(axis=1), np.diag(offsets.a)
    al, neighbours_inside = offsets.a @ side, adjacency @ side
    pull, stiff, edges = float(offsets.b @ side), float(side @ al), float(side @ (degree - neighbours_inside))
    log_evidence = -np.inf
    for _ in range(_STEPS):
        sign = 1.0 - 2.0 * side
        more = sign * (degree - 2.0 * neighbours_inside)
        gains = offsets.gain(pull + sign * offsets.b, stiff + 2.0 * sign * al + own) - _EDGE * (edges + more)
        number = side.sum() + sign
        gains[~present | (number < _FEWEST) | (number > present.sum() - _FEWEST)] = -np.inf
        p = int(gains.argmax())
        if not gains[p] > log_evidence:
            break
        log_evidence = float(gains[p])
        pull, stiff, edges = pull + sign[p] * offsets.b[p], stiff + 2.0 * sign[p] * al[p] + own[p], edges + more[p]
        al, neighbours_inside = al + sign[p] * offsets.a[:, p], neighbours_inside + sign[p] * adjacency[:, p]
        side[p] += sign[p]
    log_prior = -_EDGE * float(edges) - float(np.log(2.0))
    return log_evidence - float(np.log(2.0)), log_prior, side > 0.5


# All rectangles: of each span of rows, all spans of columns.


@cache
def _spans(n: int) -> Float[np.ndarray, "m n"]:
    """All intervals of n numbers, 1 inside."""
    ends = [(i, j) for i in range(n) for j in range(i + 1, n + 1)]
    return np.array([(np.arange(n) >= i) & (np.arange(n) < j) for i, j in ends]).astype(float)


def _sums(values: Float[np.ndarray, "p"]) -> Float[np.ndarray, "s"]:
    """Of values inside of each rectangle."""
    across, down = map(_spans, PLACES)
    return (down @ values.reshape(len(down[0]), -1) @ across.T).ravel()


def _squares(a: Float[np.ndarray, "p p"]) -> Float[np.ndarray, "s"]:
    """lᵀ a l for each rectangle l."""
    (columns, rows), (across, down) = PLACES, map(_spans, PLACES)
    of_columns = a.reshape(rows, columns, rows, columns) @ across.T  # (rows, columns, rows, spans of columns)
    of_columns = np.einsum("yxzc,cx->cyz", of_columns, across)
    return np.einsum("cyd,dy->dc", of_columns @ down.T, down).ravel()


def _rectangle(index: int) -> Bool[np.ndarray, "p"]:
    """Which places are inside."""
    across, down = map(_spans, PLACES)
    of_rows, of_columns = divmod(index, len(across))
    return np.outer(down[of_rows], across[of_columns]).ravel() > 0.0


@cache
def _neighbours() -> Float[np.ndarray, "p p"]:
    """1 where two places share an edge."""
    row, column = np.divmod(np.arange(_N), PLACES[0])
    return (np.abs(row[:, None] - row) + np.abs(column[:, None] - column) == 1).astype(float)


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
    at, common = DEVIATIONS.index(best_beside.misfit[0]), best_beside.misfit[1]
    beside = rows.with_columns(confounder.columns(rows))

    def under(deviations: Sequence[float], which: Sequence[int]) -> list[Explanation]:
        misfits = [(deviation, common) for deviation in deviations]
        return explanations(beside, prior, which, misfits, *confounder.prior)

    found = under([DEVIATIONS[at]], range(len(prior.roots)))
    least = _log_evidence(best_of(found)[0]) - NEGLIGIBLE
    some = [one.prior for one in found if _log_evidence(one) > least]
    neighbouring = {max(at - 1, 0), min(at + 1, len(DEVIATIONS) - 1)} - {at}
    found += under([DEVIATIONS[index] for index in sorted(neighbouring)], some)
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
    n, places = rows.jacobian.shape[1], np.eye(_N)[rows.groups.place]
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


@dataclass(frozen=True)
class Delay:
    """Of the right shutter.

    Attributes:
        probability: that there is one.
        seconds: how late it is, then; of the time from one pair to the next, where times are not known.
    """

    probability: float
    seconds: float

    @property
    def likely(self) -> bool:
        """Whether there is one, rather than none."""
        return self.probability > 0.5


def delay_of(late: Hypothesis, alone: Sequence[Explanation]) -> Delay:
    """What a hypothesis whose nuisance parameter is the delay in seconds says of it, beside explanations without."""
    evidence, without = (np.concatenate([e.found.log_evidence for e in some]) for some in (late.several, alone))
    both = np.logaddexp.reduce(np.concatenate([evidence, without]))
    weights = np.exp(evidence - np.logaddexp.reduce(evidence))
    values = np.concatenate([one.found.nuisance[:, 0] for one in late.several])
    return Delay(float(np.exp(np.logaddexp.reduce(evidence) - both)), float(weights @ values))


def hypothesis_with_delay(
    rows: LinearGroups, chart: RigChart, prior: CalibrationPrior, alone: Sequence[Explanation]
) -> tuple[Hypothesis, LinearGroups] | None:
    """θ beside a delay in seconds, and the rows near the best of it, with that delay; None where it has no say.

    Args:
        rows: near the rig that was fitted alone, with windows.
        alone: the rig alone, for some misfits and all covariances of the calibration's prior.
    """
    windows, end = rows.measured.windows, best_of(alone)[0]
    if not windows.frames:
        return None
    size = _DELAY * float(np.median(windows.seconds))
    least = float(end.found.log_evidence.max()) - NEGLIGIBLE
    theta, delay = end.found.means[end.found.log_evidence.argmax()], 0.0
    misfits = list(dict.fromkeys(one.misfit for one in alone))
    ways, late, found = np.zeros((len(windows.tracks), chart.dim)), rows, list(alone)
    nuisance, log_prior = np.full((1, 1), size), float(np.log(_LATE_SHUTTER))
    for round_ in range(_DELAY_ROUNDS):
        rig = chart.rig_at(theta)
        windows_at_theta = [
            window(one, chart, theta + delay * way, travelled)
            for one, way, travelled in zip(windows.tracks, ways, windows.all_ways, strict=True)
        ]
        if sum(one.motion is not None for one in windows_at_theta) < _FEWEST_MOVING:
            return None
        ways = np.stack(
            [
                np.zeros(chart.dim) if one.motion is None else of_motion(chart, rig, one.motion) / seconds
                for one, seconds in zip(windows_at_theta, windows.seconds, strict=True)
            ]
        )
        likelihoods = _delay_evidence(rows, chart, theta, windows_at_theta, ways, prior, size)
        by_frame = _of_frames(windows, windows_at_theta, ways, rows.groups)
        late = replace(_rows_and_delay(rows, chart, theta, delay, by_frame), likelihoods=likelihoods)
        if round_:
            late = replace(late, deviation=late.robust(sum(end.misfit), np.append(theta, delay)))
        found = explanations(late, prior, range(len(prior.roots)), misfits, nuisance, log_prior)
        end, kind = best_of(found)
        if end.found.log_evidence[kind] < least:
            return None
        last, theta, delay = delay, end.found.means[kind], float(end.found.nuisance[kind, 0])
        # The rig alone may have been far away, and much was misfit.
        at, commons = DEVIATIONS.index(end.misfit[0]), dict.fromkeys(common for _, common in misfits)
        misfits = [(deviation, common) for deviation in DEVIATIONS[max(at - 2, 0) : at + 2] for common in commons]
        if round_ and abs(delay - last) < _DELAY_SETTLED * size:
            break
    moved = late.at_zero + delay * late.jacobian[:, -1]
    with_delay = replace(rows, jacobian=late.jacobian[:, :-1], at_zero=moved, deviation=late.deviation)
    return Hypothesis(late, found, end.misfit, nuisance, log_prior), with_delay


def _rows_and_delay(
    rows: LinearGroups, chart: RigChart, theta: Float[np.ndarray, "n"], delay: float, ways: Float[np.ndarray, "g n"]
) -> LinearGroups:
    """Linear near a θ and a delay, with a column for that."""
    jacobian, at_zero = np.empty_like(rows.jacobian), np.empty_like(rows.at_zero)
    for groups in rows.frames:
        theta_of_frame = theta + delay * ways[groups[0]]
        linear = rows.groups.of(groups).rows(chart, theta_of_frame)
        jacobian[groups] = linear.jacobian[:, 0].T
        at_zero[groups] = linear.differences[0] - jacobian[groups] @ theta_of_frame
    column = np.einsum("gn,gn->g", jacobian, ways)
    return replace(rows, jacobian=np.column_stack([jacobian, column]), at_zero=at_zero)


def _delay_evidence(
    rows: LinearGroups,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    windows_at_theta: Sequence[Window],
    ways: Float[np.ndarray, "w n"],
    prior: CalibrationPrior,
    size: float,
) -> list[tuple[float, Normal]]:
    """What windows and ranges tell of θ and the delay."""
    root, mean = root_and_mean(prior)
    wider = np.zeros((len(mean) + 1,) * 2)
    wider[:-1, :-1], wider[-1, -1] = root, size
    # Of θ and of how often the way of a window is added to it.
    to = [(one, np.column_stack([np.eye(len(way)), way])) for one, way in zip(windows_at_theta, ways, strict=True)]
    several = [one.normal.of_parameters(both) for one, both in to]
    by_ways = [(one.with_distance - one.normal).of_parameters(both) for one, both in to]
    alone = together(several, wider, np.append(mean, 0.0))
    of_windows = rows.measured.windows.explained(alone, reduce(add, by_ways), chart)
    return [
        (log + other, of_ranges.with_nuisance(1) + normal)
        for log, of_ranges in rows.measured.ranges.likelihoods(chart, theta)
        for other, normal in of_windows
    ]


def _of_frames(
    windows: Windows, windows_at_theta: Sequence[Window], ways: Float[np.ndarray, "w n"], groups: Groups
) -> Float[np.ndarray, "g n"]:
    """Of the frame of each group: the mean of its windows; of one that is in none, that of the nearest."""
    known = [
        (groups.first[frame], way)
        for pair, one, way in zip(windows.frames, windows_at_theta, ways, strict=True)
        for frame in pair
        if one.motion is not None
    ]
    numbers, of_each = np.array([frame for frame, _ in known]), np.stack([way for _, way in known])
    frame_distance = np.abs(groups.frame[:, None] - numbers)
    nearest = frame_distance == frame_distance.min(axis=1, keepdims=True)
    return (nearest / nearest.sum(axis=1, keepdims=True)) @ of_each


def of_motion(chart: RigChart, rig: StereoRig, motion: Motion) -> Float[np.ndarray, "n"]:
    """How θ of a rig seems to change, to first order, if the right camera sees what the rig comes to see by a
    motion."""
    turn = vector_from_rotation(motion.rotation)
    rotation = rig.rotation @ np.asarray(rotation_from_vector(_MOTION_STEP * turn), float)
    translation = np.asarray(rig.translation) + _MOTION_STEP * rig.rotation @ motion.translation
    moved = np.concatenate([euler_from_rotation(rotation), translation])
    return (chart.coordinates(moved) - chart.coordinates(np.asarray(rig.extrinsics))) / _MOTION_STEP
