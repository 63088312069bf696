"""What is known of a rig once it was repaired, as a value and as plain data: the prior of the next call.

A rig that was repaired is no chessboard result. Its depth may be whatever the last estimate left open, and a second
look that took it for calibrated would be sure of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.estimation._mixture_as_data import components_of, mixture_from
from stereorecal.estimation._posterior import Posterior
from stereorecal.estimation._rig_parameters import rig_parameters
from stereorecal.geometry import StereoRig, rig_as_data, rig_from_data, same_rig

SCHEMA = "stereorecal.prior/1"
_DAMAGED = "this is no prior that stereorecal has written, or it is damaged"
_INSTEAD = 'copy it again, or go on without it: prior="default" (--prior default)'


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
