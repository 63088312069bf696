"""The chart: from the unit box, which strategies see, to extrinsics, which they do not."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics, namespace, product, register_pytree


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
        return self.centre + product(namespace(z).asarray(z), spread)

    def coordinates(self, extrinsics: Float[AnyArray, "*k 6"]) -> Float[AnyArray, "*k n"]:
        """Extrinsics to coordinates of the box (free parameters only), beyond [-1, 1] where they lie outside of it."""
        free = list(self.free)
        return ((extrinsics - self.centre) / np.where(self.half_width == 0, 1.0, self.half_width))[..., free]

    def inside(self, extrinsics: Float[np.ndarray, "6"]) -> Float[np.ndarray, "n"]:
        """The point of the box that is nearest to the extrinsics, coordinate by coordinate."""
        return np.clip(self.coordinates(extrinsics), -1.0, 1.0)

    def with_unit_baseline(self) -> "Chart":
        """The same chart with translations in units of the baseline, which is how scores see them."""
        unit = np.array([1.0, 1.0, 1.0, *[np.linalg.norm(self.centre[3:])] * 3])
        return Chart(self.centre / unit, self.half_width / unit, self.free)
