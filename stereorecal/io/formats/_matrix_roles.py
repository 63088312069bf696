"""Which matrix is which in a file of matrices under any names: by shape, and by the sides and words in their names."""

from collections.abc import Callable, Sequence

import numpy as np

from stereorecal.io.formats._format import Documents
from stereorecal.io.formats._matrix_entries import Entry, entries_of, pair_of, partners, same_as, several

_COUNTS = (1, 2, 3, 4, 5, 8, 12, 14)
_ROTATION = {"r", "rot", "rotation", "rvec", "rmat", "om", "rodrigues"}
_TRANSLATION = {"t", "trans", "translation", "tvec", "tra", "tvecs"}
_LENS = {"d", "dist", "distortion", "distorted", "distcoeffs", "coef", "coeff", "coeffs", "coefficients", "coefs", "kc"}
_NO_LENS = {"roi", "size", "resolution", "quat", "quaternion", "q", "intrinsics", "intrinsic", "shape"}
_INTRINSICS = {"fx", "fy", "cx", "cy", "f", "focal", "intrinsic", "intrinsics", "intr", "k", "mtx", "principal"}
_OF_RECTIFIED = {"new", "rect", "rectified", "rectification", "optimal", "undistorted", "projection", "p", "error"}
_ELSEWHERE = {"imu", "body", "lidar", "velo", "world", "base", "gps", "target", "board", "robot", "ground", "h",
              "homography"}  # fmt: skip
_BESIDE_SIZE = {"board", "pattern", "square", "grid", "marker", "new", "window", "win", "chessboard", "corner", "roi"}
_SMALLEST = 16  # pixels: fewer are squares of a chessboard


def cameras_in(entries: Sequence[Entry]) -> tuple[Entry, Entry] | None:
    """The camera matrices; those of rectified images only where there are no others."""
    found = [entry for entry in entries if is_camera(entry)]
    raw = [entry for entry in found if not _OF_RECTIFIED & set(entry.words)]
    return pair_of(raw or found, "the camera matrices")


def has_cameras(documents: Documents) -> bool:
    """Whether there are any camera matrices."""
    return any(is_camera(entry) for entry in entries_of(documents))


def lenses_in(entries: Sequence[Entry]) -> tuple[Entry, Entry] | None:
    """The distortion coefficients: by their names, or the only two vectors that can be some."""
    found = [entry for entry in entries if entry.array is not None and _is_lens(entry)]
    named = [entry for entry in found if _LENS & set(entry.words)]
    return pair_of(named or found, "the distortion coefficients")


def rectifications_in(entries: Sequence[Entry]) -> tuple[tuple[Entry, Entry], tuple[Entry, Entry]] | None:
    """The rotations that rectify the two cameras, and the projection matrices of the rectified ones."""
    rotations = pair_of([entry for entry in entries if _is_rotation(entry)], "the rectifying rotations")
    projections = pair_of(
        [entry for entry in entries if entry.array is not None and entry.array.shape == (3, 4)],
        "the projection matrices",
    )
    return None if rotations is None or projections is None else (rotations, projections)


def rotation_in(entries: Sequence[Entry]) -> Entry | None:
    """The rotation between the cameras: a matrix, else a vector of that name."""
    for fits in (_is_rotation, _is_vector):
        found = _between(entries, fits, _ROTATION, "the rotation", alone=fits is _is_rotation)
        if found is not None:
            return found
    return None


def translation_in(entries: Sequence[Entry]) -> Entry | None:
    """The translation between the cameras."""
    rotation = [entry for entry in entries if _is_vector(entry) and _ROTATION & set(entry.words)]
    others = [entry for entry in entries if entry not in rotation]
    return _between(others, _is_vector, _TRANSLATION, "the translation", alone=True)


def _between(
    entries: Sequence[Entry], fits: Callable[[Entry], bool], words: set[str], what: str, alone: bool
) -> Entry | None:
    """What stands once, not once for each camera, and is named so; or, if it may be `alone`, is the only one."""
    found = [entry for entry in entries if fits(entry) and not (_OF_RECTIFIED | _ELSEWHERE) & set(entry.words)]
    names = {entry.name.lower() for entry in found}
    paired = {name for one in names for other in partners(one) if other in names for name in (one, other)}
    single = [entry for entry in found if entry.name.lower() not in paired]
    named = [entry for entry in single if words & set(entry.words)]
    chosen = named or (single if alone else [])
    if len({same_as(entry) for entry in chosen}) > 1:
        raise several(what, [entry.name for entry in chosen])
    return chosen[0] if chosen else None


def size_in(entries: Sequence[Entry]) -> tuple[int, int] | None:
    """The (width, height) of the images, under any name that says so."""
    found: dict[str, tuple[int, int]] = {}
    sides: dict[str, dict[tuple[str, ...], int]] = {"width": {}, "height": {}}
    for entry in entries:
        words = set(entry.words)
        if entry.array is None or _BESIDE_SIZE & words or not 0 < entry.array.size <= 2:
            continue
        if entry.array.min() < _SMALLEST or np.any(entry.array % 1):
            continue
        if entry.array.shape == (2,) and words & {"size", "resolution", "imagesize", "imgsize"}:
            found[entry.name] = (int(entry.array[0]), int(entry.array[1]))
        for side, names in (("width", {"width", "w", "cols"}), ("height", {"height", "h", "rows"})):
            if entry.array.size == 1 and words & names:
                sides[side][tuple(word for word in entry.words if word not in names)] = int(entry.array.ravel()[0])
    for of, width in sides["width"].items():
        if of in sides["height"]:
            found[" ".join((*of, "width and height"))] = (width, sides["height"][of])
    if len(set(found.values())) > 1:
        raise several("the image size", [f"{name} {wide}x{high}" for name, (wide, high) in found.items()])
    return next(iter(found.values()), None)


def may_be_between(entry: Entry) -> bool:
    """Whether it may be a rotation, a translation, or both in a matrix."""
    array = entry.array
    pose = array is not None and array.shape in ((3, 4), (4, 4)) and np.abs(array[:3, :3]).max() < 1.001
    return _is_rotation(entry) or _is_vector(entry) or pose


def may_be_camera(entry: Entry) -> bool:
    """Whether it may be the intrinsics of a camera, or one number of them."""
    return is_camera(entry) or (entry.array is not None and bool(_INTRINSICS & set(entry.words)))


def is_camera(entry: Entry) -> bool:
    """Whether it may be a camera matrix, of 3x3 or 3x4, transposed or a little off: with focal lengths that no rotation
    has."""
    array = entry.array
    if array is None or array.shape not in ((3, 3), (3, 4)) or (array.shape == (3, 4) and np.any(array[:, 3])):
        return False
    upper = np.abs(array[2, :2]).max() < 1e-3 or (np.abs(array[:2, 2]).max() < 1e-3 and array.shape == (3, 3))
    return bool(min(array[0, 0], array[1, 1]) > 2.0 and abs(array[2, 2] - 1.0) < 1e-3 and upper)


def _is_lens(entry: Entry) -> bool:
    assert entry.array is not None
    flat = entry.array.ndim == 1 and entry.array.size in (0, *_COUNTS)
    words = set(entry.words)
    named = bool(_LENS & words)
    unnamed = entry.array.size >= 4 and not _NO_LENS & words
    return flat and not _OF_RECTIFIED & words and (named or unnamed)


def _is_rotation(entry: Entry) -> bool:
    array = entry.array
    if array is None or array.shape != (3, 3):
        return False
    return bool(np.abs(array @ array.T - np.eye(3)).max() < 1e-3 and np.linalg.det(array) > 0)


def _is_vector(entry: Entry) -> bool:
    return entry.array is not None and entry.array.shape == (3,)
