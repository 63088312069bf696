"""Rectifying rotations (as `cv2.stereoRectify`) and the View: the pair of rectified cameras."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Mat3, Vec3, namespace
from stereorecal._errors import InputError
from stereorecal._pytree import register_pytree
from stereorecal.geometry._camera import Camera
from stereorecal.geometry._rig import StereoRig
from stereorecal.geometry._so3 import rotation_between, rotation_from_vector, vector_from_rotation

_TINY = 1e-30
_WIDEST = 165.0  # degrees


def rectifying_rotations(rotation: Mat3, translation: Vec3) -> tuple[Mat3, Mat3]:
    """R1, R2 (3, 3): left and right camera frame to the rectified frame, as `cv2.stereoRectify`'s.

    Each camera takes half of the rotation between them (Bouguet's method), then both turn by the smallest rotation
    that lays the baseline along x. Only the direction of `translation` matters.
    """
    xp = namespace(rotation, translation)
    half = rotation_from_vector(-0.5 * vector_from_rotation(rotation))
    baseline = half @ translation
    baseline = baseline / xp.sqrt(xp.sum(baseline * baseline))
    along_x = rotation_between(baseline, xp.asarray([-1.0, 0.0, 0.0], dtype=baseline.dtype))
    return along_x @ half.T, along_x @ half


def rectifying_slopes(
    rotation: Float[np.ndarray, "3 3"],
    translation: Float[np.ndarray, "3"],
    by_rotation: Float[np.ndarray, "m 3 3"],
    by_translation: Float[np.ndarray, "m 3"],
) -> Float[np.ndarray, "m 2 3 3"]:
    """Derivatives of `rectifying_rotations`, left and right, where R and T move so.

    Of R with angle a about n, the antisymmetric part K is sin(a) [n] and the trace 1 + 2 cos(a), so half of it back is
    an algebraic function of R, and complex steps (Squire & Trapp 1998) are exact.
    """
    rotation, translation = rotation + _TINY * 1j * by_rotation, translation + _TINY * 1j * by_translation
    back, identity = 0.5 * (rotation - rotation.swapaxes(1, 2)), np.eye(3)
    cosine = 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0)
    of_half = np.sqrt(0.5 * (1.0 + cosine))[:, None, None]
    half = identity - back / (2.0 * of_half) + back @ back / (4.0 * of_half**2 * (1.0 + of_half))
    baseline = (half @ translation[..., None])[..., 0]
    baseline = baseline / np.sqrt((baseline * baseline).sum(axis=1))[:, None]
    turn = np.zeros_like(rotation)
    turn[:, 1:, 0], turn[:, 0, 1:] = baseline[:, 1:], -baseline[:, 1:]
    along_x = identity + turn + turn @ turn / (1.0 - baseline[:, :1, None])
    return np.imag(np.stack([along_x @ half.swapaxes(1, 2), along_x @ half], axis=1)) / _TINY


@register_pytree
@dataclass(frozen=True, eq=False)
class View:
    """The rectified cameras: one focal length, common rows, and a centre column for each side.

    All counts that are compared with each other must use one View: a zoom that follows the candidate lets it win
    by showing fewer pixels.

    Attributes:
        size: (width, height) of the rectified images in pixels.
        focal: focal length in pixels of both rectified cameras.
        centre_left, centre_right: principal columns in pixels; equal when infinity has disparity 0.
        centre_row: principal row in pixels.
    """

    size: tuple[int, int] = field(metadata={"static": True})
    focal: float | Float[AnyArray, ""]
    centre_left: float | Float[AnyArray, ""]
    centre_right: float | Float[AnyArray, ""]
    centre_row: float | Float[AnyArray, ""]

    @property
    def matrix_left(self) -> Mat3:
        """(3, 3) camera matrix of the left rectified camera."""
        return self._matrix(self.centre_left)

    @property
    def matrix_right(self) -> Mat3:
        """(3, 3) camera matrix of the right rectified camera."""
        return self._matrix(self.centre_right)

    def _matrix(self, centre) -> Mat3:
        xp = namespace(self.focal, centre, self.centre_row)
        zero, one = 0.0 * self.focal, 0.0 * self.focal + 1.0
        rows = [[self.focal, zero, centre], [zero, self.focal, self.centre_row], [zero, zero, one]]
        return xp.stack([xp.stack([xp.asarray(v) for v in row]) for row in rows])

    def scaled(self, scale: float) -> "View":
        """The same view at `scale` times the resolution."""
        size = (round(self.size[0] * scale), round(self.size[1] * scale))
        centres = [(c + 0.5) * scale - 0.5 for c in (self.centre_left, self.centre_right, self.centre_row)]
        return View(size, self.focal * scale, *centres)


def view(rig: StereoRig, *, zero_disparity: bool = True, field: float | None = None) -> View:
    """The default View of a rig, at the size of its left image.

    Focal length: as long as keeps the middles of all four borders of both undistorted images inside, but between
    0.7 and 1 times the mean focal length of the cameras, so that nothing is magnified and wide lenses do not shrink
    the middle away; of fisheyes and other wide models 1, the widest that keeps the resolution of the middle. Centre:
    the image centres of both cameras, undistorted and rotated into the rectified frame, project on average to the
    centre of the view; with `zero_disparity` both share one principal column (points at infinity have disparity 0),
    else each camera's own centre lies in the middle.

    The focal length depends on the intrinsics alone, so no zoom follows the extrinsics.

    The view is a pinhole's: it shows 97 degrees of a fisheye of 130, and 118 of one of 190. More of the field costs
    resolution in the middle.

    Args:
        field: the width of the view in degrees, below 165, in place of the focal length above.

    Raises:
        InputError: if the field makes no sense.
    """
    width, height = rig.left.size
    mean_focal = float(np.prod([rig.left.focal, rig.right.focal]) ** 0.25)
    edge_focal = min(_edge_focal(camera) for camera in (rig.left, rig.right))
    wide = rig.left.lens.WIDE or rig.right.lens.WIDE
    focal = float(np.clip(edge_focal, (1.0 if wide else 0.7) * mean_focal, mean_focal))
    if field is not None:
        if not 0.0 < field < _WIDEST:
            raise InputError(
                f"a field of {field:g} degrees makes no pinhole view; give more than 0 and less than {_WIDEST:g}."
            )
        focal = 0.5 * width / float(np.tan(0.5 * np.radians(field)))
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    columns, rows = [], []
    for camera, rotation in zip((rig.left, rig.right), rotations, strict=True):
        ray = rotation @ np.asarray(camera.rays(_image_centre(camera)[None]))[0].astype(float)
        columns.append(0.5 * (width - 1) - focal * ray[0] / ray[2])
        rows.append(0.5 * (height - 1) - focal * ray[1] / ray[2])
    if zero_disparity:
        columns = [float(np.mean(columns))] * 2
    return View((width, height), focal, float(columns[0]), float(columns[1]), float(np.mean(rows)))


def _image_centre(camera: Camera) -> Float[np.ndarray, "2"]:
    return 0.5 * (np.array(camera.size, float) - 1.0)


def _edge_focal(camera: Camera) -> float:
    """Focal length at which the middle of the nearest border of this camera's image lies on the view's border."""
    (cx, cy), (w, h) = _image_centre(camera), camera.size
    pixels = np.array([[cx, cy], [0, cy], [w - 1, cy], [cx, 0], [cx, h - 1]], float)
    rays = np.asarray(camera.rays(pixels), float)
    offset = np.abs(rays[1:, :2] - rays[0, :2])
    offset = np.where(np.isnan(offset), np.inf, offset)  # 90 degrees off the axis, and more
    horizontal, vertical = offset[:2, 0].max(), offset[2:, 1].max()
    return float(min(0.5 * w / horizontal, 0.5 * h / vertical))
