"""All that is known of a rig on the vehicle."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8

from stereorecal.estimation import DEFAULT, Mixture, extrinsics_like, rig_parameters
from stereorecal.geometry import StereoRig, View, as_view
from stereorecal.matching import AbstractMatcher, as_matcher
from stereorecal.objectives import RigChart
from stereorecal.online._calibration_kinds import before_looks, posterior
from stereorecal.online._config import Config, Event, Kind
from stereorecal.online._filter import (
    PACES,
    SIZE,
    USUAL,
    FilterEstimate,
    Measurement,
    at_start,
    filters_beside,
    learnt_logs,
)
from stereorecal.online._matches import no_coverage
from stereorecal.recalibration import Progress
from stereorecal.recordings import Pair
from stereorecal.scoring.host import Corners

_REPAIR_PAIRS = 3  # of a repair after a knock
_chart = lru_cache(maxsize=2)(rig_parameters)  # a step asks several times
_extrinsics_like = lru_cache(maxsize=2)(extrinsics_like)

Offset = Float[np.ndarray, "5"]
"""What a calibration differs by from the one that was given first: pitch, yaw, roll in degrees, y, z in percent."""


@dataclass(frozen=True, eq=False)
class State:
    """All that is known of a rig. Never changed: a step makes another one.

    Attributes:
        config: as it was set.
        initial: the calibration that was given.
        view: of all looks, that of the initial calibration.
        using: (5,) offset of the calibration in use.
        estimate: where the true rig stands, and how late a shutter is.
        beside: the same, had the rig turned by any yaw before it was first seen, since what rows showed of that may
            have been taken for lenses; and a filter for each pace at which a rig may drift.
        logs: of the evidence of each pace.
        frame: number of the next pair.
        matcher: with its disparity range; None until one is measured.
        seen: informative looks so far.
        row_error: of the last of them, pixels at full size; NaN before.
        last: the last left image, small; None after a pair that cannot be used.
        corners: that are followed until the rig has moved; None where there are none.
        corners_frame: number of the pair that showed them first.
        tracked_pairs: pairs after which they are looked for again: as many as the rig needs to advance by a fraction of
            a baseline.
        corners_time: time of the pair in which they were found; None if it is not known.
        others: probability that the last such look showed the motion of other things than the rig.
        outlier_motion: what the rig's motion told and does not fit, until it tells more.
        outlier: a look that does not fit, until the next one says what it was.
        outliers_in_a_row: consecutive looks that fit neither the estimate nor each other.
        repair_pairs: the last pairs, one after the other, that hardly match, though they have light and texture, or do
            not fit; up to three: what a repair after a knock rests on.
        unmatched_in_a_row: how many pairs hardly matched, one after the other.
        job: the repair under way, of `repair_pairs`, cut into slices, so that no step takes long.
        ready: the pair from which on the calibration may be switched again.
        previous: offsets of calibrations that were in use before, the last one last.
        reported: the last standing event, so that each is said once.
        coverage: looks so far that showed each part of the view (by rows) at each of the distances where depth is read.
        events: of the step that is being done.
    """

    config: Config
    initial: StereoRig
    view: View
    using: Offset
    estimate: FilterEstimate
    beside: FilterEstimate
    logs: Float[np.ndarray, "paces"] = field(default_factory=lambda: USUAL)
    frame: int = 0
    matcher: AbstractMatcher | None = None
    seen: int = 0
    row_error: float = float("nan")
    last: UInt8[np.ndarray, "h w"] | None = None
    corners: Corners | None = None
    corners_frame: int = 0
    tracked_pairs: int = 2
    corners_time: float | None = None
    others: float = 0.05
    outlier_motion: Measurement | None = None
    outlier: Measurement | None = None
    outliers_in_a_row: int = 0
    repair_pairs: tuple[Pair, ...] = ()
    unmatched_in_a_row: int = 0
    job: Progress | None = None
    ready: int = 0
    previous: tuple[Offset, ...] = ()
    reported: Kind | None = None
    coverage: Int[np.ndarray, "parts distances"] = field(default_factory=no_coverage)
    events: tuple[Event, ...] = ()

    def saying(self, kind: Kind, why: str = "", facts: Mapping[str, Any] | None = None) -> "State":
        """The state with one more event."""
        return replace(self, events=(*self.events, Event(self.frame, kind, why, facts or {})))

    def told(self) -> tuple["State", tuple[Event, ...]]:
        """The state without its events, and these."""
        return replace(self, events=()), self.events

    def alone(self) -> "State":
        """The state without what only a pair that comes at once is compared with: the last image, the corners that are
        followed and the image that shows them, what they told and another look should say again."""
        return self.replace(last=None, corners=None, corners_time=None, outlier_motion=None)

    @property
    def chart(self) -> RigChart:
        """θ, changes of all parameters of the initial calibration, to rigs; offsets are the first of them."""
        return _chart(self.initial)

    @property
    def theta(self) -> Float[np.ndarray, "n"]:
        """The calibration in use, as θ."""
        return theta_of(self.using, self.chart)

    @property
    def posterior(self) -> Mixture:
        """The posterior of θ, under all kinds of calibration."""
        return posterior(self.initial, self.config.prior, self.estimate)

    @property
    def as_extrinsics(self) -> Float[np.ndarray, "5 n"]:
        """The matrix from θ to the offset that does most like it to rows and depth."""
        return _extrinsics_like(self.chart, self.view)

    @property
    def offset(self) -> Offset:
        """The offset of the true rig."""
        return self.as_extrinsics @ self.posterior.mean

    @property
    def of_offset(self) -> Float[np.ndarray, "5 5"]:
        """The covariance of the offset."""
        return self.as_extrinsics @ self.posterior.covariance @ self.as_extrinsics.T

    @property
    def rig(self) -> StereoRig:
        """The calibration in use."""
        return self.rig_at(self.using)

    def rig_at(self, offset: Offset) -> StereoRig:
        """The rig with an offset."""
        return rig_with(self.initial, tuple(offset.tolist()))

    def offset_of(self, rig: StereoRig) -> Offset:
        """The inverse."""
        return self.chart.coordinates(np.asarray(rig.extrinsics))[: len(self.using)]

    def with_repair_pair(self, pair: Pair) -> "State":
        """The state with one more pair that a repair may rest on."""
        return replace(self, repair_pairs=(*self.repair_pairs, pair)[-_REPAIR_PAIRS:])

    @property
    def pace(self) -> Float[np.ndarray, "2"]:
        """How fast it drifts, as learnt: factors on `Config.wander` and `Config.heating`."""
        return np.sqrt(np.exp(self.logs - np.logaddexp.reduce(self.logs)) @ PACES**2)

    def later(self) -> "State":
        """A pair later."""
        estimate = self.estimate.later(self.config, self.pace)
        return replace(self, estimate=estimate, beside=self.beside.later(self.config, np.vstack([self.pace, PACES])))

    def measured(self, measurement: Measurement, together: float = 1.0) -> "State":
        """The state with a measurement, of which so many err together."""
        fewer = np.r_[together, np.full(len(PACES), together**0.5)]
        logs = learnt_logs(self.logs, self.beside[1:], measurement.weighed(together**-0.5))
        estimate, beside = self.estimate.updated(measurement, together), self.beside.updated(measurement, fewer)
        return replace(self, estimate=estimate, beside=beside, logs=logs)

    def standing_at(self, estimate: FilterEstimate) -> "State":
        """The state with another estimate."""
        return replace(self, estimate=estimate, beside=filters_beside(estimate, estimate))

    def configured(self, config: Config) -> "State":
        """The state with other settings. A repair under way ends where they say whether there are any, and what was
        known of a delay where they say otherwise of the shutters; with another matcher the range is measured anew, with
        another view or prior the estimate is as wide as at the start."""
        before, state = self.config, replace(self, config=config)
        if config.repair != before.repair:
            state = replace(state, job=None)
        if config.synchronous != before.synchronous:
            state = state.standing_at(self.estimate.of_shutters(config.synchronous))
            state = replace(state, outlier=None, reported=None)
        if config.matcher is not before.matcher and as_matcher(config.matcher) != as_matcher(before.matcher):
            state = replace(state, matcher=known_matcher(config), job=None, unmatched_in_a_row=0, outlier=None)
        if (config.view, config.prior or DEFAULT) != (before.view, before.prior or DEFAULT):
            start = at_start(before_looks(self.initial, config.prior), config)
            start.covariance[:SIZE, :SIZE] += state.of_offset
            wide = start.moved(theta_of(state.offset, self.chart), start.of_theta)
            state = replace(state.standing_at(wide), view=as_view(config.view, self.initial), outlier=None)
        return state

    def replace(self, **changes) -> "State":
        """The same but for some of it."""
        return replace(self, **changes)


def known_matcher(config: Config) -> AbstractMatcher | None:
    """The matcher that is set, if its range is; else that is measured."""
    matcher = as_matcher(config.matcher)
    return None if matcher.num_disparities is None else matcher


def theta_of(offset: Offset, chart: RigChart) -> Float[np.ndarray, "n"]:
    """θ of an offset, lenses as they were given."""
    return np.pad(offset, (0, chart.dim - len(offset)))


@lru_cache(maxsize=4)
def rig_with(initial: StereoRig, offset: tuple[float, ...]) -> StereoRig:
    """The rig with an offset from the one that was given first."""
    chart = _chart(initial)
    return chart.rig_at(theta_of(np.array(offset), chart)) if any(offset) else initial
