"""The stereo rig: two cameras and the six extrinsic parameters between them; and a rig as plain data."""

import warnings
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics, Mat3, Vec3, is_host, namespace, register_pytree
from stereorecal._errors import CalibrationWarning, InputError, checked_choice
from stereorecal.geometry._camera import Camera
from stereorecal.geometry._quarter_turns import UPRIGHT, Turns, turn_of, turned_size, turns_of
from stereorecal.geometry._so3 import euler_from_rotation, rotation_from_euler
from stereorecal.geometry._units import METRES, doubt_of_length

_FROM_ROTATION = (
    "write sr.StereoRig.from_rotation(left, right, R, T), or sr.StereoRig.from_matrices(K1, D1, K2, D2, R, T, size), "
    "with T in metres."
)
AS_IN_FILE = "as in its file"
"""The source of a rig whose cameras stand as a file has them, where the right one may come first; nothing but the
readers and writers of files sees such a rig."""
AXES = ("pitch", "yaw", "roll", "x", "y", "z")


@register_pytree
@dataclass(frozen=True, eq=False)
class StereoRig:
    """Two cameras and `x_right = R x_left + T` (paper, eq. 1).

    Attributes:
        left, right: the cameras.
        extrinsics: (6,) float64: pitch, yaw, roll [rad], x, y, z [m];
            `R = Rz(roll) Ry(yaw) Rx(pitch)`, `T = (x, y, z)`. Kept exactly as given.
        turns: by how many quarters, counter-clockwise, left and right images are turned before they are images of these
            cameras: not (0, 0) in what `side_by_side` makes of a rig one above the other, or with a camera upside down.
            What takes a rig and pairs turns both.
        source: what the reader of a file keeps for the writer; None otherwise, and in what JAX makes of a rig.

    Raises:
        InputError: if the extrinsics are not finite, the baseline is zero, the cameras are exchanged
            (x > 0) or stand one behind the other.
    """

    left: Camera
    right: Camera
    extrinsics: Extrinsics
    turns: Turns = field(default=UPRIGHT, kw_only=True, metadata={"static": True})
    source: Any = field(default=None, kw_only=True, repr=False, metadata={"aside": True})

    def __new__(cls, *values: Any, **named: Any) -> "StereoRig":
        """Show those who bring R and T the right call."""
        if {"R", "T"} & set(named) or len(values) == 4:
            raise InputError(_FROM_ROTATION)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        if not is_host(self.extrinsics):
            return
        extrinsics = _as_numbers(self.extrinsics)
        if extrinsics.shape != (6,) or not np.isfinite(extrinsics).all():
            raise InputError(
                "the extrinsics must be six finite numbers (pitch, yaw, roll [rad], x, y, z [m]); correct them, or, if "
                f"you have a rotation and a translation: {_FROM_ROTATION}"
            )
        object.__setattr__(self, "extrinsics", extrinsics)
        if not np.any(extrinsics[3:]):
            raise InputError("the baseline is zero: the translation T from left to right must not vanish; correct it.")
        if self.source is AS_IN_FILE:
            return
        x, y, z = turn_of(self.turns_wanted[1]) @ extrinsics[3:]
        if x >= 0 and abs(x) >= max(abs(y), abs(z)):
            raise InputError(
                "left and right are exchanged: T[0] must be negative (x_right = R x_left + T); exchange them back."
            )
        if abs(x) <= max(abs(y), abs(z)):
            raise InputError(
                "the cameras stand neither side by side (|T[0]| largest) nor one above the other (|T[1]| largest); "
                "other rigs are not supported."
            )

    @staticmethod
    def from_rotation(left: Camera, right: Camera, rotation: Mat3, translation: Vec3) -> "StereoRig":
        """A rig from R (3, 3) and T (3,) [m] with `x_right = R x_left + T`; any length is taken, without a warning.

        Raises:
            InputError: if R is not a rotation (orthonormal to 1e-3, determinant +1), or a shape is another.
        """
        return StereoRig(left, right, extrinsics_of(rotation, translation))

    @staticmethod
    def from_matrices(
        K1: Float[AnyArray, "..."],  # a Mat3, as an InputError says otherwise
        D1: Float[AnyArray, "..."] | None,
        K2: Float[AnyArray, "..."],
        D2: Float[AnyArray, "..."] | None,
        R: Mat3,
        T: Float[AnyArray, "..."],
        size: tuple[int, int],
        *,
        unit: str = "m",
        model: str = Camera.model,
    ) -> "StereoRig":
        """A rig from what `cv2.stereoCalibrate`, or, with another model, `cv2.fisheye.stereoCalibrate` returns.

        Args:
            K1, K2: (3, 3) camera matrices of the left and the right camera, in pixels.
            D1, D2: distortion coefficients in OpenCV's order, of any shape; None for none, but of "radtan" only.
            R, T: (3, 3) and three numbers, with `x_right = R x_left + T`.
            size: (width, height) of the images in pixels.
            unit: of T, which is that of the chessboard's squares: "m", "cm", "mm" or "in".
            model: of both lenses, as `Camera` has it: "equidistant" for `cv2.fisheye`.

        Raises:
            InputError: as `Camera`, `StereoRig` and `from_rotation`; or if a matrix has another shape, as where K and D
                are exchanged.

        Warns:
            CalibrationWarning: if the baseline is longer than 5 m or shorter than 5 mm, as of a T in another unit.
        """
        checked_choice(unit, METRES, "unit")
        for name, K in (("K1", K1), ("K2", K2)):
            if np.shape(K) != (3, 3):
                raise InputError(
                    f"{name} has the shape {np.shape(K)}, and a camera matrix (3, 3); give K1, D1, K2, D2, R, T, size "
                    "in this order."
                )
        left, right = (
            Camera(size, np.asarray(K), np.zeros(0) if D is None else np.ravel(D), model=model)
            for K, D in ((K1, D1), (K2, D2))
        )
        translation = np.ravel(np.asarray(T, float))
        if translation.shape != (3,) or np.shape(R) != (3, 3):
            raise InputError(f"R and T have shapes {np.shape(R)} and {np.shape(T)}; give (3, 3) and three numbers.")
        rig = StereoRig.from_rotation(left, right, R, translation * METRES[unit])
        doubt = doubt_of_length(float(rig.baseline), unit)
        if doubt is not None:
            warnings.warn(doubt, CalibrationWarning, stacklevel=2)
        return rig

    @property
    def R(self) -> Mat3:
        """R, (3, 3): another name of `rotation`."""
        return self.rotation

    @property
    def T(self) -> Vec3:
        """T, (3,) [m]: another name of `translation`. OpenCV 5 wants a column, `rig.T[:, None]`."""
        return self.translation

    @property
    def rotation(self) -> Mat3:
        """R, (3, 3)."""
        return rotation_from_euler(self.extrinsics[:3])

    @property
    def translation(self) -> Vec3:
        """T, (3,) [m]."""
        return self.extrinsics[3:]

    @property
    def baseline(self):
        """|T| [m]."""
        xp = namespace(self.extrinsics)
        return xp.sqrt(xp.sum(self.extrinsics[3:] ** 2))

    @property
    def sizes_taken(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """(width, height) of the left and of the right image as they were taken, before `turns`."""
        left, right = self.turns
        return turned_size(self.left.size, left), turned_size(self.right.size, right)

    @property
    def is_wide(self) -> bool:
        """Whether a camera has a lens model for wide lenses."""
        return self.left.lens.WIDE or self.right.lens.WIDE

    def with_extrinsics(self, extrinsics: Extrinsics) -> "StereoRig":
        """The same cameras with other extrinsics (6,), float64 kept exactly."""
        return replace(self, extrinsics=extrinsics)

    def resized(self, size: tuple[int, int]) -> "StereoRig":
        """The rig whose images are resampled to `size` (width, height); `cropped` is for images that are cut."""
        return replace(self, left=self.left.resized(size), right=self.right.resized(size))

    def turned(self, turns: Turns) -> "StereoRig":
        """The rig whose left and right images are turned counter-clockwise by so many quarters more."""
        if turns == UPRIGHT:
            return self
        to_left, to_right = map(turn_of, turns)
        angles = euler_from_rotation(to_right @ np.asarray(self.rotation) @ to_left.T)
        return replace(
            self,
            left=self.left.turned(turns[0]),
            right=self.right.turned(turns[1]),
            extrinsics=np.concatenate([angles, to_right @ np.asarray(self.translation)]),
            turns=((self.turns[0] + turns[0]) % 4, (self.turns[1] + turns[1]) % 4),
        )

    @property
    def turns_wanted(self) -> Turns:
        """The quarters by which the images must be turned to be those of a left and a right camera."""
        x, y, z = np.abs(self.extrinsics[3:])
        if self.extrinsics[3] < 0.0 and x > max(y, z) and abs(self.extrinsics[2]) < np.pi / 2.0:
            return UPRIGHT
        return turns_of(self.rotation, self.translation)

    def side_by_side(self) -> "StereoRig":
        """The rig whose images are turned so that they are those of a left and a right camera, of which all that
        matches images knows; itself, if it stands so."""
        return self.turned(self.turns_wanted) if is_host(self.extrinsics) else self

    def as_taken(self) -> "StereoRig":
        """The rig of the images as they were taken, before `turns`; the inverse of `side_by_side`."""
        left, right = self.turns
        return self if self.turns == UPRIGHT else replace(self, source=AS_IN_FILE).turned((-left, -right))

    def cropped(self, size: tuple[int, int], corner: tuple[int, int] | None = None) -> "StereoRig":
        """The rig whose images are cut to `size` (width, height), as `Camera.cropped` cuts each."""
        return replace(self, left=self.left.cropped(size, corner), right=self.right.cropped(size, corner))


def extrinsics_of(rotation: Mat3, translation: Vec3) -> Extrinsics:
    """The extrinsics (6,) of R (3, 3) and T (3,).

    Raises:
        InputError: as `StereoRig.from_rotation`.
    """
    if np.shape(rotation) != (3, 3) or np.size(translation) != 3:
        raise InputError(
            f"R and T have shapes {np.shape(rotation)} and {np.shape(translation)}; give (3, 3), such as "
            "cv2.Rodrigues(rvec)[0], and three numbers."
        )
    rotation = np.array(rotation, float)
    if not np.isfinite(rotation).all():
        raise InputError("the rotation R contains NaN or infinite numbers; correct the calibration.")
    too_large = np.abs(rotation).max() > 2.0  # whose square may overflow
    if too_large or np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-3 or np.linalg.det(rotation) < 0:
        raise InputError("R is not a rotation (orthonormal, determinant +1); correct the calibration.")
    # Files carry R with few digits: take the nearest rotation.
    u, _, vt = np.linalg.svd(rotation)
    angles = euler_from_rotation(u @ vt)
    return np.concatenate([angles, np.array(translation, float).reshape(3)])


def with_unit_baseline(extrinsics: Extrinsics) -> Float[np.ndarray, "6"]:
    """The extrinsics (6,), float64, with the translation as a unit vector: what images can tell of it."""
    extrinsics = np.asarray(extrinsics, float)
    return np.concatenate([extrinsics[:3], extrinsics[3:] / np.linalg.norm(extrinsics[3:])])


def _as_numbers(value: Any) -> Float[np.ndarray, "..."]:
    """An array of float64; an empty one if it cannot be one, as a tuple of R and T."""
    try:
        return np.array(value, float)
    except (TypeError, ValueError):
        return np.zeros(0)


def checked_rig(given: Any, name: str = "the rig") -> StereoRig:
    """The rig that is given, side by side.

    Raises:
        InputError: if it is none; of a result that has one, it says how to get it.
    """
    if isinstance(given, StereoRig):
        return given.side_by_side()
    own = "its .rig, or " if hasattr(type(given), "rig") or "rig" in getattr(given, "__dict__", ()) else ""
    raise InputError(
        f"{name} is a {type(given).__name__}; give {own}an sr.StereoRig, such as scene.rig, sr.io.load_rig(path) or "
        "sr.StereoRig.from_rotation(left, right, R, T)."
    )


def fitted_to(own: tuple[int, int], wanted: tuple[int, int]) -> str:
    """What to do with a rig for images of one size where the images have another, as an advice: images of the same
    ratio of width to height are resampled, others are cut out."""
    (wide, high), (width, height) = own, wanted
    if abs(wide * height - width * high) < max(wide, high):  # sizes are whole pixels
        return f"resize the rig in Python: rig.resized(({width}, {height}))"
    scale = max(width / wide, height / high)
    if scale > 1.0:
        return "calibrate for these images, which are larger, and of another ratio of width to height"
    advice = f"crop the rig in Python: rig.cropped(({width}, {height})) if the images are cut out of the middle"
    if scale < 1.0:
        whole = round(wide * scale), round(high * scale)
        advice += f", rig.resized({whole}).cropped(({width}, {height})) if they are resampled, too"
    return advice


def rig_as_data(rig: StereoRig) -> dict[str, Any]:
    """Lists and numbers: of each camera size, matrix, distortion and model (left out if radtan), the extrinsics in
    rad and metres, and by how much images are turned, unless they are not."""
    sides = {"left": rig.left, "right": rig.right}
    cameras = {
        side: {
            "size": list(camera.size),
            "matrix": np.asarray(camera.matrix, float).tolist(),
            "distortion": np.asarray(camera.distortion, float).tolist(),
            **({} if camera.model == Camera.model else {"model": camera.model}),
        }
        for side, camera in sides.items()
    }
    turns = {} if rig.turns == UPRIGHT else {"turns": list(rig.turns)}
    return {**cameras, "extrinsics": np.asarray(rig.extrinsics, float).tolist(), **turns}


def rig_from_data(data: Any) -> StereoRig:
    """The inverse.

    Raises:
        InputError: if these are no such data.
    """
    try:
        left, right = (_camera(data[side]) for side in ("left", "right"))
        first, second = (int(turn) % 4 for turn in data.get("turns", UPRIGHT))
        return StereoRig(left, right, np.array(data["extrinsics"], float), turns=(first, second))
    except InputError:
        raise
    except (AttributeError, KeyError, TypeError, ValueError):
        raise InputError("there is no rig in it; copy it again, or delete it.") from None


def _camera(data: Any) -> Camera:
    width, height = data["size"]
    matrix, distortion = (np.array(data[name], float) for name in ("matrix", "distortion"))
    return Camera((int(width), int(height)), matrix, distortion, model=data.get("model", Camera.model))
