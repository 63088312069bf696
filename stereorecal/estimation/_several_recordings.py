"""Recordings of the same cameras together: what the calibration left is common to them, and each has drifted by itself.

From what a recording shows of θ follows what it shows of the calibration's error, its drift integrated; what all others
show of that is the prior with which a recording is solved. Their drifts are normal meanwhile, and their rows linear
where they were solved last: a few rounds, and all agree.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._drift import drift_sizes
from stereorecal.estimation._estimate import Estimate
from stereorecal.estimation._evidence import Normal, marginal
from stereorecal.estimation._explanations import Explanation
from stereorecal.estimation._least_squares import solved
from stereorecal.estimation._matched_ranges import NO_RANGES, MatchedRanges
from stereorecal.estimation._motion import NO_WINDOWS, Windows
from stereorecal.estimation._prior_conversions import updated
from stereorecal.estimation._rig_parameters import DRIFTING, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.scoring import Correspondences

_ROUNDS = 3  # the first knows nothing of the others
_LEAST = 1e-6  # probability: priors below are left out

Each = Callable[[Callable[[Any], Any], Sequence[Any]], Sequence[Any]]  # does one thing to many, somewhere


@dataclass(frozen=True, eq=False)
class Recording:
    """What is known of one recording.

    Attributes:
        found: correspondences of its frames, with the rays that the cameras of `rig` give.
        rig: the calibration that it started from; those of several recordings have the same cameras.
        prior: of what that leaves; those of several recordings tell of the same error, and none of the others' images.
        start: (n,) θ to begin at; default 0.
        ranges: ranges of what it shows.
        windows: of its frames that follow each other.
        view: in which its rows and depth are judged; None: the rig's own.
    """

    found: Correspondences
    rig: StereoRig
    prior: CalibrationPrior
    start: Float[np.ndarray, "n"] | None = None
    ranges: MatchedRanges = NO_RANGES
    windows: Windows = NO_WINDOWS
    view: View | None = None


def estimate_together(
    recordings: Sequence[Recording], *, each: Each = lambda does, several: [*map(does, several)]
) -> list[Estimate]:
    """The estimate of each recording's rig, from what all of them show.

    Args:
        recordings: one or several.
        each: runs a task for each recording.
    """
    estimates, messages = _round(recordings, [recording.prior for recording in recordings], each)
    variances = [one.prior_variance for one in estimates]
    for _ in range(_ROUNDS - 1 if len(recordings) > 1 else 0):
        recordings = [replace(r, start=one.theta) for r, one in zip(recordings, estimates, strict=True)]
        priors = [
            after(recording.prior, reduce(add, messages[:index] + messages[index + 1 :]))
            for index, recording in enumerate(recordings)
        ]
        estimates, messages = _round(recordings, priors, each)
    return [replace(one, prior_variance=before) for one, before in zip(estimates, variances, strict=True)]


def _round(
    recordings: Sequence[Recording], priors: Sequence[CalibrationPrior], each: Each
) -> tuple[list[Estimate], list[Normal]]:
    done = each(_estimate_of_recording, list(zip(recordings, priors, strict=True)))
    return [one for one, _ in done], [message for _, message in done]


def _estimate_of_recording(task: tuple[Recording, CalibrationPrior]) -> tuple[Estimate, Normal]:
    """A recording with what is known before it, and what it shows of the calibration's error."""
    one, prior = task
    estimated, best = solved(one.found, rig_parameters(one.rig), prior, one.start, one.ranges, one.windows, one.view)
    return estimated, of_calibration(best)


def of_calibration(best: Explanation) -> Normal:
    """The likelihood of the calibration's error under an explanation, the drift integrated: normal, as large as all
    kinds of drift are on average, by their evidence."""
    of_theta, log_evidence = marginal(best.of_rows, best.nuisance), best.found.log_evidence
    weights = np.exp(log_evidence - np.logaddexp.reduce(log_evidence))
    axes, sizes = np.eye(len(of_theta.b)), np.sqrt(weights @ drift_sizes()[0] ** 2)
    to = np.column_stack([axes, axes[:, : len(DRIFTING)]])
    return marginal(Normal(to.T @ of_theta.a @ to, to.T @ of_theta.b, of_theta.c), np.diag(sizes))


def after(prior: CalibrationPrior, known: Normal) -> CalibrationPrior:
    """What is known of the calibration's error after something else has told of it."""
    every = updated(prior, known)
    likely = every.weights > _LEAST
    return CalibrationPrior(
        every.roots[likely], every.weights[likely] / every.weights[likely].sum(), means=every.means[likely]
    )
