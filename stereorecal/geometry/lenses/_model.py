"""What the module of a lens model offers."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray

# Rays (x/z, y/z, 1) go no farther from the axis: 83 degrees. A pinhole view of more shows next to nothing.
FLAT_LIMIT = 8.0


@runtime_checkable
class LensModel(Protocol):
    """A module with the functions of one model. Image points are pixels less the principal point, over the focal
    lengths. Directions have any length, in the camera's frame; each function takes NumPy arrays (float64) or JAX arrays
    (float32, traced, differentiable) and answers in kind."""

    @property
    def NAME(self) -> str:
        """As `Camera.model` has it."""
        ...

    @property
    def ABOUT(self) -> str:
        """The model and its coefficients, in a few words."""
        ...

    @property
    def TERMS(self) -> tuple[str, ...]:
        """Names of coefficients, in their order; without a unit. Those at the end may lack one: they cannot be free."""
        ...

    @property
    def CALIBRATED(self) -> tuple[str, ...]:
        """The terms that a calibration leaves uncertain."""
        ...

    @property
    def COUNTS(self) -> tuple[int, ...]:
        """How many coefficients there may be, rising."""
        ...

    @property
    def WIDE(self) -> bool:
        """Whether directions of 90 degrees off the axis and more can have an image."""
        ...

    def check(self, coefficients: Float[np.ndarray, "c"]) -> None:
        """Refuse what no lens has.

        Raises:
            InputError: if the coefficients are none of a lens.
        """
        ...

    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
        """Image points of directions, whose x, y and z come apart: pairs in memory cost four times the time. Analytic
        in all its arguments, so that complex steps differentiate it; several lenses broadcast against the directions.
        Without a meaning beyond `field`."""
        ...

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
        ...

    def magnification(self, coefficients: Float[np.ndarray, "c"]) -> float:
        """By how much an image point moves on the axis with an angle in radians."""
        ...

    def field(self, coefficients: Float[np.ndarray, "c"]) -> float:
        """The largest angle off the axis, in radians, up to which the model is one to one."""
        ...

    def flat_radius(self, coefficients: Float[np.ndarray, "c"]) -> float:
        """The same as hypot(x/z, y/z), FLAT_LIMIT at most."""
        ...
