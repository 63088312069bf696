"""What may move in a rig: names of parameters, how far they may have drifted, and their priors."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

import numpy as np

from stereorecal._errors import InputError, checked_choice
from stereorecal.geometry import OF_MATRIX, StereoRig

ROTATION = ("pitch", "yaw", "roll")
EXTRINSICS = (*ROTATION, "y", "z")  # x stays: the length of the baseline only scales depth (paper, section 3.3)
BASELINE = "baseline"
SIDES = ("left", "right")

_DEFAULT_LENS = ("f", "cx", "cy", "k1", "k2")
_OPTIONAL_LENS = ("aspect", "p1", "p2", "k3", "s1", "s2", "s3", "s4", "k4", "xi", "alpha", "beta")
INTRINSICS = tuple(f"{side}.{name}" for side in SIDES for name in _DEFAULT_LENS)
GROUPS = {"rotation": ROTATION, "extrinsics": EXTRINSICS, "intrinsics": INTRINSICS}
NAMES = (*EXTRINSICS, BASELINE, *(f"{side}.{name}" for side in SIDES for name in (*_DEFAULT_LENS, *_OPTIONAL_LENS)))
# Standard deviations. A chessboard's focal length is good to some tenths of a percent, its centre to a pixel or two of
# a VGA image, k1 to a hundredth (evidence: repeated calibrations of public data sets).
_SIGMAS = {"f": 0.5, "cx": 2.0, "cy": 2.0, "k1": 0.01, "k2": 0.02, "aspect": 0.1, "p1": 5e-4, "p2": 5e-4, "k3": 0.02}
_SIGMAS |= {"k4": 0.02, "xi": 0.01, "alpha": 0.01, "beta": 0.02}
_SIGMAS |= {"s1": 5e-4, "s2": 5e-4, "s3": 5e-4, "s4": 5e-4}
_USUAL_COEFFICIENTS = 5  # k1 k2 p1 p2 k3: what calibrations of pinhole cameras have, and all programs read
_OF_BASELINE = 1.0  # percent
_UNITS = {"f": "%", "aspect": "%", "cx": "px", "cy": "px"}
_WIDTH = 640  # pixels of the image for which the centres' standard deviation is given


@dataclass(frozen=True)
class Reach:
    """How far the rig may have drifted: the half widths of the box in which the count is searched. Epipolar stages have
    a prior with a standard deviation of a third of the reach, and may go to twice the reach. On axes that have a prior
    of their own (`Parameters.priors`), three of its standard deviations take the place of the reach.

    Attributes:
        degrees: on pitch, yaw and roll.
        baseline_fraction: on y and z, as a fraction of the baseline.

    Raises:
        InputError: if either is not positive, or the rotation exceeds 20 degrees, the translation half the baseline.
    """

    degrees: float = 3.0
    baseline_fraction: float = 0.03

    def __post_init__(self) -> None:
        if not (0 < self.degrees <= 20 and 0 < self.baseline_fraction <= 0.5):
            raise InputError(
                f"a reach of {self.degrees} degrees and {self.baseline_fraction} of the baseline makes no sense; "
                "give up to 20 degrees and up to 0.5."
            )


def as_reach(reach: Any) -> Reach:
    """The given reach, the reach of (degrees, fraction of the baseline), or the default for None.

    Raises:
        InputError: if it is none of these.
    """
    if reach is None or isinstance(reach, Reach):
        return reach or Reach()
    if isinstance(reach, tuple | list) and len(reach) == 2 and all(isinstance(v, Real) for v in reach):
        return Reach(float(reach[0]), float(reach[1]))
    raise InputError(f"reach is {reach!r}; give sr.Reach(degrees=3.0, baseline_fraction=0.03), or a tuple (3.0, 0.03).")


@dataclass(frozen=True)
class Parameter:
    """One number of a rig that is free.

    Attributes:
        name: "pitch", "left.k1", …
        unit: "deg", "%" (of the baseline, or of the focal length), "px", or "" for coefficients.
        sigma: standard deviation of its prior, in that unit.
        in_rig: one such unit in the units of the rig: rad, metres, a fraction, pixels, 1.
    """

    name: str
    unit: str
    sigma: float
    in_rig: float


@dataclass(frozen=True)
class Parameters:
    """The free parameters, by names and groups, and their priors.

    Attributes:
        free: of "pitch", "yaw", "roll", "y", "z", "baseline", and of each camera "left.f" (focal length), "left.cx",
            "left.cy", "left.k1", "left.k2", on request "left.aspect", "left.p1", "left.p2", "left.k3", "left.s1" to
            "left.s4", and of other lens models their terms, as "left.k4" of an equidistant one; or of the groups
            "rotation", "extrinsics" (the first five) and "intrinsics" (the first five of each camera). The rest is held
            exactly.
        priors: standard deviations by name where they are not the default: degrees for angles, percent of the baseline
            for y, z and the baseline, percent for focal lengths and aspects, pixels for centres. Default: a third of
            the reach for extrinsics, 1 % for the baseline; 0.5 %, 2 px (of an image 640 wide), k1 0.01, k2 0.02.
            In repairs, those of extrinsics apply to the search, whose box is three of them wide, and to exact
            intrinsics, since the estimate finds how far a rig has drifted; all others replace the prior of the
            calibration.
        everything: whether all other parameters of the rig are free as well. The default of `recalibrate`.

    Raises:
        InputError: if a name is unknown, nothing is free, or a prior is not positive.
    """

    free: tuple[str, ...] = ("extrinsics",)
    priors: Mapping[str, float] = field(default_factory=dict)
    everything: bool = False

    def __post_init__(self) -> None:
        choices = [*GROUPS, *NAMES]
        free = (self.free,) if isinstance(self.free, str) else tuple(self.free)
        for name in free:
            checked_choice(name, choices, "parameter")
        for name, sigma in self.priors.items():
            checked_choice(name, list(NAMES), "parameter")
            if not (np.isfinite(sigma) and sigma > 0.0):
                raise InputError(f"the prior of {name} is {sigma}; give a positive standard deviation.")
        if not free:
            raise InputError('nothing is free; name parameters or groups, such as ("extrinsics",).')
        object.__setattr__(self, "free", free)
        object.__setattr__(self, "priors", dict(self.priors))

    @property
    def names(self) -> tuple[str, ...]:
        """Every parameter that is free, in the order of NAMES."""
        wanted = {name for entry in self.free for name in GROUPS.get(entry, (entry,))}
        return tuple(name for name in NAMES if name in wanted)

    @property
    def extrinsics(self) -> "Parameters":
        """The extrinsics among them, with their priors: all that images of one rig can determine by themselves.

        Raises:
            InputError: if there are none.
        """
        if not self.axes:
            raise InputError("no extrinsics are free; free them as well, since every drift moves them.")
        return Parameters(self.axes, self.priors)

    @property
    def axes(self) -> tuple[str, ...]:
        """The extrinsics among them."""
        return tuple(name for name in self.names if name in EXTRINSICS)

    @property
    def shared(self) -> tuple[str, ...]:
        """What recordings of one rig share: its baseline and its intrinsics."""
        return tuple(name for name in self.names if name not in EXTRINSICS)

    @property
    def intrinsics(self) -> tuple[str, ...]:
        """The intrinsics among them."""
        return tuple(name for name in self.names if "." in name)

    def also(self, *names: str) -> "Parameters":
        """The parameters with these free as well."""
        return replace(self, free=(*self.names, *names))

    def of_all(self, rig: StereoRig, *, intrinsics: bool = True) -> "Parameters":
        """These by name, of a rig; where `everything` is free, with every parameter of its cameras for which these have
        a coefficient, or the usual five; without `intrinsics`, where everything is free, these are not."""
        if not self.everything:
            return self
        sides = (("left", rig.left), ("right", rig.right)) if intrinsics else ()
        terms = []
        for side, camera in sides:
            held = camera.lens.TERMS[: max(len(camera.distortion), _USUAL_COEFFICIENTS)]
            terms += [f"{side}.{kind}" for kind in (*OF_MATRIX, *camera.lens.CALIBRATED) if kind in (*OF_MATRIX, *held)]
        return replace(self.also(*terms), everything=False)

    def of(self, rig: StereoRig, reach: Reach) -> tuple[Parameter, ...]:
        """Each of them, for a rig and a reach.

        Raises:
            InputError: as `check`.
        """
        self.check(rig)
        return tuple(self._parameter(name, rig, reach) for name in self.names)

    def check(self, rig: StereoRig) -> None:
        """Refuse terms that a lens of the rig does not have.

        Raises:
            InputError: if there is one.
        """
        for name in self.intrinsics:
            side, kind = name.split(".")
            lens = getattr(rig, side).lens
            if kind not in (*OF_MATRIX, *lens.CALIBRATED):
                own = ", ".join(f"{side}.{term}" for term in lens.CALIBRATED)
                raise InputError(
                    f"{name} is no parameter of a lens of the model {lens.NAME!r}; free some of {own}, or leave it out."
                )

    def _parameter(self, name: str, rig: StereoRig, reach: Reach) -> Parameter:
        if name in ROTATION:
            unit, sigma, in_rig = "deg", reach.degrees / 3.0, float(np.pi / 180.0)
        elif name in EXTRINSICS:
            unit, sigma, in_rig = "%", 100.0 * reach.baseline_fraction / 3.0, float(rig.baseline) / 100.0
        elif name == BASELINE:
            unit, sigma, in_rig = "%", _OF_BASELINE, float(rig.baseline) / 100.0
        else:
            kind = name.split(".")[1]
            unit, sigma = _UNITS.get(kind, ""), _SIGMAS[kind]
            sigma *= rig.left.size[0] / _WIDTH if unit == "px" else 1.0
            in_rig = 0.01 if unit == "%" else 1.0
        return Parameter(name, unit, float(self.priors.get(name, sigma)), in_rig)


def as_parameters(free: Any) -> Parameters:
    """The parameters themselves, those of a name or of names, or the default for None: every one of the rig, but for
    the length of its baseline, which only more than images can tell.

    Raises:
        InputError: if it is something else, or a name is unknown.
    """
    if free is None or isinstance(free, Parameters):
        return free or Parameters(everything=True)
    if isinstance(free, str | tuple | list) and all(isinstance(name, str) for name in free):
        return Parameters((free,) if isinstance(free, str) else tuple(free))
    raise InputError(f'free is {free!r}; give names or groups, such as ("extrinsics", "intrinsics").')
