"""The View: the pair of rectified cameras."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._arrays import AnyArray, Mat3, namespace, register_pytree
from stereorecal._errors import InputError, checked_choice
from stereorecal.geometry._rig import StereoRig, checked_rig
from stereorecal.geometry._so3 import rectifying_rotations
from stereorecal.geometry.projections import Projection, projection as projection_of

PINHOLE, EQUIRECTANGULAR = "pinhole", "equirectangular"
_ARGUMENTS = ("projection", "field", "zero_disparity")
# Of the focal lengths of the cameras: a pinhole view of a wider field shrinks the middle away, and one that magnifies
# more shows nothing but pixels.
_LEAST_ZOOM, _MOST_ZOOM = 0.7, 4.0


@register_pytree
@dataclass(frozen=True, eq=False)
class View:
    """The rectified cameras: one projection, one focal length, common rows, and a centre column for each side. Epipolar
    planes are rows of it, whatever the projection.

    All counts that are compared with each other must use one View: a zoom that follows the candidate lets it win
    by showing fewer pixels.

    Attributes:
        size: (width, height) of the rectified images in pixels.
        focal: focal length in pixels of both rectified cameras: pixels a radian in the middle.
        centre_left, centre_right: principal columns in pixels; equal when infinity has disparity 0.
        centre_row: principal row in pixels.
        projection: "pinhole", or "equirectangular": columns and rows are angles about the baseline.
    """

    size: tuple[int, int] = field(metadata={"static": True})
    focal: float | Float[AnyArray, ""]
    centre_left: float | Float[AnyArray, ""]
    centre_right: float | Float[AnyArray, ""]
    centre_row: float | Float[AnyArray, ""]
    projection: str = field(default=PINHOLE, metadata={"static": True})

    def __post_init__(self) -> None:
        projection_of(self.projection)

    @property
    def formulas(self) -> Projection:
        """The functions of its projection."""
        return projection_of(self.projection)

    @property
    def degrees(self) -> float:
        """How much it shows across, in degrees."""
        x, _, z = self.formulas.directions(0.5 * self.size[0] / float(self.focal), 0.0)
        return float(np.degrees(2.0 * np.arctan2(x, z)))

    @property
    def at_infinity(self) -> float | Float[AnyArray, ""]:
        """The disparity of what is infinitely far away, in pixels."""
        return self.centre_left - self.centre_right

    @property
    def matrix_left(self) -> Mat3:
        """(3, 3) from image points of the projection to pixels of the left image: a pinhole's camera matrix."""
        return self._matrix(self.centre_left)

    @property
    def matrix_right(self) -> Mat3:
        """(3, 3) the same of the right image."""
        return self._matrix(self.centre_right)

    def _matrix(self, centre) -> Mat3:
        xp = namespace(self.focal, centre, self.centre_row)
        zero, one = 0.0 * self.focal, 0.0 * self.focal + 1.0
        rows = [[self.focal, zero, centre], [zero, self.focal, self.centre_row], [zero, zero, one]]
        return xp.stack([xp.stack([xp.asarray(v) for v in row]) for row in rows])

    def scaled(self, scale: float) -> "View":
        """The same view at `scale` times the resolution."""
        size = (round(self.size[0] * scale), round(self.size[1] * scale))
        left, right, row = ((c + 0.5) * scale - 0.5 for c in (self.centre_left, self.centre_right, self.centre_row))
        return View(size, self.focal * scale, left, right, row, self.projection)

    def directions(self, columns: AnyArray, rows: AnyArray, side: int) -> Float[AnyArray, "*n 3"]:
        """Directions in the rectified frame of pixels of one image, of any shape: (x, y, 1) of a pinhole, else unit
        vectors.

        Args:
            columns, rows: of one shape.
            side: 0 for the left image, 1 for the right one.
        """
        xp = namespace(columns, self.focal)
        u = (columns - (self.centre_left, self.centre_right)[side]) / self.focal
        x, y, z = self.formulas.directions(u, (rows - self.centre_row) / self.focal)
        return xp.stack([x, y, z + 0.0 * x], axis=-1)

    def pixels(self, directions: Float[AnyArray, "*n 3"], side: int) -> tuple[AnyArray, AnyArray]:
        """Columns and rows [px], `(*n,)` each, of directions of any length in the rectified frame; for a pinhole z > 0.

        Args:
            side: of the image: 0 left, 1 right.
        """
        u, v = self.formulas.project(*(directions[..., axis] for axis in range(3)))
        return self.focal * u + (self.centre_left, self.centre_right)[side], self.focal * v + self.centre_row

    def shows(self, columns: AnyArray, rows: AnyArray, side: int) -> Bool[AnyArray, "*n"] | bool:
        """Whether pixels of one image are those of directions, and not beyond the poles of the projection."""
        u = (columns - (self.centre_left, self.centre_right)[side]) / self.focal
        return self.formulas.shows(u, (rows - self.centre_row) / self.focal)

    def nearness(self, columns: AnyArray, disparity: AnyArray) -> Float[AnyArray, "*n"]:
        """Baselines over the distance of points, which is counted in lengths of their `directions`: of a pinhole the
        depth z, else the distance from the left camera. Zero or less where nothing lies before infinity.

        Args:
            columns: of the left image.
            disparity: column in the left image less that in the right one, in pixels.
        """
        left, right = columns - self.centre_left, columns - disparity - self.centre_right
        return self.formulas.nearness(left / self.focal, right / self.focal)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "projection": self.projection,
            "size": list(self.size),
            "degrees": self.degrees,
            "focal_px": float(self.focal),
        }

    def __str__(self) -> str:
        width, height = self.size
        kind = f"{self.projection}, {self.degrees:.0f} degrees across"
        return f"{width} x {height} pixels, {kind}, focal length {float(self.focal):.3f} px"


def view(
    rig: StereoRig, *, zero_disparity: bool = True, field: float | None = None, projection: str | None = None
) -> View:
    """The default View of a rig, at the size of its left image: a pinhole, or equirectangular, where wide lenses show
    more than a pinhole can at 0.7 times their mean focal length (docs/conventions.md). Projection and focal length
    depend on the intrinsics alone, so no zoom follows the extrinsics.

    Centre: the image centres of both cameras, undistorted and rotated into the rectified frame, project on average to
    the centre of the view; with `zero_disparity` both share one principal column (points at infinity have disparity 0),
    else each camera's own centre lies in the middle.

    Args:
        field: the width of the view in degrees, in place of the rule: up to 165 of a pinhole, up to 180 of
            "equirectangular".
        projection: "pinhole" or "equirectangular", as `View` has it, in place of the rule.

    Raises:
        InputError: if the field makes no sense, the projection is unknown, or no lens has such a focal length.
    """
    rig = checked_rig(rig)
    width, height = rig.left.size
    mean = float(np.prod([rig.left.focal, rig.right.focal]) ** 0.25)
    projection = _usual_projection(rig, mean, field) if projection is None else projection
    formulas = projection_of(projection)
    if field is None:
        if projection == _usual_projection(rig, mean, None) == PINHOLE:
            focal = float(np.clip(_shown_focal(rig), _LEAST_ZOOM * mean, mean))
        else:
            focal = max(mean, _focal_of_field(rig, projection, formulas.usual))
    elif 0.0 < field <= formulas.widest:
        focal = _focal_of_field(rig, projection, field)
    else:
        raise InputError(
            f"a field of {field:g} degrees makes no {projection} view; give more than 0 and at most "
            f"{formulas.widest:g}."
        )
    if focal > _MOST_ZOOM * mean:
        if field is None:
            raise InputError(
                f"a resolution of {mean:.3g} px per radian in images {width} px wide is that of no lens; correct the "
                "calibration."
            )
        raise InputError(f"a field of {field:g} degrees magnifies the images {focal / mean:.3g} times; give more.")
    rotations = rectifying_rotations(rig.rotation, rig.translation)
    columns, rows = [], []
    for camera, rotation in zip((rig.left, rig.right), rotations, strict=True):
        u, v = formulas.project(*(rotation @ np.asarray(camera.rays(camera.middle[None]))[0].astype(float)))
        columns.append(0.5 * (width - 1) - focal * u)
        rows.append(0.5 * (height - 1) - focal * v)
    if zero_disparity:
        columns = [float(np.mean(columns))] * 2
    return View((width, height), focal, float(columns[0]), float(columns[1]), float(np.mean(rows)), projection)


AnyView = View | Mapping[str, Any] | None
"""A View; the arguments of `sr.view` by name, such as {"field": 140}; or None: `sr.view(rig)`."""


def as_view(given: AnyView, rig: StereoRig) -> View:
    """The View that is meant, of a rig.

    Raises:
        InputError: if it is none, or its arguments make no sense.
    """
    if isinstance(given, View):
        return given
    if given is not None and not isinstance(given, Mapping):
        raise InputError(
            f"the view is a {type(given).__name__}; give an sr.View, such as sr.view(rig), or arguments of sr.view by "
            'name, such as {"field": 140}.'
        )
    return view(rig, **checked_view_arguments(given or {}))


def checked_view_arguments(given: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `view` by name.

    Raises:
        InputError: if one is unknown, or makes no sense for any rig.
    """
    for name in given:
        checked_choice(name, _ARGUMENTS, "argument of a view")
    projection, field, same_column = given.get("projection"), given.get("field"), given.get("zero_disparity", True)
    widest = projection_of(str(projection or EQUIRECTANGULAR)).widest
    number = isinstance(field, Real) and not isinstance(field, bool)
    if field is not None and not (number and 0.0 < float(field) <= widest):
        of_it = f" of {projection}" if projection else ""
        raise InputError(f"the field of a view is {field!r}; give degrees, more than 0 and at most {widest:g}{of_it}.")
    if not isinstance(same_column, bool):
        raise InputError(f"zero_disparity of a view is {same_column!r}; give True or False.")
    return dict(given)


def _usual_projection(rig: StereoRig, mean: float, field: float | None) -> str:
    """A pinhole, unless a rig of wide lenses shows more than that can show at its mean focal length."""
    if not rig.is_wide:
        return PINHOLE
    if field is None:
        needed = _shown_focal(rig)
    else:
        needed = _focal_of_field(rig, PINHOLE, field) if 0.0 < field < 180.0 else 0.0
    return PINHOLE if needed >= _LEAST_ZOOM * mean else EQUIRECTANGULAR


def _focal_of_field(rig: StereoRig, projection: str, field: float) -> float:
    return 0.5 * rig.left.size[0] / projection_of(projection).edge(0.5 * float(np.radians(field)))


def _shown_focal(rig: StereoRig) -> float:
    """Focal length of a pinhole that shows the middles of all borders of both images; of wide lenses, what both cameras
    see: the narrower one decides beside a fisheye."""
    focals = []
    for camera in (rig.left, rig.right):
        (cx, cy), (w, h) = camera.middle, camera.size
        rays = np.asarray(camera.rays(np.array([[cx, cy], [0, cy], [w - 1, cy], [cx, 0], [cx, h - 1]], float)), float)
        offset = np.abs(rays[1:, :2] - rays[0, :2])
        offset = np.where(np.isnan(offset), np.inf, offset)  # 90 degrees off the axis, and more
        focals.append(float(min(0.5 * w / offset[:2, 0].max(), 0.5 * h / offset[2:, 1].max())))
    return max(focals) if rig.is_wide else min(focals)
