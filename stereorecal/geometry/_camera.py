"""One camera: image size, camera matrix, lens."""

from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Mat3, is_host, namespace, register_pytree
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry._quarter_turns import turn_of, turned_coefficients, turned_pixels, turned_size
from stereorecal.geometry.lenses import LensModel, lens_model

_ROUNDING = 1e-6  # of single precision and of six printed digits, in parts of what stands beside
_LEAST_CIRCLE = 0.25  # of the shorter side of the image: the radius of an image circle
_INSIDE = 0.999  # of the field: some models project its end to infinity
_ALL_ROUND = 3.1  # radians off the axis: straight behind, a lens model has no direction


def whole_size(given: Any) -> tuple[int, int]:
    """(width, height) in whole pixels.

    Raises:
        InputError: if it is something else.
    """
    sides = np.asarray(given, object)
    whole = all(isinstance(side, Real) and float(side).is_integer() and float(side) >= 1.0 for side in sides.flat)
    if sides.shape != (2,) or not whole:
        raise InputError(f"the image size is {given!r}; give (width, height) in whole pixels.")
    return int(sides[0]), int(sides[1])


@register_pytree
@dataclass(frozen=True, eq=False)
class Camera:
    """A camera with a lens. Frame: x right, y down, z forward; pixel centres at integers.

    Attributes:
        size: (width, height) in pixels.
        matrix: (3, 3) float64, OpenCV's camera matrix, in pixels.
        distortion: (n,) float64, the coefficients of the model; of "radtan" n in 0, 4, 5, 8, 12, 14, in OpenCV's order.
        lens_radius: largest undistorted radius, hypot(x/z, y/z), that the lens model is good for, 8 at most (83
            degrees off the axis); derived from the distortion by default.
        lens_field: the same as an angle off the axis in radians, without that limit.
        model: "radtan" (OpenCV's pinhole model), "equidistant" (`cv2.fisheye`: k1 k2 k3 k4), "ds" (double sphere: xi
            alpha), "eucm" (extended unified: alpha beta) or "omni" (unified with distortion: xi k1 k2 p1 p2).

    Raises:
        InputError: if the matrix is transposed, singular, negative, skewed or not finite, the size is not of whole
            pixels, or the coefficients are none of a lens. Rounding of the matrix's zeros and one is taken out.
        UnsupportedModelError: if the model is not known, or has not so many coefficients.
    """

    size: tuple[int, int] = field(metadata={"static": True})
    matrix: Mat3
    distortion: Float[AnyArray, "n"] = field(default_factory=lambda: np.zeros(0))
    lens_radius: float | Float[AnyArray, ""] = float("nan")
    lens_field: float | Float[AnyArray, ""] = field(default=float("nan"), kw_only=True)
    model: str = field(default="radtan", kw_only=True, metadata={"static": True})

    def __post_init__(self) -> None:
        if not is_host(self.matrix, self.distortion):
            return
        matrix, distortion = np.array(self.matrix, float), np.array(self.distortion, float).reshape(-1)
        object.__setattr__(self, "size", whole_size(self.size))
        if not (np.isfinite(matrix).all() and np.isfinite(distortion).all()):
            raise InputError("the intrinsics contain NaN or infinite numbers; correct the calibration.")
        matrix = np.asarray(_exact_matrix(matrix))
        _check_plausible(self.size, matrix, distortion)
        lens = lens_model(self.model)
        if distortion.size not in lens.COUNTS:
            raise UnsupportedModelError(
                f"a distortion has {distortion.size} coefficients; this lens model takes others: {lens.ABOUT}."
            )
        lens.check(distortion)
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "distortion", distortion)
        if np.isnan(self.lens_radius):
            object.__setattr__(self, "lens_radius", np.float64(lens.flat_radius(distortion)))
        if np.isnan(self.lens_field):
            object.__setattr__(self, "lens_field", np.float64(lens.field(distortion)))
        if lens.WIDE:
            _check_image_circle(self)

    @property
    def lens(self) -> LensModel:
        """The functions of its model."""
        return lens_model(self.model)

    @property
    def focal(self) -> Float[np.ndarray, "2"]:
        """Pixels that a radian takes in the middle of the image, along x and y: the resolution there. The focal lengths
        of the matrix, but of double spheres and omni lenses."""
        return self.lens.magnification(np.asarray(self.distortion)) * np.asarray(self.matrix)[(0, 1), (0, 1)]

    @property
    def middle(self) -> Float[np.ndarray, "2"]:
        """The middle of the image, in pixels."""
        return 0.5 * (np.array(self.size, float) - 1.0)

    def resized(self, size: tuple[int, int]) -> "Camera":
        """The camera of the same image resampled to `size` (area convention: pixel corners stay corners).

        Raises:
            InputError: if the size is not of whole pixels.
        """
        size = whole_size(size)
        scale = np.array([size[0] / self.size[0], size[1] / self.size[1], 1.0])
        matrix = self.matrix * scale[:, None]
        centre = (np.asarray(self.matrix)[:2, 2] + 0.5) * scale[:2] - 0.5
        matrix[:2, 2] = centre
        return replace(self, size=size, matrix=matrix)

    def turned(self, quarters: int) -> "Camera":
        """The camera of the same image turned counter-clockwise by so many quarters, as `np.rot90(image, quarters)`.

        Raises:
            InputError: if its sensor is tilted about both axes, and the turn is no half one.
        """
        matrix = np.asarray(self.matrix, float).copy()
        matrix[(0, 1), (0, 1)] = np.abs(turn_of(quarters)[:2, :2]) @ matrix[(0, 1), (0, 1)]
        matrix[:2, 2] = turned_pixels(matrix[:2, 2], self.size, quarters)
        distortion = turned_coefficients(np.asarray(self.distortion), self.lens.TERMS, quarters)
        return replace(self, size=turned_size(self.size, quarters), matrix=matrix, distortion=distortion)

    def cropped(self, size: tuple[int, int], corner: tuple[int, int] | None = None) -> "Camera":
        """The camera of the same image cut to `size`: the focal lengths stay, and the principal point moves.

        Args:
            corner: (column, row) of the first pixel that is left; default: as much is cut from both sides (where that
                is an odd number, one more from the end).

        Raises:
            InputError: if the size is not of whole pixels, or what is left is not inside the image.
        """
        size = whole_size(size)
        spare = np.array(self.size) - size
        start = spare // 2 if corner is None else np.array(corner)
        if start.shape != (2,) or start.dtype.kind not in "iu" or (start < 0).any() or (start > spare).any():
            raise InputError(
                f"{size[0]}x{size[1]} pixels{'' if corner is None else f' from {corner!r} on'} cannot be cut out of an "
                f"image of {self.size[0]}x{self.size[1]}; give another size or corner, or, for scaled images, resized."
            )
        matrix = np.array(self.matrix, float)
        matrix[:2, 2] -= start
        return replace(self, size=size, matrix=matrix)

    def project(self, points: Float[AnyArray, "*n 3"]) -> Float[AnyArray, "*n 2"]:
        """Points in the camera frame (any unit; z > 0, unless the lens is wide) to pixels."""
        xp = namespace(points, self.distortion)
        x, y, z = points[..., :1], points[..., 1:2], points[..., 2:]  # arrays, of one point too
        image = xp.concatenate(self.lens.project(x, y, z, self.distortion), axis=-1)
        focal = self.matrix[(0, 1), (0, 1)]
        return image * focal + self.matrix[:2, 2]

    def rays(
        self, pixels: Float[AnyArray, "*n 2"], start: Float[np.ndarray, "*n 2"] | None = None
    ) -> Float[AnyArray, "*n 3"]:
        """Pixels to rays (x/z, y/z, 1) in the camera frame; float64 for NumPy arrays, else float32. NaN where a wide
        lens looks 90 degrees off its axis and more; `directions` has no such limit.

        Args:
            start: of NumPy arrays: (x/z, y/z) near the answer, if it is known.
        """
        points = (pixels - self.matrix[:2, 2]) / self.matrix[(0, 1), (0, 1)]
        found = self.lens.unproject(points, self.distortion, start)
        if not self.lens.WIDE:
            return found
        xp, z = namespace(found), found[..., 2:]
        return xp.where(z > _FLATTEST, found / xp.where(z > _FLATTEST, z, 1.0), xp.nan)

    def directions(self, pixels: Float[AnyArray, "*n 2"]) -> Float[AnyArray, "*n 3"]:
        """Pixels to unit vectors in the camera frame; float64 for NumPy arrays, else float32. NaN where the lens shows
        nothing."""
        found = self.lens.unproject((pixels - self.matrix[:2, 2]) / self.matrix[(0, 1), (0, 1)], self.distortion)
        xp = namespace(found)
        return found / xp.sqrt(xp.sum(found * found, axis=-1, keepdims=True))


_FLATTEST = 1e-3  # cosine of the angle off the axis: beyond, a ray (x/z, y/z, 1) has no meaning


# Beyond these no lens is, and nothing that is computed of one has a meaning.
_SHORTEST, _LONGEST = 0.01, 200.0  # focal lengths, in sizes of the image: 179 degrees, and telescopes
_FARTHEST = 20.0  # principal point from the image, in sizes of the image
_STRONGEST = 1e6  # distortion of a corner, in sizes of the image


def _check_image_circle(camera: Camera) -> None:
    """Refuse a wide lens whose model ends far within the image, where a wrong coefficient folds it back."""
    end = _INSIDE * min(camera.lens.field(np.asarray(camera.distortion)), _ALL_ROUND)
    aside, _ = camera.project(np.array([np.sin(end), 0.0, np.cos(end)])) - np.asarray(camera.matrix)[:2, 2]
    if not aside >= _LEAST_CIRCLE * min(camera.size):
        raise InputError(
            f"the image of the {camera.model} lens ends {np.degrees(end):.0f} degrees off its axis, "
            f"{abs(aside):.0f} px from the principal point, by its coefficients; correct the calibration."
        )


def _check_plausible(size: tuple[int, int], matrix: np.ndarray, distortion: np.ndarray) -> None:
    across = max(size)
    focal = matrix[(0, 1), (0, 1)]
    if focal.min() < _SHORTEST * across or focal.max() > _LONGEST * across:
        raise InputError(
            f"focal lengths of {focal[0]:.4g} and {focal[1]:.4g} pixels do not fit a camera with {across} pixels; "
            "correct the calibration, or its image size."
        )
    if np.abs(matrix[:2, 2]).max() > _FARTHEST * across:
        raise InputError(
            f"the principal point {matrix[0, 2]:.4g}, {matrix[1, 2]:.4g} lies far outside of the image; correct the "
            "calibration, or its image size."
        )
    if np.abs(distortion).max(initial=0.0) * min(1.0, across / focal.max()) ** 2 > _STRONGEST:
        raise InputError(
            f"no lens distorts so much (coefficients up to {np.abs(distortion).max():.3g}); check their order and the "
            "distortion model."
        )


def _exact_matrix(matrix: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, "3 3"]:
    """[[fx 0 cx] [0 fy cy] [0 0 1]] of a finite matrix whose zeros and one may be rounded; what is none, refused."""
    focal = np.abs(matrix[(0, 1), (0, 1)])
    rest, tolerance = matrix[2] - np.array([0.0, 0.0, 1.0]), _ROUNDING * max(1.0, focal.max())
    if min(matrix[0, 0], matrix[1, 1]) > 0 and not np.any(matrix[:2, 2]) and np.abs(matrix[2, :2]).min() > 1.0:
        raise InputError(
            "the camera matrix is transposed, [[fx 0 0] [0 fy 0] [cx cy 1]], as MATLAB's IntrinsicMatrix; give its "
            "transpose (K.T). If it is MATLAB's, transpose the rotation as well, and subtract 1 from cx and cy, since "
            "MATLAB counts pixels from 1."
        )
    if (
        min(matrix[0, 0], matrix[1, 1]) > 0
        and not np.any(matrix[2, :2])
        and abs(rest[2]) > _ROUNDING
        and matrix[2, 2] > 0
    ):
        raise InputError(
            f"the last number of the camera matrix is {matrix[2, 2]:g}, and must be 1: divide the matrix by it, or "
            "correct the calibration."
        )
    if min(matrix[0, 0], matrix[1, 1]) <= 0 or np.abs(rest).max() > _ROUNDING:
        raise InputError(
            "the camera matrix is singular or negative; it must be [[fx 0 cx] [0 fy cy] [0 0 1]] with positive "
            "focal lengths: correct the calibration."
        )
    if max(abs(matrix[0, 1]), abs(matrix[1, 0])) > tolerance:
        raise InputError("the camera matrix has skew, which is not supported; recalibrate without skew.")
    fx, fy, cx, cy = matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def same_camera(one: Camera, other: Camera, rounding: float = 0.0) -> bool:
    """Whether two cameras have equal intrinsics but for rounding, a share of each number or of 1; coefficients that a
    model lacks are 0."""
    if one is other:
        return True
    if one.model != other.model or not np.allclose(one.matrix, other.matrix, rtol=rounding, atol=rounding):
        return False
    length = max(one.distortion.size, other.distortion.size)
    lenses = [np.pad(np.asarray(c.distortion), (0, length - c.distortion.size)) for c in (one, other)]
    return np.allclose(*lenses, rtol=rounding, atol=rounding)
