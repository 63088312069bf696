"""The one least squares: Gauss-Newton on rows of groups, with the evidence choosing priors and misfit on the way; and
the estimate that it comes to, mixed of all hypotheses.

Recordings of the same cameras are solved together: what the calibration left is common to them, and each has drifted by
itself. From what a recording shows of θ follows what it shows of the calibration's error, its drift integrated; what
all others show of that is the prior with which a recording is solved. Their drifts are normal meanwhile, and their rows
linear where they were solved last. One after the other takes a step, until all agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from operator import add

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation._confounders import hypotheses_with_confounders
from stereorecal.estimation._estimate import Estimate
from stereorecal.estimation._evidence import Explanation, Normal, marginal
from stereorecal.estimation._explanations import (
    Hypothesis,
    best_of,
    evidence_of,
    explained_by,
    explanations,
    hypothesis_near,
    mixture,
)
from stereorecal.estimation._groups import FEWEST_GROUPS, any_same, first_of_same, grouped
from stereorecal.estimation._late_shutter import Delay, delay_of, hypothesis_with_delay
from stereorecal.estimation._linear_groups import COMMON, DEVIATIONS, LinearGroups, Model, OtherRig, other_rigs
from stereorecal.estimation._matched_ranges import NO_RANGES, MatchedRanges
from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._motion import NO_WINDOWS, Windows
from stereorecal.estimation._one_thread import one_blas_thread
from stereorecal.estimation._prior_choice import Prior, as_prior, log_evidence, updated
from stereorecal.estimation._rig_parameters import DRIFTING, rig_parameters, within_field
from stereorecal.geometry import StereoRig, View
from stereorecal.scoring import Correspondences

_ROUNDS = 8
_REGROUPED = 3  # times; then outliers are what they are
_SETTLED = 0.05  # standard deviations of θ
_LIKELY = 1e-3  # of the weight of all hypotheses: one of less is not asked again
_ROUNDS_TOGETHER, _AGREED = 20, 0.02  # at most; standard deviations of θ, where no recording moves any more
_LEAST_WEIGHT = 1e-6  # probability: priors below are left out


@dataclass(frozen=True, eq=False)
class Recording:
    """What is known of one recording; the attributes are the arguments of `estimate`.

    Attributes:
        rig: those of several recordings have the same cameras.
        prior: those of several recordings tell of the same error, and none of the others' images.
        start: θ at which the fit begins, and, of one that is fitted, at which its rows are linear.
        others: what the images of other recordings tell of that error.
    """

    found: Correspondences
    rig: StereoRig
    prior: Mixture
    start: Float[np.ndarray, "n"]
    ranges: MatchedRanges = NO_RANGES
    windows: Windows = NO_WINDOWS
    view: View | None = None
    others: Normal | None = None

    @cached_property
    def likely(self) -> tuple[Int[np.ndarray, "m"], Mixture]:
        """The prior after what others tell: which of its parts are likely then, and those."""
        if self.others is None:
            return np.arange(len(self.prior.weights)), self.prior
        every = updated(self.prior, self.others)
        which = np.flatnonzero(every.weights > _LEAST_WEIGHT)
        weights = every.weights[which] / every.weights[which].sum()
        return which, Mixture(weights, every.means[which], every.covariances[which])

    @cached_property
    def model(self) -> Model:
        """What is known besides its rows."""
        return Model(rig_parameters(self.rig), self.likely[1], self.ranges, self.windows)


@one_blas_thread()
def estimate(
    found: Correspondences,
    rig: StereoRig,
    prior: Prior = None,
    start: Float[np.ndarray, "n"] | None = None,
    ranges: MatchedRanges = NO_RANGES,
    windows: Windows = NO_WINDOWS,
    view: View | None = None,
) -> Estimate:
    """The estimate of a rig.

    Args:
        found: correspondences of one or several frames, with the rays that the cameras of `rig` give.
        rig: the given calibration.
        prior: of what it leaves; default that of a chessboard calibration. `as_prior` of it, made once, saves its time
            where a rig is estimated again.
        start: θ to begin at; default 0.
        ranges: of what was seen; they tell the length of the baseline, too, which the prior must know
            (`with_scaled_boards`).
        windows: tracks of consecutive pairs; they tell depth from the rig's own motion.
        view: in which rows and depth are judged; default the rig's own.
    """
    chart = rig_parameters(rig)
    start = np.zeros(chart.dim) if start is None else start
    return fitted(Recording(found, rig, as_prior(prior, chart), start, ranges, windows, view)).weighed()


@dataclass(frozen=True, eq=False)
class Fit:
    """Rows near the most probable θ, for a prior and a misfit that are the evidence's best.

    Attributes:
        recording: that it is of; it starts where the rows are linear.
        rows: linear near the most probable θ; None, where there are too few. Nuisance parameters may follow θ.
        misfit: the most probable one.
    """

    recording: Recording
    rows: LinearGroups | None
    misfit: tuple[float, float]

    @cached_property
    @one_blas_thread()
    def alone(self) -> Estimate:
        """The estimate under this misfit, without asking what else may be behind the rows: it says where to match, and
        which frames show another rig."""
        return self._mixed([] if self.rows is None else [_alone(self.rows, self.misfit)], self.rows)

    @one_blas_thread()
    def weighed(self) -> Estimate:
        """The estimate, mixed of all hypotheses."""
        return self._mixed([], None) if self.rows is None else self._mixed(*self.hypotheses())

    def hypotheses(self) -> tuple[list[Hypothesis], LinearGroups, Delay | None]:
        """What may be behind the rows; the rows, without a delay that is likely; and what is known of that."""
        assert self.rows is not None
        rows, delay = self.rows, None
        hypotheses = [hypothesis_near(rows, self.misfit)]
        alone = hypotheses[0].several
        hypotheses += hypotheses_with_confounders(rows, alone)
        if (late := hypothesis_with_delay(rows, alone)) is not None:
            delay = delay_of(late[0], [one for some in hypotheses for one in some.several])
            hypotheses.append(late[0])
            rows = late[1] if delay.likely else rows
        return hypotheses, rows, delay

    @cached_property
    def best(self) -> Explanation:
        """The most probable explanation of the rows, with the nuisance parameters that they have."""
        return best_of(self._without_rows if self.rows is None else _alone(self.rows, self.misfit).several)

    @cached_property
    def told(self) -> Normal:
        """What it shows of the calibration's error, the drift integrated: normal, as large as all kinds of drift are on
        average, by their evidence."""
        best = self.best
        of_theta = marginal(best.of_rows, np.diag(best.nuisances.sizes))
        weights = np.exp(best.log_evidence - np.logaddexp.reduce(best.log_evidence))
        axes, sizes = np.eye(len(of_theta.b)), np.sqrt(weights @ best.sizes**2)
        both = of_theta.of_parameters(np.column_stack([axes, axes[:, : len(DRIFTING)]]))
        return marginal(both, np.diag(sizes))

    def beside(self, others: Normal) -> "Fit":
        """The fit after what other recordings tell: a step on, for which outliers are what they are."""
        recording = replace(self.recording, others=others)
        if self.rows is None:
            return Fit(recording, None, self.misfit)
        found = Fit(recording, replace(self.rows, model=recording.model), self.misfit).best
        recording = replace(recording, start=self._within_field(found.theta))
        theta, nuisances = recording.start, found.nuisance_means[found.best]
        rows = recording.model.linear(self.rows.groups, theta, self.rows.likelihoods)
        # To first order, nuisance parameters do what they did.
        rows = rows.beside(self.rows.nuisances, self.rows.jacobian[:, len(theta) :])
        return Fit(recording, rows.robust(sum(self.misfit), np.concatenate([theta, nuisances])), self.misfit)

    def without_nuisances(self) -> "Fit":
        """The fit of θ alone near the same rig, with a misfit of its own, and with what else is measured there."""
        if self.rows is None:
            return self
        best, recording = self.best, replace(self.recording, start=self._within_field(self.best.theta))
        rows = recording.model.linear(self.rows.groups, recording.start)
        for _ in range(2):  # those that err alone have less say the second time
            rows, best = _robust(rows, best, recording.start)
        return Fit(recording, rows, best.misfit)

    def _within_field(self, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
        """θ, or as far towards it from where the rows are linear as the lenses have rays."""
        recording = self.recording
        return recording.start + within_field(
            recording.found, recording.model.chart, recording.start, theta - recording.start
        )

    def _mixed(
        self, hypotheses: Sequence[Hypothesis], rows: LinearGroups | None, delay: Delay | None = None
    ) -> Estimate:
        """The mixture of hypotheses; without rows, of what else was measured."""
        recording, model = self.recording, self.recording.model
        several = [one for some in hypotheses for one in some.several] or self._without_rows
        best, posterior = best_of(several), mixture(several)
        estimated = Estimate(
            model.chart,
            posterior,
            best.misfit,
            0,
            float("nan"),
            _prior_variance(several, recording),
            matched_ranges=model.ranges,
            windows=model.windows,
            view=recording.view,
            delay=delay,
        )
        if rows is not None:
            residual, least = rows.residual(posterior.mean), evidence_of(several) + np.log(_LIKELY)
            estimated = replace(
                estimated,
                groups=len(residual),
                residual_px=float(np.sqrt(np.mean(residual**2))),
                other_rigs=_other_rigs(recording.found, rows, best, posterior.mean),
                shown=rows.groups,
                hypotheses=tuple(one.kept for one in hypotheses if evidence_of(one.several) > least),
            )
        return estimated

    @property
    def _without_rows(self) -> list[Explanation]:
        """What the prior, ranges and windows alone tell of θ."""
        model, flat = self.recording.model, {(0.0, 0.0): Normal.flat(self.recording.model.chart.dim)}
        return explained_by(model, flat, model.likelihoods(self.recording.start), range(len(model.prior.roots)))


@one_blas_thread()
def fitted(recording: Recording) -> Fit:
    """The fit of a recording: a prior and a misfit for a round are the evidence's best."""
    found, model, theta = recording.found, recording.model, recording.start
    chart, misfit, which = model.chart, (DEVIATIONS[2], 0.0), len(model.prior.roots) // 2
    groups = grouped(found, chart, theta)
    if len(groups) < FEWEST_GROUPS:
        return Fit(recording, None, misfit)
    first = first_of_same(groups)
    if any_same(first):
        groups = grouped(found, chart, theta, first)
    rows, step = model.linear(groups, theta), np.zeros(chart.dim)
    for number in range(_ROUNDS):
        best = best_of(_searched(rows, misfit, which))
        misfit, which = best.misfit, best.prior
        deviations = _deviations(best)
        last, step = step, (best.theta - theta) / deviations
        if number and np.abs(step).max() < _SETTLED:  # from the second round on, groups that err alone have less say
            break
        # Where rows bend along what they hardly tell, whole steps go to and fro.
        move = (0.5 if step @ last < 0.0 else 1.0) * step * deviations
        theta = theta + within_field(found, chart, theta, move)
        if number < _REGROUPED:
            groups = grouped(found, chart, theta, first)
        rows = model.linear(groups, theta, None if number < _REGROUPED else rows.likelihoods)
        rows = rows.robust(sum(misfit), theta)
    return Fit(replace(recording, start=theta), rows, misfit)


def _alone(rows: LinearGroups, misfit: tuple[float, float]) -> Hypothesis:
    return Hypothesis.of(rows, explanations(rows, range(len(rows.model.prior.roots)), [misfit]))


def _prior_variance(several: Sequence[Explanation], recording: Recording) -> Float[np.ndarray, "n"]:
    """The variance of the calibration's error before any image was seen, by its covariances' weights after it."""
    evidence, (which, _) = np.array([evidence_of([one]) for one in several]), recording.likely
    weights = np.exp(evidence - np.logaddexp.reduce(evidence))
    return weights @ np.stack([np.diag(recording.prior.covariances[which[one.prior]]) for one in several])


def _other_rigs(
    found: Correspondences, rows: LinearGroups, best: Explanation, theta: Float[np.ndarray, "n"]
) -> tuple[OtherRig, ...]:
    """Frames that show another rig than θ, each by itself, also where several show the same; `best` is the most
    probable explanation of rows near θ."""
    if any_same(rows.groups.first):
        rows = rows.model.linear(grouped(found, rows.model.chart, theta), theta, rows.likelihoods)
        rows, best = _robust(rows, best, theta)
    return other_rigs(rows, sum(best.misfit), theta)


def _robust(rows: LinearGroups, near: Explanation, theta: Float[np.ndarray, "n"]) -> tuple[LinearGroups, Explanation]:
    """The rows near θ, those that err alone with less say, and the most probable explanation of them; searched from one
    that is near."""
    best = best_of(_searched(rows, near.misfit, near.prior))
    return rows.robust(sum(best.misfit), theta), best


def _searched(rows: LinearGroups, misfit: tuple[float, float], which: int) -> list[Explanation]:
    """The best misfit for a prior, then the best prior for that misfit."""
    found = explanations(rows, [which], [(d, misfit[1]) for d in DEVIATIONS])
    if len(rows.frames) > 1:
        deviation = best_of(found).misfit[0]
        found += explanations(rows, [which], [(deviation, c) for c in COMMON])
    return found + explanations(rows, range(len(rows.model.prior.roots)), [best_of(found).misfit])


@one_blas_thread()
def fitted_together(fits: Sequence[Fit]) -> list[Fit]:
    """The fit of each recording's rig from what all of them show; from the fits of each by itself, or beside others."""
    fits = list(fits)
    for _ in range(_ROUNDS_TOGETHER):
        moved = []
        for index, fit in enumerate(fits):
            fits[index] = fit.beside(_told_by_others(fits, index))
            moved.append((fits[index].best.theta - fit.best.theta) / _deviations(fit.best))
        if np.abs(moved).max() < _AGREED:
            break
    return [fit.without_nuisances() for fit in fits]


def agreement(alone: Sequence[Fit], together: Sequence[Fit]) -> Float[np.ndarray, "r"]:
    """How much more probable each recording is as one of the others' calibration than as one of its own, nats; each
    alone, and all fitted together, where those of another calibration have a larger misfit."""
    found = []
    for index, one in enumerate(alone):
        prior, others = one.recording.prior, _told_by_others(together, index)
        beside = log_evidence(prior, others + together[index].told) - log_evidence(prior, others)
        found.append(beside - log_evidence(prior, one.told))
    return np.array(found)


def beside_others(recordings: Sequence[Recording], fits: Sequence[Fit]) -> list[Recording]:
    """Recordings with what the fits of all others tell."""
    return [replace(one, others=_told_by_others(fits, index)) for index, one in enumerate(recordings)]


@one_blas_thread()
def most_probable(recording: Recording) -> Fit:
    """The fit by the rows of the most probable hypothesis, of which nuisance parameters may be a part."""
    fit = fitted(recording)
    if fit.rows is None:
        return fit
    likely = max(fit.hypotheses()[0], key=lambda one: evidence_of(one.several))
    return replace(fit, rows=likely.rows, misfit=likely.misfit)


def _told_by_others(fits: Sequence[Fit], index: int) -> Normal:
    return reduce(add, [fit.told for fit in (*fits[:index], *fits[index + 1 :])])


def _deviations(one: Explanation) -> Float[np.ndarray, "n"]:
    return np.sqrt(np.maximum(np.diag(one.covariances(np.array([one.best]))[0]), 1e-30))
