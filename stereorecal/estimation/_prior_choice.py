"""The priors that users may choose: the default, exact intrinsics, standard deviations, a covariance; and a saved one,
which is what is known of a rig once it was repaired, as a value and as plain data without any rounding.

A rig that was repaired is no chessboard result. Its depth may be whatever the last estimate left open, and a second
look that took it for calibrated would be sure of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal._errors import InputError, checked_choice
from stereorecal.estimation._calibration_prior import calibration_prior, exact_prior
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._rig_parameters import DRIFTING, rig_parameters
from stereorecal.geometry import StereoRig, rig_as_data, rig_from_data, same_rig
from stereorecal.objectives import RigChart

SCHEMA = "stereorecal.prior/2"
_DAMAGED = "this is no prior that stereorecal has written, or it is damaged"
_INSTEAD = 'copy it again, or go on without it: prior="default" (--prior default)'
_YAW_UNKNOWN = 1.0  # degrees: what a repair that takes the intrinsics as exact may leave, which is all of depth
DEFAULT, EXACT, SAVED = "default", "exact", "saved"
_TINY = 1e-300
_NOT_POSITIVE = 1e-9  # of the largest eigenvalue of the correlations


@dataclass(frozen=True, eq=False)
class SavedPrior:
    """What is known of a rig after a repair, as `Solution.prior` and `load_prior` give it; `recalibrate` takes it as
    `prior=` with this very rig, and `sr.io.save_rig` writes it with the rig.

    Attributes:
        rig: the calibration to use, which is θ = 0.
        known: of θ (n,), changes of all parameters, in the units of `CalibrationCovariance`; "default": what is known
            of any calibration; None: the rig was repaired, and of its depth nothing is known.
        images: fingerprints of the pairs that this rests on; they do not count again.
        earlier: what the last repair began with, which stands in where only its own images are looked at again; None
            if that is not known.
    """

    rig: StereoRig
    known: Mixture | str | None
    images: tuple[str, ...] = ()
    earlier: "SavedPrior | None" = None

    def counted_from(self, rig: StereoRig) -> "SavedPrior":
        """The same, for another calibration of this rig."""
        chart = rig_parameters(self.rig)
        known = _known(self.known, chart)
        return replace(self, rig=rig, known=replace(known, means=known.means - chart.coordinates_of(rig)))

    def check(self, rig: StereoRig) -> None:
        """Refuse another rig.

        Raises:
            InputError: says what to do.
        """
        if not same_rig(self.rig, rig):
            raise InputError("this prior belongs to another rig; give solution.prior together with solution.rig.")

    def as_dict(self) -> dict[str, Any]:
        """Lists, text and finite numbers, without any rounding."""
        parameters, known = rig_parameters(self.rig).parameters, self.known
        return {
            "schema": SCHEMA,
            "rig": rig_as_data(self.rig),
            "names": [parameter.name for parameter in parameters],
            "units": [parameter.unit for parameter in parameters],
            "components": known.as_data() if isinstance(known, Mixture) else known,
            "images": list(self.images),
            "earlier": self.earlier and self.earlier.as_dict(),
        }

    @staticmethod
    def from_dict(content: Any) -> "SavedPrior":
        """The inverse of `as_dict`.

        Raises:
            InputError: if it is something else, of another version, or damaged.
        """
        schema = content.get("schema") if isinstance(content, dict) else None
        if schema != SCHEMA:
            raise InputError(f"{_DAMAGED} (its schema is {schema!r:.60}, not {SCHEMA!r}); {_INSTEAD}.")
        try:
            rig, known, images = rig_from_data(content["rig"]), content["components"], content["images"]
            names, earlier = rig_parameters(rig).names, content["earlier"]
            if tuple(content["names"]) != names:
                raise InputError(f"it names other parameters than this version of stereorecal has; {_INSTEAD}.")
            if known not in (None, DEFAULT):
                known = Mixture.from_data(known, len(names))
            if not isinstance(images, list) or not all(isinstance(one, str) for one in images):
                raise ValueError("fingerprints that are none")
            return SavedPrior(rig, known, tuple(images), None if earlier is None else SavedPrior.from_dict(earlier))
        except InputError as error:
            raise InputError(f"{_DAMAGED}: {error}") from None
        except (KeyError, TypeError, ValueError, AttributeError, np.linalg.LinAlgError):
            raise InputError(f"{_DAMAGED}; {_INSTEAD}.") from None


def recentred_posterior(posterior: Mixture, used: Float[np.ndarray, "n"]) -> Mixture:
    """What a posterior says of changes from the rig at θ = used: one normal distribution, since six hold the truth no
    more often (two repairs in turn of 180 simulated rigs)."""
    covariance = 0.5 * (posterior.covariance + posterior.covariance.T)
    return Mixture.single(posterior.mean - used, covariance)


def updated(prior: Mixture, normal: Normal) -> Mixture:
    """Each normal distribution given the likelihood, weighed by its evidence."""
    return _updated(prior, normal)[0]


def log_evidence(prior: Mixture, normal: Normal) -> float:
    """The logarithm of what the likelihood is on average under the prior."""
    return _updated(prior, normal)[1]


def _updated(prior: Mixture, normal: Normal) -> tuple[Mixture, float]:
    halves, means, logs = [], [], []
    for one, mean, weight in zip(prior.roots, prior.means, prior.weights, strict=True):
        around = normal.around(mean)
        lower = np.linalg.cholesky(np.eye(len(mean)) + one.T @ around.a @ one)
        pull, after = np.linalg.solve(lower, one.T @ around.b), np.linalg.solve(lower, one.T)
        halves.append(after)
        means.append(mean + after.T @ pull)
        logs.append(np.log(weight) - 0.5 * (around.c - pull @ pull) - np.log(np.diag(lower)).sum())
    evidence = float(np.logaddexp.reduce(logs))
    return Mixture(
        np.exp(np.array(logs) - evidence), np.stack(means), np.stack([half.T @ half for half in halves])
    ), evidence


@dataclass(frozen=True, eq=False)
class CalibrationCovariance:
    """How well a calibration is known, as mrcal and other calibrations with uncertainties say it.

    Attributes:
        names: of the parameters: "pitch", "yaw", "roll", "y", "z", "baseline", "left.f", "left.cx", …; those that are
            missing are as exact as they were given.
        covariance: (n, n) in their units: degrees for angles, percent of the baseline for y, z and baseline, percent
            for f and aspect, pixels for cx and cy, and coefficients as they are.
        mean: (n,) by how much the true rig probably differs from the one that this goes with; default 0.

    Raises:
        InputError: if names and shapes do not fit, or the matrix is not symmetric and positive definite.
    """

    names: Sequence[str]
    covariance: Float[AnyArray, "n n"]
    mean: Float[AnyArray, "n"] | None = None

    def __post_init__(self) -> None:
        names, covariance = tuple(self.names), np.array(self.covariance, float)
        mean = np.zeros(len(names)) if self.mean is None else np.array(self.mean, float)
        if mean.shape != (len(names),) or not np.isfinite(mean).all():
            raise InputError(
                f"the mean has the shape {mean.shape} for {len(names)} names; give one finite number for each name, or "
                "leave it out."
            )
        if covariance.shape != (len(names), len(names)) or len(set(names)) < len(names):
            raise InputError(
                f"the covariance has the shape {covariance.shape} for {len(names)} names; give one row and one column "
                "for each name, and no name twice."
            )
        if not np.isfinite(covariance).all():
            raise InputError("the covariance is not finite; give it as the calibration wrote it.")
        deviations = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        correlations = covariance / deviations[:, None] / deviations
        if not np.allclose(correlations, correlations.T, rtol=0.0, atol=1e-6):
            raise InputError("the covariance is not symmetric; give it as the calibration wrote it.")
        covariance, values = 0.5 * (covariance + covariance.T), np.linalg.eigvalsh(correlations)
        if np.diag(covariance).min(initial=1.0) <= 0.0 or values.min(initial=1.0) < -_NOT_POSITIVE * values.max():
            raise InputError("the covariance is not positive definite; check its order and its units.")
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "covariance", covariance)
        object.__setattr__(self, "mean", mean)


Prior = str | Mapping[str, float | np.number] | CalibrationCovariance | SavedPrior | Mixture | None


def as_prior(prior: Prior, chart: RigChart) -> Mixture:
    """The prior itself, for the rig of a chart.

    Raises:
        InputError: as `check_prior`.
    """
    check_prior(prior, chart)
    if isinstance(prior, Mixture):
        return prior
    if isinstance(prior, SavedPrior):
        return _known(prior.known, chart)
    if prior is None or prior == DEFAULT:
        return calibration_prior(chart)
    if prior == SAVED:
        raise InputError('"saved" is for recalibrate, which looks it up; give solution.prior, or sr.load_prior(path).')
    if isinstance(prior, str):
        return exact_prior(chart)
    if isinstance(prior, CalibrationCovariance):
        where = [chart.names.index(name) for name in prior.names]
        covariance, mean = np.zeros((chart.dim, chart.dim)), np.zeros(chart.dim)
        covariance[np.ix_(where, where)], mean[where] = prior.covariance, prior.mean
        return Mixture.single(mean, covariance)
    return with_deviations(calibration_prior(chart), chart, prior)


def _known(known: Mixture | str | None, chart: RigChart) -> Mixture:
    """What was known of a rig as a prior; of one that was repaired, and nobody knows how well, that of a calibration
    with a yaw that may be off by any amount that is left."""
    if isinstance(known, Mixture):
        return known
    loose, yaw = np.zeros((chart.dim, chart.dim)), DRIFTING.index("yaw")
    loose[yaw, yaw] = 0.0 if known == DEFAULT else _YAW_UNKNOWN**2
    return calibration_prior(chart).beside(loose)


def check_prior(prior: Prior, chart: RigChart | None = None) -> None:
    """Refuse what is no prior.

    Raises:
        InputError: says what to do.
    """
    if isinstance(prior, SavedPrior) and chart is not None:
        prior.check(chart.rig)
    if isinstance(prior, Mixture) and chart is not None and prior.means.shape[1] != chart.dim:
        raise InputError(
            f"the prior is of {prior.means.shape[1]} parameters, and the rig has {chart.dim}; make it for this rig."
        )
    if prior is None or isinstance(prior, Mixture | SavedPrior):
        return
    if isinstance(prior, str):
        checked_choice(prior, [SAVED, DEFAULT, EXACT], "prior")
        return
    if not isinstance(prior, Mapping | CalibrationCovariance):
        raise InputError(
            f'prior is a {type(prior).__name__}; give "saved", "default", "exact", standard deviations by name such as '
            '{"left.f": 0.2} (percent), an sr.CalibrationCovariance, or the prior of a solution.'
        )
    if chart is not None:
        for name in prior if isinstance(prior, Mapping) else prior.names:
            checked_choice(name, list(chart.names), "parameter")
    for name, sigma in prior.items() if isinstance(prior, Mapping) else ():
        number = isinstance(sigma, Real) and not isinstance(sigma, bool)
        if not (number and np.isfinite(sigma) and sigma > 0.0):
            raise InputError(f"the prior of {name} is {sigma!r}; give a positive standard deviation.")


def with_deviations(prior: Mixture, chart: RigChart, sigmas: Mapping[str, float | np.number]) -> Mixture:
    """The prior where these standard deviations of some parameters are known: of what was uncertain, what is named
    keeps its correlations, and what is not follows it as it did before; what was as exact as given gets one of its
    own."""
    wanted = np.array([float(sigmas.get(name, 0.0)) for name in chart.names])
    uncertain = prior.covariances.any(axis=(0, 2))
    named, others = np.flatnonzero((wanted > 0.0) & uncertain), np.flatnonzero((wanted == 0.0) | ~uncertain)
    covariances = []
    for one in prior.roots if len(named) else ():
        deviations = np.maximum(np.linalg.norm(one, axis=1), _TINY)  # of what is exact
        unit = one / deviations[:, None]
        both, scale = unit[named] @ unit[named].T, wanted[named] / deviations[named]
        follows = np.linalg.solve(both, unit[named] @ unit[others].T).T
        # What is named, its change, and what of the rest does not follow it, are independent.
        known = np.zeros((chart.dim, len(named) + chart.dim))
        known[named, : len(named)] = scale[:, None] * np.linalg.cholesky(both)
        known[others, : len(named)] = follows @ known[named, : len(named)]
        known[others, len(named) :] = unit[others] - follows @ unit[named]
        covariances.append(deviations[:, None] * (known @ known.T) * deviations)
    found = replace(prior, covariances=np.stack(covariances)) if covariances else prior
    return found.beside(np.diag(np.where(uncertain, 0.0, wanted) ** 2))


def is_exact(prior: Prior) -> bool:
    """Whether the intrinsics are the truth."""
    return isinstance(prior, str) and prior == EXACT
