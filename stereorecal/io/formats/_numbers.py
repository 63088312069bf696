"""What a calibration file says under a key, as a finite float64 array or in one sentence: numbers, matrices in the
shapes in which files have them, and the numbers and words of lenses."""

import difflib
import re
from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3
from stereorecal._errors import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io.formats.text._nodes import Keys, at, leaves

Array = Float[np.ndarray, "..."]
# The largest width and height of an image that OpenCV reads by default (its CV_IO_MAX_IMAGE_WIDTH).
_WIDEST = 1 << 20


def numbers(content: Mapping[str, Any], key: str | Keys, shape: tuple[int, ...]) -> Array:
    """The finite float64 array under a key, which holds a number, nested lists of numbers, or `rows cols data`, of this
    shape; (-1,) is any length. Axes of length one are dropped: (1, 5) and (5, 1) become (5,). A matrix may be one
    list, row by row."""
    stated, key = value(content, key), key_name(key)
    array = _array(unpacked(stated), key).squeeze()
    if len(shape) == 1:
        array = np.atleast_1d(array)
    if len(shape) == 2 and array.shape == (shape[0] * shape[1],) and isinstance(stated, list):
        array = array.reshape(shape)
    if shape not in (array.shape, (-1,) * array.ndim):
        wanted, found = ("x".join(map(str, each)) for each in (shape, array.shape))
        expected = "one number" if shape == () else "a list of numbers" if -1 in shape else f"{wanted} numbers"
        raise InputError(f"{key} must hold {expected}, not {found or 'one'}; correct it, or copy the file again.")
    return array


def scalars(content: Mapping[str, Any], keys: Sequence[str | Keys]) -> Float[np.ndarray, "n"]:
    """The numbers under these keys, one under each."""
    return np.array([float(numbers(content, key, ())) for key in keys])


def array_or_none(stated: Any) -> Array | None:
    """What is stated as a finite float64 array, as `numbers` reads it, of any shape; None if it is none."""
    try:
        array = _array(unpacked(stated), "")
    except InputError:
        return None
    return np.atleast_1d(array.squeeze()) if array.ndim else array


def value(content: Any, keys: str | Keys) -> Any:
    """The value under a key, or that keys lead to."""
    for key in (keys,) if isinstance(keys, str) else keys:
        if isinstance(key, str) and key not in content:
            close = _misspelt(key, content)
            hint = f"rename {close!r} if that is meant" if close else "add it"
            raise InputError(f"the key {key!r} is missing; {hint}, or copy the file again.")
        content = content[key]
    return content


def key_name(keys: str | Sequence[str | int]) -> str:
    """What messages call a value: its key; an item of a list, that of the list."""
    return keys if isinstance(keys, str) else next(key for key in reversed(keys) if isinstance(key, str))


def optional(content: Mapping[str, Any], key: str) -> Any:
    """The value under a key; None if there is no such key."""
    misspelt = _misspelt(key, content)
    if key not in content and misspelt:
        raise InputError(f"the key {misspelt!r} is not known; rename it if {key!r} is meant, or remove it.")
    return content.get(key)


def _misspelt(key: str, content: Mapping[str, Any]) -> str | None:
    """A key that is written almost like another one; not one that differs by a number: that is the other camera's."""
    close = difflib.get_close_matches(key, map(str, content), 1, 0.9)
    return next((other for other in close if re.findall(r"\d", other) == re.findall(r"\d", key)), None)


def unpacked(stated: Any) -> Any:
    """A map of rows, cols and data (OpenCV, ROS), or of sizes and data (OpenCV 5), as a list or a list of rows; all
    else as it is."""
    match stated:
        case {"rows": _, "cols": _, "data": []}:
            return []
        case {"rows": int(rows), "cols": int(columns), "data": list(data)} if columns > 0:
            # If the numbers do not fill the matrix they stay a flat list, and the reader says what it expected.
            fits = rows * columns == len(data)
            return [data[start : start + columns] for start in range(0, len(data), columns)] if fits else data
        case {"sizes": [int(rows), int(columns)], "data": list(data)}:
            return unpacked({"rows": rows, "cols": columns, "data": data})
        case {"sizes": _, "data": list(data)}:
            return data
        case _:
            return stated


def image_size(content: Mapping[str, Any], *keys: str | Keys) -> tuple[int, int]:
    """The (width, height) of an image in pixels: two numbers under a key, or one under each of two."""
    width, height = numbers(content, keys[0], (2,)) if len(keys) == 1 else scalars(content, keys)
    for number, key in ((width, keys[0]), (height, keys[-1])):
        if number != np.rint(number) or not 1 <= number <= _WIDEST:
            raise InputError(
                f"{key_name(key)} is {number:g}, but an image size is a whole number of pixels from 1 to {_WIDEST}; "
                "correct it."
            )
    return int(width), int(height)


def _array(stated: Any, key: str) -> Array:
    found = list(leaves(stated))
    if None in found:
        raise InputError(f"{key} contains null (no value); give numbers.")
    if not all(isinstance(leaf, int | float) and not isinstance(leaf, bool) for leaf in found):
        raise _no_array(key)
    try:
        array = np.array(stated, float)
    except ValueError:  # rows of different lengths
        raise _no_array(key) from None
    except OverflowError:  # an integer beyond float64
        array = np.array(np.inf)
    if not np.isfinite(array).all():
        raise InputError(f"{key} contains NaN or infinite numbers; correct it.")
    return array


def _no_array(key: object) -> InputError:
    return InputError(f"{key} is not an array of numbers; correct it, or copy the file again.")


def camera_matrix(content: Mapping[str, Any], key: str) -> Mat3:
    """The camera matrix under a key: 3x3, or 3x4 with a fourth column of zeros."""
    if size_of(content, (key,)) != 12:
        return numbers(content, key, (3, 3))
    matrix = numbers(content, key, (3, 4))
    if np.any(matrix[:, 3]):
        raise InputError(
            f"{key} is the projection matrix of rectified images (its fourth column is not zero), no camera matrix; "
            "give the camera matrix, 3x3."
        )
    return matrix[:, :3]


def rotation_matrix(content: Mapping[str, Any], key: str) -> Mat3:
    """The rotation under a key: a matrix, or a rotation vector of `cv2.Rodrigues` [rad]."""
    if size_of(content, (key,)) != 3:
        return numbers(content, key, (3, 3))
    vector = numbers(content, key, (3,))
    if np.linalg.norm(vector) > np.pi:
        raise InputError(
            f"{key} has three numbers, but is no rotation vector in radians (its length is "
            f"{np.linalg.norm(vector):.3g}, more than pi); give the rotation matrix, such as cv2.Rodrigues(rvec)[0]."
        )
    return cv2.Rodrigues(vector)[0]


def lens_coefficients(content: Mapping[str, Any], key: str) -> Float[np.ndarray, "n"]:
    """The coefficients of a pinhole under a key; k1, or k1 k2, may stand alone."""
    found = numbers(content, key, (-1,))
    if found.size == 3:
        raise UnsupportedModelError(
            f"the distortion has 3 coefficients ({key}), which are k1 k2 k3 or k1 k2 p1; write them in OpenCV's order, "
            "k1 k2 0 0 k3 or k1 k2 p1 0."
        )
    return np.pad(found, (0, 4 - found.size)) if found.size in (1, 2) else found


def matrix_values(content: Mapping[str, Any], keys: Keys, array: Array) -> dict[Keys, Any]:
    """What to write for an array where the file has a map of rows (or sizes), cols and data, or lists of any shape. A
    vector may be longer than the one in the file; a camera matrix stays one of 3x4, and a rotation a vector."""
    stated, array = at(content, keys), np.asarray(array, float)
    if array.shape == (3, 3) and size_of(content, keys) in (3, 12):
        array = np.pad(array, ((0, 0), (0, 1))) if size_of(content, keys) == 12 else cv2.Rodrigues(array)[0]
    flat = array.ravel().tolist()
    if not isinstance(stated, Mapping):
        try:
            shape = np.shape(stated)
        except ValueError:  # rows of different lengths
            raise _no_array(keys[-1]) from None
        return {keys: np.reshape(flat, shape).tolist() if np.prod(shape) == len(flat) else flat}
    values: dict[str, Any] = {"data": flat} | ({"dt": "d"} if "dt" in stated else {})  # more would be lost in "f"
    if len(flat) > len(stated["data"]):
        sizes, count = stated.get("sizes"), len(flat)
        if isinstance(sizes, list):
            values["sizes"] = [count if size == max(sizes) else size for size in sizes]
        elif sizes is not None:
            values["sizes"] = count
        else:
            values |= {"rows": 1, "cols": count} if stated["rows"] in (0, 1) else {"rows": count, "cols": 1}
    return {(*keys, key): value for key, value in values.items()}


def size_of(content: Mapping[str, Any], keys: Keys) -> int:
    """How many numbers stand under a key; 0 if there is none, or they are no array."""
    array = array_or_none(at(content, keys))
    return 0 if array is None else array.size


_OF_OPENCV = (Camera.model, "equidistant")  # the models that OpenCV has
ROUNDING = 1e-9  # radians; and parts of the baseline
# Formats that have a place for a lens model, for messages.
_HOLDERS = {
    "equidistant": "kalibr, ros or stereorecal",
    "ds": "kalibr, basalt or stereorecal",
    "eucm": "kalibr, basalt or stereorecal",
    "omni": "kalibr or stereorecal",
}

# Names of OpenCV's pinhole model: its own, those of ROS (plumb_bob, rational_polynomial) and of Kalibr (radtan).
_PINHOLE = frozenset({"", "none", "opencv", "plumb_bob", "rational_polynomial", "radtan"})
_FISHEYE = ("fisheye", "equidistant", "kannala", "kb4")  # anywhere in it
_OTHER = ("equi", "omni")


def pinhole_matrix(numbers: Float[np.ndarray, "4"]) -> Mat3:
    """The camera matrix of fx, fy, cx, cy."""
    fx, fy, cx, cy = numbers
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def pinhole_numbers(camera: Camera) -> list[float]:
    """fx, fy, cx, cy."""
    matrix = np.asarray(camera.matrix)
    return [float(matrix[place]) for place in ((0, 0), (1, 1), (0, 2), (1, 2))]


def not_held(camera: Camera, what: str) -> InputError:
    """What to raise for a lens of a model for which the format that is called `what` has no place."""
    return InputError(
        f"{what} has no place for a lens of the model {camera.model!r}; write it as {_HOLDERS[camera.model]} instead."
    )


def has_lens(rig: StereoRig) -> bool:
    """Whether a camera is anything but a pinhole without distortion."""
    return any(camera.model != "radtan" or bool(np.any(camera.distortion)) for camera in (rig.left, rig.right))


def coefficients(
    camera: Camera, counts: Sequence[int], what: str, instead: str, least: int = 0
) -> Float[np.ndarray, "n"]:
    """The distortion in OpenCV's order; of a pinhole as many coefficients as a file takes, the first of the counts that
    is enough and not below `least`. `what` is, for messages, whose lens models these are, and `instead` names the
    formats that hold more."""
    if camera.model not in _OF_OPENCV:
        raise not_held(camera, what)
    own = np.asarray(camera.distortion, float)
    if camera.model != Camera.model:
        return own
    needed = np.trim_zeros(own, "b").size
    for count in counts:
        if count >= max(needed, least):
            return np.pad(own, (0, max(0, count - own.size)))[:count]
    raise InputError(
        f"{what} has {counts[-1]} lens coefficients, and this rig needs {needed}; write it as {instead} instead."
    )


def unsupported(model: object) -> UnsupportedModelError:
    """What to raise for a lens model that is not known, as the file calls it."""
    return UnsupportedModelError(
        f"the lens model {str(model)!r} is not supported; undistort the images, or calibrate as pinhole with "
        "radial-tangential distortion, or as equidistant."
    )


def check_no_lens(model: object, lens: Float[np.ndarray, "n"]) -> None:
    """Refuse coefficients of a lens that is said to have none."""
    if model in ("", "none") and np.any(lens):
        raise InputError(
            f"the distortion model is {model!r}, but there are coefficients; name their model (plumb_bob, radtan), or "
            "set them to zero."
        )


def check_straight(rig: StereoRig, what: str, off_line: object = False) -> None:
    """Refuse a rotation of more than rounding, a lens, or anything else that a format of rectified images lacks."""
    turned = np.abs(np.asarray(rig.extrinsics)[:3]).max() > ROUNDING
    if turned or off_line or has_lens(rig):
        raise InputError(
            f"{what} has no place for a rotation or a lens; write it as opencv, kalibr or stereorecal instead."
        )


def model_named(stated: Any) -> str:
    """The model of `Camera` that a word means, which a remark may follow; that of OpenCV's pinhole for None."""
    name = str(stated or "").lower()
    base = re.split(r"[(;,]", name)[0].strip()
    if any(word in name for word in _FISHEYE):
        return "equidistant"
    if base in ("ds", "eucm", "omni"):
        return base
    if not (base in _PINHOLE or base.startswith("opencv")) or any(word in name for word in _OTHER):
        raise unsupported(stated)
    return Camera.model
