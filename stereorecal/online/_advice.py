"""What is not determined yet, and the one thing to show next: a what-if on the filter's covariance.

For each thing that could be shown the filter is updated as if it had been, and that is advised which narrows most the
interval that is widest beside what matters. What a look would say is not needed: the covariance does not depend on it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import Consequences, Normal, one_blas_thread, window
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._config import Kind
from stereorecal.online._filter import SIZE, FilterEstimate, Measurement
from stereorecal.online._matches import as_taken, band_of, part_of
from stereorecal.online._moving import AHEAD, motion_measurement
from stereorecal.online._reading import DEPTH_MATTERS, FAR, around, reading
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
    estimate = state.estimate.moved(state.posterior.mean, state.posterior.covariance)
    chart, near = _near(state)
    errors, matters = _errors(near), {"epipolar": state.config.tolerances.good_rows_px, "depth": DEPTH_MATTERS}
    every = [Undetermined(*key, _half_width(estimate, by), matters[key[0]]) for key, by in errors.items()]
    wide = sorted((one for one in every if one.half_width > one.matters), key=lambda one: one.matters / one.half_width)
    candidates = [*_looks(state, chart, near), *_motions(state, chart, near)] if wide else []
    show = next((best for one in wide if (best := _best(estimate, one, errors, candidates))), None)
    deviations = NORMAL_95 * np.sqrt(np.diag(state.of_offset))
    alone = [deviations * np.linalg.norm(by[:, :SIZE], axis=0) / matters[error] for (error, _), by in errors.items()]
    axes = tuple(name for name, most in zip(EXTRINSICS, np.max(alone, axis=0), strict=True) if most > 1.0)
    return Advice(tuple(wide), axes, show, blind, stands=not (wide or blind) and _settled(state))


def _settled(state: State) -> bool:
    """Whether nothing is under way that would change the verdict, such as a repair that is due."""
    if not state.seen or state.job is not None or state.outlier is not None:
        return False
    if state.unmatched_in_a_row or state.reported is Kind.BAD_FRAME:
        return False
    found = reading(state)
    if found.condition is Condition.REPAIR:
        return found.shifted or not state.config.repair
    return found.condition is Condition.HEALTHY and state.reported is Kind.HEALTHY  # seen through since a switch


def _near(state: State) -> tuple[RigChart, Consequences]:
    """Changes of the calibration in use, and what they do at the distances that matter: those of the decision and of
    depth, but for what is nearer than the matcher finds anything."""
    matcher, every = state.matcher, sorted({*state.config.tolerances.distances, float(FAR)})
    if matcher is not None and matcher.num_disparities is not None:
        most = matcher.min_disparity + matcher.num_disparities
        every = [away for away in every if state.view.focal <= most * away or away == FAR]
    return around(state.initial, tuple(state.using.tolist()), state.view, tuple(every))


def _errors(near: Consequences) -> dict[tuple[str, float], Float[np.ndarray, "q n"]]:
    """The errors that matter, of rows at each distance, and of depth at one: derivatives by θ of q parts, whose squares
    sum up to the error's."""
    every = np.sqrt(near.weights[0])[:, None] * near.rows
    rows = {("epipolar", away): every[there] for away, there in near.at_distances}
    depth = near.mean_nearness[near.distances.index(FAR)]
    return {**rows, ("depth", float(FAR)): 100.0 * depth[None]}


def _half_width(estimate: FilterEstimate, by: Float[np.ndarray, "q n"]) -> float:
    """Half the width of the 95 % interval of an error."""
    return NORMAL_95 * float(np.sqrt(max(np.sum(by @ estimate.of_theta * by), 0.0)))


class _Candidate(NamedTuple):
    """Something that could be shown, as `Showing` has it, and what it would measure."""

    part: tuple[int, int] | None
    distance: float | None
    motion: bool
    measures: Measurement


def _best(
    estimate: FilterEstimate, wide: Undetermined, errors: dict, candidates: Sequence[_Candidate]
) -> Showing | None:
    """What narrows an error most; None if nothing does by much."""
    by = errors[wide.error, wide.distance]
    left = [_half_width(estimate.updated(one.measures), by) for one in candidates]
    best = int(np.argmin(left))
    return Showing(wide, left[best], *candidates[best][:3]) if left[best] <= _WORTH * wide.half_width else None


def _looks(state: State, chart: RigChart, near: Consequences) -> list[_Candidate]:
    """Something in each part of the view, at each distance, while the rig is held still."""
    found = []
    for away, there in near.at_distances:
        parts, rows = part_of(chart.rig, near.points[there]), near.rows[there]
        for part in np.unique(parts).tolist():
            a = rows[parts == part].T @ rows[parts == part] / _NOISE**2
            told = Measurement(Normal(a, a @ state.estimate.theta, 0.0), np.zeros(3))
            found.append(_Candidate(as_taken(part, chart.rig), away, False, told))
    return found


def _motions(state: State, chart: RigChart, near: Consequences) -> list[_Candidate]:
    """The rig moving on past what it has seen; or, if that would tell nothing, past something at each distance."""
    if not state.config.motion:
        return []
    return _past(chart, near, tuple(map(tuple, (state.coverage > 0).tolist())))


@lru_cache(maxsize=2)  # most looks cover nothing new
@one_blas_thread()
def _past(chart: RigChart, near: Consequences, covered: tuple[tuple[bool, ...], ...]) -> list[_Candidate]:
    """`_motions`; `covered` says whether something was seen in each part of the view at each distance."""
    each = [(away, near.points[there]) for away, there in near.at_distances]
    seen = [points[np.array(covered)[part_of(chart.rig, points), band_of(away)]] for away, points in each]
    if here := _motion_past(None, chart, np.concatenate(seen)):
        return here
    return [one for away, points in each for one in _motion_past(away, chart, points)]


def _motion_past(distance: float | None, chart: RigChart, points: Float[np.ndarray, "p 3"]) -> list[_Candidate]:
    """The rig moving straight ahead past points [m] by as much as it takes; none if their tracks would tell nothing."""
    rig = chart.rig
    left = np.stack([points, points - [0.0, 0.0, AHEAD * float(rig.baseline)]])
    right = left @ rig.rotation.T + rig.translation
    seen = [np.asarray(camera.project(of / of[..., 2:])) for camera, of in ((rig.left, left), (rig.right, right))]
    inside = [((pixels >= 0.0) & (pixels <= np.array(rig.left.size) - 1.0)).all(axis=(0, 2)) for pixels in seen]
    tracked = window(Tracks(seen[0], seen[1]).of(inside[0] & inside[1]), chart, np.zeros(chart.dim))
    if not tracked.informative:
        return []
    told = motion_measurement(tracked.normal, np.zeros(3))
    return [_Candidate(None, distance, True, told.weighed(tracked.scale**2))]  # tracks fit better than any with errors
