"""What the module of a projection offers."""

from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Projection(Protocol):
    """A module with the functions of one projection, of both cameras of a view. Image points (u, v) are pixels less the
    principal point, over the focal length; directions (x, y, z) have any length, in the rectified frame, the baseline
    along x. A row v depends on y and z alone, so that epipolar planes are rows. All functions take NumPy arrays
    (float64) or JAX arrays (float32, traced, differentiable) and answer in kind; near the middle all projections are
    the same."""

    @property
    def NAME(self) -> str:
        """As `View.projection` has it."""
        ...

    @property
    def ABOUT(self) -> str:
        """The projection in a few words."""
        ...

    @property
    def WIDEST(self) -> float:
        """The largest field that a view may show across, in degrees."""
        ...

    @property
    def USUAL(self) -> float:
        """The largest field that a view shows unless more is asked for, in degrees."""
        ...

    def edge(self, angle: float) -> float:
        """The image point of a direction so many radians off the middle, along the columns."""
        ...

    def angle(self, edge: float) -> float:
        """The inverse of `edge`."""
        ...

    def directions(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """x, y and z of image points. Beyond what the projection shows, those of its edge."""
        ...

    def shows(self, u: Any, v: Any) -> Any:
        """Whether image points are those of directions; True if all are."""
        ...

    def project(self, x: Any, y: Any, z: Any) -> tuple[Any, Any]:
        """u and v of directions; analytic, so that complex steps differentiate it."""
        ...

    def row(self, y: Any, z: Any) -> Any:
        """v alone."""
        ...

    def row_slopes(self, y: Any, z: Any) -> tuple[Any, Any]:
        """The derivatives of `row` by y and by z."""
        ...

    def stretch(self, y: Any, z: Any, length: Any) -> Any:
        """By how much rows of directions, of a length, are wider apart than they are in the middle: by as much, what
        lies there has less disparity than it would have in the middle."""
        ...

    def length(self, x: Any, y: Any, z: Any) -> Any:
        """Of a vector, in lengths of `directions`; analytic as `project`."""
        ...

    def nearness(self, left: Any, right: Any) -> Any:
        """Baselines over the `length` from the left camera to the point that both cameras see at columns u, left and
        right. Zero or less: infinitely far away. Analytic as `project`."""
        ...
