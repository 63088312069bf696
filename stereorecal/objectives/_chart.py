"""The chart: from the unit box, which strategies see, to extrinsics, which they do not."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics, namespace
from stereorecal._errors import InputError
from stereorecal._pytree import register_pytree
from stereorecal.geometry import AXES, StereoRig

FREE_AXES = (
    "pitch",
    "yaw",
    "roll",
    "y",
    "z",
)  # x stays: the baseline's length only scales depth (paper, section 3.3)


@dataclass(frozen=True)
class Reach:
    """How far the rig may have drifted: the half widths of the box in which the count is searched. Epipolar stages,
    which a prior of a third of the reach holds back, may go to twice as far.

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


@register_pytree
@dataclass(frozen=True, eq=False)
class Chart:
    """An affine map from the unit box [-1, 1]^n to extrinsics.

    Attributes:
        centre: (6,) the extrinsics at z = 0.
        half_width: (6,) how far each parameter moves at z = 1; 0 for fixed ones.
        free: indices of the free parameters, one for each coordinate of z.
    """

    centre: Extrinsics
    half_width: Extrinsics
    free: tuple[int, ...] = field(metadata={"static": True})

    @property
    def dim(self) -> int:
        """n, the number of free parameters."""
        return len(self.free)

    def extrinsics(self, z: Float[AnyArray, "*k n"]) -> Float[AnyArray, "*k 6"]:
        """Unit box to extrinsics; float64 for NumPy arrays, traceable for JAX arrays."""
        spread = np.eye(6)[list(self.free)] * self.half_width
        return self.centre + namespace(z).asarray(z) @ spread

    def coordinates(self, extrinsics: Float[AnyArray, "*k 6"]) -> Float[AnyArray, "*k n"]:
        """Extrinsics to unit box (free parameters only)."""
        free = list(self.free)
        return ((extrinsics - self.centre) / np.where(self.half_width == 0, 1.0, self.half_width))[..., free]


def chart_around(rig: StereoRig, reach: Reach, free: tuple[str, ...] = FREE_AXES) -> Chart:
    """The chart whose box is centred on the rig's extrinsics [rad, m]."""
    angle, length = np.radians(reach.degrees), reach.baseline_fraction * float(rig.baseline)
    indices = tuple(AXES.index(name) for name in free)
    half_width = np.zeros(6)
    half_width[list(indices)] = [angle if i < 3 else length for i in indices]
    return Chart(np.array(rig.extrinsics, float), half_width, indices)


def dimensionless(chart: Chart) -> Chart:
    """The same chart with translations in units of the baseline, which is how scores see them."""
    unit = np.array([1.0, 1.0, 1.0, *[np.linalg.norm(chart.centre[3:])] * 3])
    return Chart(chart.centre / unit, chart.half_width / unit, chart.free)
