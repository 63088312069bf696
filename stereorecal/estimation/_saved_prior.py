"""What is known of a rig once it was repaired, as a value and as plain data without any rounding: the prior of the next
call.

A rig that was repaired is no chessboard result. Its depth may be whatever the last estimate left open, and a second
look that took it for calibrated would be sure of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.estimation._posterior import Posterior
from stereorecal.estimation._rig_parameters import rig_parameters
from stereorecal.geometry import StereoRig, rig_as_data, rig_from_data, same_rig

_NOT_POSITIVE = 1e-6  # of the largest eigenvalue of the correlations
SCHEMA = "stereorecal.prior/1"
_DAMAGED = "this is no prior that stereorecal has written, or it is damaged"
_INSTEAD = 'copy it again, or go on without it: prior="default" (--prior default)'


def components_of(known: Posterior) -> list[dict[str, Any]]:
    """Of each its weight, its mean, and the rows of its covariance up to the diagonal."""
    return [
        {
            "weight": float(weight),
            "mean": mean.tolist(),
            "covariance": [row[: end + 1].tolist() for end, row in enumerate(covariance)],
        }
        for weight, mean, covariance in zip(known.weights, known.means, known.covariances, strict=True)
    ]


def mixture_from(components: Any, dim: int) -> Posterior:
    """The inverse.

    Args:
        dim: n, the number of parameters.

    Raises:
        KeyError, TypeError, ValueError: if these are none.
    """
    weights = np.array([one["weight"] for one in components], float)
    means = np.array([one["mean"] for one in components], float)
    covariances = np.stack([_covariance(one["covariance"], dim) for one in components])
    if means.shape != (len(weights), dim) or not (np.isfinite(means).all() and np.isfinite(weights).all()):
        raise ValueError("means of another size, or not finite")
    if weights.min() <= 0.0 or not np.isclose(weights.sum(), 1.0, rtol=0.0, atol=1e-9):
        raise ValueError("weights do not sum to 1")
    return Posterior(weights, means, covariances)


def _covariance(rows: Any, dim: int) -> np.ndarray:
    if [len(row) for row in rows] != list(range(1, dim + 1)):
        raise ValueError("a covariance of another size")
    half = np.zeros((dim, dim))
    half[np.tril_indices(dim)] = np.concatenate(rows)
    covariance = half + np.tril(half, -1).T
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(scale > 0.0, scale, 1.0)
    if not np.isfinite(covariance).all() or np.diag(covariance).min() < 0.0:
        raise ValueError("a matrix that is no covariance")
    values = np.linalg.eigvalsh(covariance / safe[:, None] / safe)
    if values.min() < -_NOT_POSITIVE * max(values.max(), 1.0):
        raise ValueError("a covariance that is not positive")
    return covariance


@dataclass(frozen=True, eq=False)
class Earlier:
    """What a repair began with.

    Attributes:
        rig: the calibration.
        prior: "default", standard deviations by name, a mixture of θ around that rig, or None: nothing was known of its
            depth.
        images: fingerprints of the pairs that this prior rests on.
    """

    rig: StereoRig
    prior: str | Mapping[str, Any] | Posterior | None
    images: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SavedPrior:
    """What is known of a rig after a repair, as `Solution.prior` and `load_prior` give it; `recalibrate` takes it as
    `prior=` with this very rig, and `sr.io.save_rig` writes it with the rig.

    Attributes:
        rig: the calibration to use, which is θ = 0.
        known: of θ (n,), changes of all parameters, in the units of `CalibrationCovariance`; None: the rig was
            repaired, and of its depth nothing is known.
        images: fingerprints of the pairs that this rests on; they do not count again.
        earlier: what the last repair began with, which stands in where only its own images are looked at again; None
            if that is not known.
    """

    rig: StereoRig
    known: Posterior | None
    images: tuple[str, ...] = ()
    earlier: Earlier | None = None

    def check(self, rig: StereoRig) -> None:
        """Refuse another rig.

        Raises:
            InputError: says what to do.
        """
        if not same_rig(self.rig, rig):
            raise InputError("this prior belongs to another rig; give solution.prior together with solution.rig.")

    def as_dict(self) -> dict[str, Any]:
        """Lists, text and finite numbers, without any rounding."""
        parameters, earlier = rig_parameters(self.rig).parameters, self.earlier
        return {
            "schema": SCHEMA,
            "rig": rig_as_data(self.rig),
            "names": [parameter.name for parameter in parameters],
            "units": [parameter.unit for parameter in parameters],
            "components": self.known and components_of(self.known),
            "images": list(self.images),
            "earlier": earlier and _earlier_as_dict(earlier),
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
            rig, found = rig_from_data(content["rig"]), content["earlier"]
            names, components = rig_parameters(rig).names, content["components"]
            if tuple(content["names"]) != names:
                raise InputError(f"it names other parameters than this version of stereorecal has; {_INSTEAD}.")
            known = None if components is None else mixture_from(components, len(names))
            return SavedPrior(rig, known, _images(content), None if found is None else _earlier_from(found))
        except InputError as error:
            raise InputError(f"{_DAMAGED}: {error}") from None
        except (KeyError, TypeError, ValueError, AttributeError, np.linalg.LinAlgError) as error:
            raise InputError(f"{_DAMAGED} ({error!r:.80}); {_INSTEAD}.") from None


def _earlier_as_dict(earlier: Earlier) -> dict[str, Any]:
    prior: Any = earlier.prior
    if isinstance(prior, Posterior):
        prior = components_of(prior)
    elif isinstance(prior, Mapping):
        prior = dict(prior)
    return {"rig": rig_as_data(earlier.rig), "prior": prior, "images": list(earlier.images)}


def _earlier_from(content: dict[str, Any]) -> Earlier:
    rig, prior = rig_from_data(content["rig"]), content["prior"]
    names = rig_parameters(rig).names
    if isinstance(prior, list):
        prior = mixture_from(prior, len(names))
    elif isinstance(prior, dict):
        if not all(name in names and float(sigma) > 0.0 for name, sigma in prior.items()):
            raise ValueError("deviations that are none")
    elif prior not in (None, "default"):
        raise ValueError(prior)
    return Earlier(rig, prior, _images(content))


def _images(content: dict[str, Any]) -> tuple[str, ...]:
    images = content["images"]
    if not isinstance(images, list) or not all(isinstance(one, str) for one in images):
        raise ValueError("fingerprints that are none")
    return tuple(images)
