"""What a lens model offers."""

from abc import ABC, abstractmethod
from types import ModuleType
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, is_host, namespace

# Rays (x/z, y/z, 1) go no farther from the axis: 83 degrees. A pinhole view of more shows next to nothing.
FLAT_LIMIT = 8.0

LEAST_FIELD = np.radians(5.0)  # no lens folds its image back nearer to its axis

Coefficients = Float[np.ndarray, "c"]


class LensModel(ABC):
    """The functions of one model. Image points are pixels less the principal point, over the focal lengths. Directions
    have any length, in the camera's frame; each function takes NumPy arrays (float64) or JAX arrays (float32, traced,
    differentiable) and answers in kind.

    Attributes:
        NAME: as `Camera.model` has it.
        ABOUT: the model and its coefficients, in a few words.
        TERMS: names of coefficients, in their order; without a unit. Those at the end may lack one: they cannot be
            free.
        CALIBRATED: the terms that a calibration leaves uncertain.
        COUNTS: how many coefficients there may be, rising.
        WIDE: whether directions of 90 degrees off the axis and more can have an image.
    """

    NAME: ClassVar[str]
    ABOUT: ClassVar[str]
    TERMS: ClassVar[tuple[str, ...]]
    CALIBRATED: ClassVar[tuple[str, ...]]
    COUNTS: ClassVar[tuple[int, ...]]
    WIDE: ClassVar[bool] = True

    @abstractmethod
    def check(self, coefficients: Coefficients) -> None:
        """Refuse what no lens has.

        Raises:
            InputError: if the coefficients are none of a lens.
        """

    @abstractmethod
    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
        """Image points of directions, whose x, y and z come apart: pairs in memory cost four times the time. Analytic
        in all its arguments, so that complex steps differentiate it; several lenses broadcast against the directions.
        Without a meaning beyond `field`."""

    @abstractmethod
    def unproject(
        self,
        points: Float[AnyArray, "*n 2"],
        coefficients: Float[AnyArray, "c"],
        start: Float[np.ndarray, "*n 2"] | None = None,
    ) -> Float[AnyArray, "*n 3"]:
        """Directions of image points: unit vectors, or (x/z, y/z, 1) if the model is not WIDE. NaN where the model has
        none.

        Args:
            start: of NumPy arrays: (x/z, y/z) near the answer, if it is known.
        """

    @abstractmethod
    def field(self, coefficients: Coefficients) -> float:
        """The largest angle off the axis, in radians, up to which the model is one to one."""

    def flat_radius(self, coefficients: Coefficients) -> float:
        """`field` as hypot(x/z, y/z), FLAT_LIMIT at most."""
        field = self.field(coefficients)
        return FLAT_LIMIT if field >= np.arctan(FLAT_LIMIT) else float(np.tan(field))

    def magnification(self, coefficients: Coefficients) -> float:
        """How far an image point moves on the axis with an angle in radians; 1, but of spheres."""
        return 1.0


def in_kind(points: Any, coefficients: Any) -> tuple[ModuleType, Any]:
    """`numpy` and float64, or `jax.numpy` and float32, if any of the two is of JAX."""
    if is_host(points, coefficients):
        return np, np.asarray(points, float)
    return jnp, jnp.asarray(points, jnp.float32)


def unit(x: Any, y: Any, z: Any, seen: Any) -> Any:
    """Unit vectors, NaN where nothing is seen."""
    xp = namespace(x, y, z)
    length = xp.sqrt(x * x + y * y + z * z)
    return xp.where(seen[..., None], xp.stack([x, y, z], axis=-1) / length[..., None], xp.nan)
