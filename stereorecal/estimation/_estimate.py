"""The estimate: what is known of a rig, and the rigs that may be written.

What a part of the images says of a candidate of the rest is told in closed form: the rest's normal equations are those
of its own rows, whose covariance is a block of the whole one; its posterior is that of every hypothesis beside every
prior, as the estimate's is; and rows are linear near the estimate. Nuisance parameters are estimated anew from the
rest, and not applied to the part, which may be the one that moved.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._errors import checked_choice
from stereorecal.estimation._calibration_prior import widest
from stereorecal.estimation._consequences import DISTANCES, Consequences, Readings, consequences
from stereorecal.estimation._explanations import Hypothesis, mixture
from stereorecal.estimation._groups import PLACES, Groups
from stereorecal.estimation._late_shutter import Delay
from stereorecal.estimation._linear_groups import OtherRig
from stereorecal.estimation._losses import (
    USUAL,
    Errors,
    Losses,
    Matters,
    PointwiseLoss,
    errors_near,
    least_loss,
    points_shown,
)
from stereorecal.estimation._matched_ranges import NO_RANGES, MatchedRanges
from stereorecal.estimation._mixture import Mixture, Travels, median_and_interval, merged, remembered
from stereorecal.estimation._motion import NO_WINDOWS, Window, Windows
from stereorecal.estimation._one_thread import one_blas_thread
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.geometry import View
from stereorecal.objectives import RigChart

_NORMALS = 8  # of a posterior: so many hold what its loss depends on
_THIRDS = 3
_DETERMINED = (".f", ".k1")  # by boards and by rows
_PLACES = 4  # at most: so many times as many frames, and each of these is left out with the others of its fourth
_FEWEST = 6  # groups in a part, and in the rest
_LEAST_NEARNESS = 1e-3  # a thousandth of the true nearness: what lies beyond is called infinitely far


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


@dataclass(frozen=True, eq=False)
class Estimate(Travels):
    """What the images of a rig and the prior of its calibration say of it together.

    Attributes:
        chart: from θ, changes of all parameters in the units of people, to rigs; θ = 0 is the given one.
        posterior: of θ.
        misfit: pixels of row difference that stay together in regions and are in no parameter: of each frame, and
            common to all frames.
        groups: how many mean row differences it rests on.
        residual_px: root mean square of those, at the posterior's mean; NaN where there are none.
        prior_variance: (n,) of the calibration's error before any image was seen, mixed like the posterior.
        other_rigs: frames that show another rig than the others, the farthest first.
        matched_ranges: ranges that took part.
        shown: the mean row differences that it rests on; None where there are none.
        points: (m, 3) in the frame of the left camera, that stand for what images show, and their weights (m,); None:
            those that `shown` shows.
        windows: pairs of pairs that told of the rig's motion.
        matters: what counts as an error, for losses and candidates.
        view: in which rows and depth are judged; None: the rig's own.
        delay: of the right shutter, if windows leave one possible.
        hypotheses: of what is behind the rows; none where there are no rows, or nobody asks again.
        samples: number of rigs that are drawn from the posterior.
        slopes: of errors at the distances that matter, and at `points`, near another rig, where these are known.
    """

    chart: RigChart
    posterior: Mixture
    misfit: tuple[float, float]
    groups: int
    residual_px: float
    prior_variance: Float[np.ndarray, "n"]
    other_rigs: tuple[OtherRig, ...] = ()
    matched_ranges: MatchedRanges = NO_RANGES
    shown: Groups | None = None
    points: tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m"]] | None = None
    windows: Windows = NO_WINDOWS
    matters: Matters = USUAL
    view: View | None = None
    delay: Delay | None = None
    hypotheses: tuple[Hypothesis, ...] = ()
    samples: int = 2000
    slopes: Consequences | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all parameters, in the order of θ."""
        return self.chart.names

    @property
    def units(self) -> tuple[str, ...]:
        """The units of all parameters: "deg", "%", "px" or "" for coefficients."""
        return tuple(parameter.unit for parameter in self.chart.parameters)

    @property
    def theta(self) -> Float[np.ndarray, "n"]:
        """The posterior's mean of θ."""
        return self.posterior.mean

    @cached_property
    def intervals(self) -> Float[np.ndarray, "n 2"]:
        """95 % of each parameter, marginal over all others."""
        return median_and_interval(self._samples)[1:].T

    @property
    def is_late(self) -> bool:
        """Whether a delay of the right shutter is more probable than none."""
        return self.delay is not None and self.delay.likely

    @property
    def lens_change(self) -> float:
        """The largest change of a focal length or k1, in standard deviations of the worst calibrations.
        Principal points and tangential terms are loose in every calibration."""
        own = [name.endswith(_DETERMINED) for name in self.names]
        return float(np.max(np.abs(self.theta[own]) / widest(self.chart)[own], initial=0.0))

    @cached_property
    def motions(self) -> tuple[Window, ...]:
        """The motion of the rig at the posterior's mean, in each window."""
        return self.windows.linear_at(self.chart, self.theta)

    @property
    def depth_told(self) -> bool:
        """Whether something but rows tells depth: ranges that agree with it, or a motion."""
        agree = self.matched_ranges.agree(self.chart.rig_at(self.theta))
        return agree or any(one.informative for one in self.motions)

    @one_blas_thread()
    def with_free(self, names: Sequence[str], *, keep_depth: float = 0.0) -> Float[np.ndarray, "n"]:
        """θ that loses least in rows and depth if only these parameters may change; as given, if no rig stands there.

        Args:
            keep_depth: times that a change of depth costs its square, so that it changes only where rows need it, or it
                is known better than it matters.

        Raises:
            InputError: if a name is unknown.
        """
        (theta,) = with_free_together([self], names, keep_depth=keep_depth)
        return theta

    @cached_property
    def loss(self) -> PointwiseLoss:
        """What candidates are chosen by: expected losses of rigs."""
        return PointwiseLoss(self._errors, merged(self.posterior, _NORMALS))

    @cached_property
    def _errors(self) -> Errors:
        """The errors of rigs, if the one at the posterior's mean is true."""
        points = self.points
        if points is None and self.shown is not None:
            points = points_shown(self.shown, self.chart, self.theta, self.view)
        return errors_near(self.chart, self.theta, self.matters, self.view, points, self.slopes)

    @cached_property
    def _samples(self) -> Float[np.ndarray, "s n"]:
        """θ of rigs that are drawn from the posterior; always the same ones."""
        return self.posterior.samples(self.samples)

    @remembered
    @one_blas_thread()
    def losses(self, used: Float[np.ndarray, "n"]) -> Losses:
        """What the rig at θ = used loses, for each of some rigs drawn from the posterior; always the same."""
        # Of a rig without errors, if each sample is the true one. A million: not kept, for results are.
        away, slopes = (one.astype(np.float32) for one in (self._samples - self.theta, self._errors.slopes))
        return self._errors.losses(self._errors.of(used), away @ slopes.T)

    def rows_seen(self, used: Float[np.ndarray, "n"]) -> tuple[Float[np.ndarray, "p"], Float[np.ndarray, "p"]]:
        """Epipolar errors [pixels] of the rig at θ = used, if the one at the posterior's mean is true, at points that
        stand for what the images show, and the weights of these, which sum to 1."""
        return self._errors.readings.of(used)[0], self._errors.seen

    def judged_by(self, matters: Matters) -> "Estimate":
        """The same, where another epipolar error and another error of depth are noticed."""
        return self if self.matters == matters else replace(self, matters=matters, slopes=None)

    @one_blas_thread()
    def expected_loss(self, used: Float[np.ndarray, "n"]) -> float:
        """What the rig at θ = used loses on average: rows over what a matcher notices, and depth over a point; eight
        normal distributions stand for the posterior."""
        return self.loss.expected(self._errors.of(used))

    @one_blas_thread()
    def held_out(self, names: Sequence[str], share: float = 1.0, keep_depth: float = 1.0) -> list[HeldOut]:
        """What parts of the images say of the candidates of the rest, each part left out in turn.

        Args:
            names: as `with_free` has them.
            share: where the candidate lies between the one that keeps depth (0), and the one that loses least (1).
            keep_depth: of the former, as `with_free` has it.
        """
        if self.shown is None:
            return []
        free, at = np.isin(self.names, names), self.theta
        (rows, slopes), before = self.shown.rows(self.chart, at), self.shown.differences(self.chart, np.zeros(len(at)))

        def under(posterior: Mixture) -> Float[np.ndarray, "g"]:
            known, shared = PointwiseLoss(self._errors, posterior), np.zeros_like(free)
            (theta,) = least_loss([known], free, shared, linear=True)
            if share < 1.0:
                (kept,) = least_loss([known], free, shared, keep_depth=keep_depth, linear=True)
                theta = kept + share * (theta - kept)
            return rows + slopes @ (theta - at)

        fitted, found = under(merged(self.posterior, 1)), []
        for name, inside, posterior in self._rests:
            count = self.shown.count[inside]
            of_part = (before, under(posterior), fitted)
            means = (float(np.average(np.abs(one[inside]), weights=count)) for one in of_part)
            found.append(HeldOut(name, int(count.sum()), *means))
        return found

    @cached_property
    def _rests(self) -> list[tuple[str, Bool[np.ndarray, "g"], Mixture]]:
        """Each part of the images that shows enough, and what the rest knows of θ, as one normal distribution."""
        found = []
        for name, inside in parts_of(self.shown) if self.shown is not None and self.hypotheses else ():
            if min(np.count_nonzero(inside), np.count_nonzero(~inside)) >= _FEWEST:
                several = [e for one in self.hypotheses for e in one.explained(one.rows.of(~inside))]
                found.append((name, inside, mixture(several, most=1)))
        return found

    def effect(self, change: Float[np.ndarray, "n"]) -> float:
        """What a small change of θ moves, as the loss counts it."""
        return float(self._errors.weights @ np.abs(self._errors.slopes @ change))

    @remembered
    def _readings(self, distances: tuple[float, ...]) -> Readings:
        """The readings at distances, if the rig at the posterior's mean is true."""
        near = consequences(self.chart, self.theta, distances, self.view)
        return Readings(self.chart, self.theta, self.view, near)

    @one_blas_thread()
    def depth_error_percent(
        self, used: Float[np.ndarray, "n"], distances: Sequence[float] = DISTANCES
    ) -> dict[float, tuple[float, float, float]]:
        """The error of depth of the rig at θ = used, at distances in baselines: median, and 95 % interval; positive: it
        reports too far; infinite where a point seems to lie at infinity or beyond. Over the view, on average."""
        readings = self._readings(tuple(distances))
        of_mean, found = readings.near.mean_over_view(readings.of(used)[1]), {}
        of_samples = of_mean - (self._samples - self.theta) @ readings.near.mean_nearness.T
        for distance, nearness in zip(distances, of_samples.T, strict=True):
            middle, high, low = (
                float("inf") if value < _LEAST_NEARNESS else 100.0 * (1.0 / value - 1.0)
                for value in (1.0 + median_and_interval(nearness)).tolist()
            )
            found[distance] = (middle, low, high)
        return found


@one_blas_thread()
def with_free_together(
    estimates: Sequence[Estimate], names: Sequence[str], *, keep_depth: float = 0.0
) -> list[Float[np.ndarray, "n"]]:
    """θ of each recording's rig that together lose least in rows and depth if only these parameters may change, and all
    but the extrinsics of a drift are the same for all; as given, if no rigs stand there; `keep_depth` times a change of
    depth costs its square.

    Raises:
        InputError: if a name is unknown.
    """
    parameters = estimates[0].names
    for name in names:
        checked_choice(name, list(parameters), "parameter")
    free, shared = np.isin(parameters, names), ~np.isin(parameters, DRIFTING)
    return least_loss([one.loss for one in estimates], free, shared, keep_depth=keep_depth)
