"""One look at one pair through a calibration, at half scale: what its rows say of the rig."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.decision import ENOUGH
from stereorecal.estimation import Groups, LinearGroups, Motion, Normal, marginal, of_motion, root, rows_near
from stereorecal.geometry import rotation_from_vector, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import RigChart, differences_at
from stereorecal.online._filter import LEFT, SIZE, FilterEstimate, Measurement
from stereorecal.online._state import MISFITS, Offset, State
from stereorecal.recalibration import RowResiduals, is_sparse, watching_scale
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, host, image_quality, pyramid

_FALSE = 0.4  # pixels left: chance matches lie evenly within a row of where they were sought, median 0.5
# Standard deviations: what moves by itself has hardly a say beyond, as a region or alone.
_ROUNDS, _REDESCENDS = 2, 1.5
_LOOKS, _MOST = 20.0, 3.0  # by which the size of a misfit is known, and how much one of them says of it, at most


@dataclass(frozen=True, eq=False)
class Look:
    """What a pair shows through a calibration.

    Attributes:
        covered: share of the image in which correspondences were found.
        measured: what they say of the rig; None if too little matches, or what matches does so by chance.
        found: the correspondences.
        shown: their mean row differences; None where `measured` is.
        chart: around the rig that was given first, whose cameras they are of.
        misfits: (k,) logarithms of the evidence of each of MISFITS, by the last looks and this one.
    """

    covered: float
    measured: Measurement | None
    found: Correspondences
    chart: RigChart
    misfits: Float[np.ndarray, "k"]
    shown: Groups | None = None

    @property
    def match_radius(self) -> float:
        """Pixels: what is farther from all correspondences is of something else."""
        return host.match_radius(self.found, self.chart.rig)

    @property
    def matches(self) -> host.Matches:
        """Pixels that correspond."""
        return host.Matches.of(self.found, self.chart.rig)

    def row_error(self, offset: Offset) -> float:
        """|Row difference| under the calibration at an offset, pixels at full size: the mean over the tiles of a
        tile's median."""
        return _row_error(self.found, self.chart, _theta(self.chart, offset))


def look(
    state: State,
    offset: Offset,
    pair: Pair,
    matcher: AbstractMatcher,
    turned: Float[np.ndarray, "3"] | None,
) -> Look:
    """Match a pair under the calibration at an offset, and weigh its rows against what is known.

    Args:
        matcher: with its disparity range at full size.
        turned: rotation vector of the rig since the pair before [rad]; None if it is not known.
    """
    rig, chart = state.rig_at(offset), state.chart
    data = pyramid(rig, [pair], state.view).at(watching_scale(rig.left.size))
    found = host.correspondences(data, with_unit_baseline(rig.extrinsics), matcher)
    nothing = Look(found.covered, None, found, chart, state.misfits)
    tiles = np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0])
    if found.found < ENOUGH.matches or found.covered < ENOUGH.covered or len(tiles) < ENOUGH.places:
        return nothing
    # Linear near the drift alone: rays of other lenses would have to be found anew, and what is left of them is small.
    rows = rows_near(found, chart, _theta(chart, state.estimate.offset))
    rows, misfits, misfit, theta = _solved(rows, state.estimate, state.misfits)
    drift = theta[:SIZE] - state.estimate.mean[LEFT][:SIZE]
    by_chance = _row_error(found, chart, _theta(chart, drift)) * float(found.scale) > _FALSE
    if by_chance and is_sparse(found.covered, image_quality(pair).texture):
        return nothing
    normal = rows.normal(misfit)
    way = np.zeros(chart.dim) if turned is None else way_of(state, turned, np.zeros(3))
    return Look(found.covered, Measurement.of(state.frame, normal, way), found, chart, misfits, rows.groups)


def way_of(state: State, turned: Float[np.ndarray, "3"], metres: Float[np.ndarray, "3"]) -> Float[np.ndarray, "n"]:
    """How θ seems to change if the right shutter is late by one frame, in which the rig turns and travels so."""
    motion = Motion(np.asarray(rotation_from_vector(turned), float), metres)
    return of_motion(state.chart, state.rig, motion)


def _solved(
    rows: LinearGroups, known: FilterEstimate, before: Float[np.ndarray, "k"]
) -> tuple[LinearGroups, Float[np.ndarray, "k"], float, Float[np.ndarray, "n"]]:
    """The rows, of which those that err far have a bounded say; the evidence of each misfit, the one that it prefers,
    and θ by these rows if the rig may have been knocked before them."""
    at, within = known.theta, root(known.after_knock().of_theta)

    def theta_of(normal: Normal) -> Float[np.ndarray, "n"]:
        precision = np.eye(len(at)) + within.T @ normal.a @ within
        return at + within @ np.linalg.solve(precision, within.T @ normal.b)

    misfit = MISFITS[int(before.argmax())]
    for _ in range(_ROUNDS):
        theta = theta_of(rows.normal(misfit).around(at))
        far = rows.residual(theta) / np.hypot(rows.groups.deviation, misfit)
        rows = replace(rows, deviation=rows.groups.deviation * (1.0 + (far / _REDESCENDS) ** 2))
    normals = [rows.normal(deviation).around(at) for deviation in MISFITS]
    evidence = -0.5 * np.array([marginal(normal, within).c for normal in normals])
    # What one look shows is of its own scene: no more than so much, and soon forgotten.
    misfits = (1.0 - 1.0 / _LOOKS) * before + np.maximum(evidence - evidence.max(), -_MOST)
    misfits -= misfits.max()
    best = int(misfits.argmax())
    return rows, misfits, MISFITS[best], theta_of(normals[best])


def _theta(chart: RigChart, offset: Offset) -> Float[np.ndarray, "n"]:
    return np.concatenate([offset, np.zeros(chart.dim - len(offset))])


def _row_error(found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"]) -> float:
    valid = np.asarray(found.weight) > 0
    rows = differences_at(found, chart, theta)[valid] / float(found.scale)
    residuals = RowResiduals(residual=rows, start_residual=rows, tile=np.asarray(found.tile)[valid])
    return float(np.mean(residuals.medians(rows)))
