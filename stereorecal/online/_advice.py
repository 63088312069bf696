"""What is not determined yet, and the one thing to show next: a what-if on the filter's covariance.

For each thing that could be shown the filter is updated as if it had been, and that is advised which narrows most the
interval that is widest beside what matters. What a look would say is not needed: the covariance does not depend on it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation import Normal, consequences, one_blas_thread, window
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._config import Kind
from stereorecal.online._filter import SIZE, FilterEstimate, Measurement
from stereorecal.online._moving import AHEAD, motion_measurement
from stereorecal.online._pair_estimate import as_taken, band_of, part_of
from stereorecal.online._reading import DEPTH_MATTERS, FAR, Reading, chart_around, reading
from stereorecal.online._state import State
from stereorecal.recalibration import NORMAL_95, Condition
from stereorecal.scoring import Tracks

_NOISE = 0.3  # pixels: of the mean row difference around a point; looks at six real rigs had 0.1 to 0.4
_WORTH = 0.98  # of a half width: what would leave more of it is not worth showing


@dataclass(frozen=True)
class Undetermined:
    """An error of the calibration in use that is known less well than matters.

    Attributes:
        error: "epipolar" or "depth".
        distance: of what it is an error, in baselines.
        half_width: of its 95 % interval: pixels, root mean square over the view, or percent of the distance.
        matters: the half width that would do.
    """

    error: str
    distance: float
    half_width: float
    matters: float


@dataclass(frozen=True)
class Showing:
    """What would narrow an interval most.

    Attributes:
        narrows: the interval.
        half_width: that would be left of it.
        part: row and column of the ninth of the left image, as it was taken, in which something should be seen; None:
            in all of it.
        distance: of that, in baselines; None: as far as what has been seen.
        motion: whether the rig should move on meanwhile.
    """

    narrows: Undetermined
    half_width: float
    part: tuple[int, int] | None
    distance: float | None
    motion: bool


@dataclass(frozen=True)
class Advice:
    """What is missing until the answer stands.

    Attributes:
        undetermined: errors that are known less well than matters, the worst first.
        axes: names of axes that are known so: half the width of their interval would matter, if no other axis made up
            for it.
        show: what to show next; None where nothing is missing, or nothing that could be shown would tell much more.
        blind: whether the last pair showed too little: light and texture come first.
        stands: whether the verdict stands: nothing is undetermined, and no repair is due.
    """

    undetermined: tuple[Undetermined, ...]
    axes: tuple[str, ...]
    show: Showing | None
    blind: bool
    stands: bool


def advice(state: State) -> Advice:
    """What is missing until the answer on the calibration in use stands, and what to show next."""
    blind = state.reported is Kind.TOO_LITTLE_TEXTURE
    if not state.estimate.is_finite:
        return Advice((), (), None, blind, stands=False)
    estimate = state.estimate.moved(state.posterior.mean, state.posterior.covariance)
    chart, around = _around(state.initial, tuple(state.using.tolist()), state.view, _distances(state))
    errors = _errors(around, state.config.tolerances.good_rows_px)
    wide = sorted((one for one in errors if one.excess(estimate) > 1.0), key=lambda one: -one.excess(estimate))
    candidates = [*_looks(state, around), *_motions(state, chart, around)] if wide else []
    show = next((best for one in wide if (best := _best(estimate, one, candidates))), None)
    deviations = np.sqrt(np.diag(state.of_offset))
    alone = [NORMAL_95 * deviations * np.linalg.norm(one.by[:, :SIZE], axis=0) / one.matters for one in errors]
    axes = tuple(name for name, most in zip(EXTRINSICS, np.max(alone, axis=0), strict=True) if most > 1.0)
    undetermined = tuple(one.told(estimate) for one in wide)
    return Advice(undetermined, axes, show, blind, stands=not (wide or blind) and _settled(state, reading(state)))


def _settled(state: State, found: Reading) -> bool:
    """Whether nothing is under way that would change the verdict, such as a repair that is due."""
    if not state.seen or state.job is not None or state.outlier is not None:
        return False
    if state.unmatched_in_a_row or state.reported is Kind.BAD_FRAME:
        return False
    if found.condition is Condition.REPAIR:
        return found.shifted or not state.config.repair
    return found.condition is Condition.HEALTHY and state.reported is Kind.HEALTHY  # seen through since a switch


def _distances(state: State) -> tuple[float, ...]:
    """The distances that matter [baselines]: those of the decision and of depth, but for what is nearer than the
    matcher finds anything."""
    matcher, every = state.matcher, sorted({*state.config.tolerances.distances, float(FAR)})
    if matcher is None or matcher.num_disparities is None:
        return tuple(every)
    most = matcher.min_disparity + matcher.num_disparities
    return tuple(away for away in every if state.view.focal <= most * away or away == FAR)


@dataclass(frozen=True, eq=False)
class _Around:
    """Points over the view at a distance, and what the numbers of the filter do there.

    Attributes:
        distance: in baselines.
        points: (p, 3) metres.
        part: (p,) the part of the view in which each appears.
        rows: (p, m) row differences, pixels.
        weight: (p,) of the points in a mean over the view.
        depth: (m,) error of depth, percent.
    """

    distance: float
    points: Float[np.ndarray, "p 3"]
    part: Int[np.ndarray, "p"]
    rows: Float[np.ndarray, "p m"]
    weight: Float[np.ndarray, "p"]
    depth: Float[np.ndarray, "m"]


@lru_cache(maxsize=2)  # the same until another calibration is in use
def _around(
    initial: StereoRig, using: tuple[float, ...], view: View, distances: tuple[float, ...]
) -> tuple[RigChart, tuple[_Around, ...]]:
    """Changes of the calibration in use, and what they do at each distance."""
    chart = chart_around(initial, using)
    by_filter = np.eye(chart.dim, chart.dim + 4)
    near = consequences(chart, np.zeros(chart.dim), distances, view)
    each = zip(distances, near.points, near.rows, near.weights, near.mean_nearness, strict=True)
    return chart, tuple(
        _Around(away, points, part_of(chart.rig, points), rows @ by_filter, weights[0], 100.0 * depth @ by_filter)
        for away, points, rows, weights, depth in each
    )


@dataclass(frozen=True, eq=False)
class _Error:
    """An error of the calibration in use, by what the filter knows.

    Attributes:
        error, distance, matters: as `Undetermined` has them.
        by: (q, m) derivatives by the numbers of the filter of q parts, whose squares sum up to the error's.
    """

    error: str
    distance: float
    matters: float
    by: Float[np.ndarray, "q m"]

    def half_width(self, estimate: FilterEstimate) -> float:
        """Half the width of its 95 % interval."""
        variance = float(np.einsum("qi,ij,qj->", self.by, estimate.covariance, self.by))
        return NORMAL_95 * float(np.sqrt(max(variance, 0.0)))

    def excess(self, estimate: FilterEstimate) -> float:
        """The half width, of the one that would do."""
        return self.half_width(estimate) / self.matters

    def told(self, estimate: FilterEstimate) -> Undetermined:
        """The error and how well it is known."""
        return Undetermined(self.error, self.distance, self.half_width(estimate), self.matters)


def _errors(around: Sequence[_Around], good_rows_px: float) -> list[_Error]:
    """The errors that matter: of rows at each distance, and of depth at one."""
    rows = [_Error("epipolar", at.distance, good_rows_px, np.sqrt(at.weight)[:, None] * at.rows) for at in around]
    return rows + [_Error("depth", FAR, DEPTH_MATTERS, at.depth[None]) for at in around if at.distance == FAR]


@dataclass(frozen=True, eq=False)
class _Candidate:
    """Something that could be shown, as `Showing` has it, and what it would measure."""

    part: tuple[int, int] | None
    distance: float | None
    measures: Measurement
    motion: bool = False


def _best(estimate: FilterEstimate, error: _Error, candidates: Sequence[_Candidate]) -> Showing | None:
    """What narrows an error most; None if nothing does by much."""
    left = [error.half_width(estimate.updated(one.measures)) for one in candidates]
    best = int(np.argmin(left))
    if left[best] > _WORTH * error.half_width(estimate):
        return None
    one = candidates[best]
    return Showing(error.told(estimate), left[best], one.part, one.distance, one.motion)


def _looks(state: State, around: Sequence[_Around]) -> list[_Candidate]:
    """Something in each part of the view, at each distance, while the rig is held still."""
    return [
        _Candidate(as_taken(part, state.initial), at.distance, _look(state, at.rows[at.part == part]))
        for at in around
        for part in np.unique(at.part).tolist()
    ]


def _look(state: State, rows: Float[np.ndarray, "p m"]) -> Measurement:
    """What row differences would measure, by their derivatives by the numbers of the filter."""
    by_theta = rows[:, : state.chart.dim]
    a = by_theta.T @ by_theta / _NOISE**2
    return Measurement(Normal(a, a @ state.estimate.theta, 0.0), np.zeros(3))


def _motions(state: State, chart: RigChart, around: tuple[_Around, ...]) -> list[_Candidate]:
    """The rig moving on past what it has seen; or, if that would tell nothing, past something at each distance."""
    if not state.config.motion:
        return []
    covered = tuple(map(tuple, (state.coverage > 0).tolist()))
    return [
        _Candidate(None, distance, motion_measurement(state, of_motion, np.zeros(3)), motion=True)
        for distance, of_motion in _tracked(chart, around, covered)
    ]


@lru_cache(maxsize=2)  # most looks cover nothing new
@one_blas_thread()
def _tracked(
    chart: RigChart, around: tuple[_Around, ...], covered: tuple[tuple[bool, ...], ...]
) -> list[tuple[float | None, Normal]]:
    """Distances as `Showing` has them, and what the motion past them would tell of the rig; `covered` says whether
    something was seen in each part of the view at each distance."""
    seen = [at.points[np.array(covered)[at.part, band_of(at.distance)]] for at in around]
    here = _after_motion(chart, np.concatenate(seen))
    if here is not None:
        return [(None, here)]
    past = ((at.distance, _after_motion(chart, at.points)) for at in around)
    return [(distance, of_motion) for distance, of_motion in past if of_motion is not None]


def _after_motion(chart: RigChart, points: Float[np.ndarray, "p 3"]) -> Normal | None:
    """What tracks of points [m] would tell while the rig moves straight ahead by as much as it takes; None if
    nothing."""
    rig = chart.rig
    left = np.stack([points, points - [0.0, 0.0, AHEAD * float(rig.baseline)]])
    right = left @ rig.rotation.T + rig.translation
    seen = [np.asarray(camera.project(of / of[..., 2:])) for camera, of in ((rig.left, left), (rig.right, right))]
    inside = [((pixels >= 0.0) & (pixels <= np.array(rig.left.size) - 1.0)).all(axis=(0, 2)) for pixels in seen]
    tracked = window(Tracks(seen[0], seen[1]).of(inside[0] & inside[1]), chart, np.zeros(chart.dim))
    if not tracked.informative:
        return None
    a, b, c = tracked.normal.a, tracked.normal.b, tracked.normal.c
    return Normal(tracked.scale**2 * a, tracked.scale**2 * b, c)  # tracks without errors fit better than any are
