"""The values of files of any form as a list of named arrays, and which of them is which matrix: by its shape, the words
in its name, and the side of a camera that it names; and the calib.json into which they can be written by hand."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.io._atomic import write_text
from stereorecal.io._read_files import AnyPath, check_there
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import Documents, Hints
from stereorecal.io.formats._numbers import Array, array_or_none, image_size, unpacked
from stereorecal.io.formats.text._document import Document, read_document
from stereorecal.io.formats.text._nodes import Keys

_SIDES = (("left", "right"), ("l", "r"), ("1", "2"), ("0", "1"), ("first", "second"), ("a", "b"), ("port", "starboard"),
          ("master", "slave"), ("primary", "secondary"), ("izq", "der"), ("links", "rechts"))  # fmt: skip
_WAY_OUT = (  # of a message
    "give the numbers to sr.StereoRig.from_matrices(K1, D1, K2, D2, R, T, size), or fill in the calib.json that "
    "`stereorecal convert FILE calib.json --template` writes."
)
_LONGEST = 200  # characters of a name
_DEEPEST = 6  # levels of maps
_MOST = 1000  # items of a list
_SHOWN = 12
_LARGEST = 16  # numbers of a matrix of a camera
_ROWS = {"K": [[None, 0, None], [0, None, None], [0, 0, 1]], "D": [None] * 5}


@dataclass(frozen=True)
class Entry:
    """A value of a file."""

    place: Keys  # the number of the document, and the keys in it
    name: str  # what messages call it: the keys, joined by dots
    value: Any
    array: Array | None  # the numbers, or None if it holds something else

    @property
    def words(self) -> list[str]:
        """The words of the name, in small letters: camera, matrix, l of cameraMatrixL."""
        return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", self.name)]

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array; () if there is none."""
        return () if self.array is None else self.array.shape

    def says(self, words: set[str]) -> bool:
        """Whether any of these words is in its name."""
        return not words.isdisjoint(self.words)

    def __str__(self) -> str:
        return f"{self.name} ({'x'.join(map(str, self.shape)) or 'one value'})"


def entries_of(documents: Documents) -> list[Entry]:
    """All values of some documents. An array that has the name of another one in another file is named after its file,
    too."""
    found = [(document, entry) for i, document in enumerate(documents) for entry in _entries(document.content, (i,))]
    arrays = [entry.name for _, entry in found if entry.array is not None and entry.array.size > 1]
    twice = {name for name, count in Counter(arrays).items() if count > 1}
    stem = re.compile(r"([^/\\]*?)(\.\w+)?\Z")
    return [
        Entry(entry.place, f"{stem.search(document.name)[1]}.{entry.name}", entry.value, entry.array)  # pyright: ignore
        if entry.name in twice
        else entry
        for document, entry in found
    ]


def _entries(content: Any, place: Keys) -> Iterator[Entry]:
    inside = unpacked(content)
    items: Any = ()
    if isinstance(inside, Mapping):
        items = inside.items()
    elif isinstance(inside, list) and any(isinstance(item, Mapping) for item in inside):
        items = enumerate(inside)
    elif isinstance(inside, list) and len(inside) > _MOST:
        return  # maps and points, which are no matrices of a camera
    elif sum(len(str(key)) for key in place) < _LONGEST:
        yield Entry(place, ".".join(map(str, place[1:])), content, array_or_none(inside))
    for key, value in items if len(place) < _DEEPEST else ():
        yield from _entries(value, (*place, key))


def _pair_of(
    entries: Sequence[Entry], what: str, fits: Callable[[Entry], bool], better: Callable[[Entry], bool] = bool
) -> tuple[Entry, Entry] | None:
    """The two entries that fit, of the better ones if there are any, and whose names differ by their side alone, left
    first; None if there are none."""
    found = [entry for entry in entries if fits(entry)]
    by_name = {entry.name.lower(): entry for entry in [*filter(better, found)] or found}
    pairs = [
        (entry, by_name[other]) for name, entry in by_name.items() for other in _partners(name) if other in by_name
    ]
    if len({_same_as(*pair) for pair in pairs}) > 1:
        raise _several(what, [f"{one.name} and {other.name}" for one, other in pairs])
    return pairs[0] if pairs else None


def _partners(name: str) -> Iterator[str]:
    """What the right camera's name may be if this is the left one's."""
    for left, right in _SIDES:
        if left in name:
            yield name.replace(left, right)
            yield from (name[: at.start()] + right + name[at.end() :] for at in re.finditer(left, name))
    yield from (f"{name}2", f"{name}_2")


def _same_as(*entries: Entry) -> bytes:
    """What is equal for entries with the same numbers."""
    return b"|".join(b"" if entry.array is None else entry.array.tobytes() for entry in entries)


def _several(what: str, names: Sequence[str]) -> InputError:
    """What to raise where there are two readings of something."""
    return InputError(f"{what} may be {' or '.join(dict.fromkeys(names))}; remove what is not meant, or {_WAY_OUT}")


def said_of(documents: Documents) -> str:
    """The arrays that documents hold, with their shapes, and how to say which is which."""
    found = _listed(entries_of(documents))
    return f"{f' It has {found}.' if found else ''} {_WAY_OUT[0].upper()}{_WAY_OUT[1:]}"


def _listed(entries: Iterable[Entry]) -> str:
    """The arrays among some entries, with their shapes."""
    found = [str(entry) for entry in entries if entry.array is not None and entry.array.size > 1]
    more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return ", ".join(found[:_SHOWN]) + more


def save_template(paths: Sequence[AnyPath], path: AnyPath, *, overwrite: bool = False) -> None:
    """Write a calib.json to be filled in, and beside its keys, under `found`, the arrays of calibration files of no
    known form; InputError if one is missing, or the place cannot be written to."""
    documents: list[Document] = []
    for file in map(Path, paths):
        check_there(file)
        with suppress(InputError):
            documents.append(read_document(file))
    cameras = {f"{key}_{side}": rows for side in ("left", "right") for key, rows in _ROWS.items()}
    content: dict[str, Any] = {"image_size": [None, None], **cameras, "distortion_model": "opencv"}
    content |= {"R": [[None] * 3] * 3, "T": [None] * 3}
    entries = entries_of(tuple(documents))
    found = {e.name: e.array.tolist() for e in entries if e.array is not None and e.array.size <= _LARGEST}
    write_text(path, strict_json_text({**content, "found": found}), replace=overwrite)


MATRICES = ("K", "M", "cameraMatrix", "camera_matrix_", "intrinsic")
_DISTORTIONS = ("D", "distCoeffs", "dist_coeffs_", "distortion_coefficients_")
_SIZES = ("imageSize", "image_size", "imgSize", "size", "res1")


@dataclass(frozen=True)
class Matrices:
    """The values of some documents, and which of them is which."""

    entries: Mapping[str, Entry]  # by name
    content: Mapping[str, Any]  # their values
    # Of K1, D1, K2, D2, R, T, and, where the file has them, R1, R2, P1, P2; of others, as OpenCV's samples name them.
    names: Mapping[str, str]

    def has(self, *roles: str) -> bool:
        """Whether all of these are there."""
        return all(self.names.get(role) in self.content for role in roles)

    def own_name(self, key: str) -> str:
        """What a derived matrix, such as P1 or Q, is called: its usual key, which may stand below others."""
        if key in self.names or key in self.content:
            return self.names.get(key, key)
        inside = [name for name, entry in self.entries.items() if entry.place[-1] == key]
        return inside[0] if len(inside) == 1 else key

    def size(self, hints: Hints) -> tuple[int, int]:
        """(width, height) of the images, of the file or else of the hints."""
        for key in _SIZES:
            if key in self.content:
                return image_size(self.content, key)
        if "image_width" in self.content:
            return image_size(self.content, "image_width", "image_height")
        return _size_in(self.entries.values()) or hints.needed_size("the file has no image size (imageSize)")

    def check_whole(self) -> None:
        """Refuse one file of the two that stereo_calib writes, and matrices whose names do not say what they are."""
        cameras, between = self.has("K1") or self.has("K2"), self.has("R") or self.has("T")
        if not (cameras and between):
            lack = "rotation and translation (R, T)" if cameras else "camera matrices (K1 or M1, K2 or M2)"
            found = _listed(self.entries.values()) or "the values"
            raise InputError(
                f"no {lack} are found among {found}; give both files that OpenCV's stereo_calib writes, intrinsics.yml "
                f"and extrinsics.yml, or {_WAY_OUT}"
            )


def matrices_in(documents: Documents) -> Matrices:
    """What documents hold, by exact names where there are both cameras', else by search."""
    entries = entries_of(documents)
    content, names = {entry.name: entry.value for entry in entries}, dict[str, str]()
    for role, what, usual, fits, better in (
        ("K", "the camera matrices", MATRICES, _is_camera, lambda entry: not entry.says(_OF_RECTIFIED)),
        ("D", "the distortion coefficients", _DISTORTIONS, _is_lens, lambda entry: entry.says(_LENS)),
    ):
        both = next((name for name in usual if {f"{name}1", f"{name}2"} <= content.keys()), None)
        found = None if both else _pair_of(entries, what, fits, better)
        known = both or next((name for name in usual if {f"{name}1", f"{name}2"} & content.keys()), usual[0])
        names |= {f"{role}{side}": found[side - 1].name if found else f"{known}{side}" for side in (1, 2)}
    rotation = translation = None
    if "R" not in content:  # a matrix, else a vector of that name
        rotation = _between(entries, _is_rotation, _ROTATION, "the rotation")
        rotation = rotation or _between(entries, _is_vector, _ROTATION, "the rotation", alone=False)
    if "T" not in content:
        others = [entry for entry in entries if not entry.says(_ROTATION)]
        translation = _between(others, _is_vector, _TRANSLATION, "the translation")
    names |= {"R": rotation.name if rotation else "R", "T": translation.name if translation else "T"}
    if not {names["R"], names["T"]} & content.keys():
        rotations = _pair_of(entries, "the rectifying rotations", _is_rotation)
        projections = _pair_of(entries, "the projection matrices", lambda entry: entry.shape == (3, 4))
        if rotations and projections:
            names |= {f"R{side}": entry.name for side, entry in enumerate(rotations, start=1)}
            names |= {f"P{side}": entry.name for side, entry in enumerate(projections, start=1)}
    return Matrices({entry.name: entry for entry in entries}, content, names)


_COUNTS = (0, 1, 2, 3, 4, 5, 8, 12, 14)
_ROTATION = {"r", "rot", "rotation", "rvec", "rmat", "om", "rodrigues"}
_TRANSLATION = {"t", "trans", "translation", "tvec", "tra", "tvecs"}
_LENS = {"d", "dist", "distortion", "distorted", "distcoeffs", "coef", "coeff", "coeffs", "coefficients", "coefs", "kc"}
_NO_LENS = {"roi", "size", "resolution", "quat", "quaternion", "q", "intrinsics", "intrinsic", "shape"}
_OF_RECTIFIED = {"new", "rect", "rectified", "rectification", "optimal", "undistorted", "projection", "p", "error"}
_ELSEWHERE = {"imu", "body", "lidar", "velo", "world", "base", "gps", "target", "board", "robot", "ground", "h",
              "homography"}  # fmt: skip
_BESIDE_SIZE = {"board", "pattern", "square", "grid", "marker", "new", "window", "win", "chessboard", "corner", "roi"}
_SMALLEST = 16  # pixels: fewer are squares of a chessboard


def _between(
    entries: Sequence[Entry], fits: Callable[[Entry], bool], words: set[str], what: str, alone: bool = True
) -> Entry | None:
    """What stands once, not once for each camera, and is named so; or, if it may be `alone`, is the only one."""
    found = [entry for entry in entries if fits(entry) and not entry.says(_OF_RECTIFIED | _ELSEWHERE)]
    names = {entry.name.lower() for entry in found}
    paired = {name for one in names for other in _partners(one) if other in names for name in (one, other)}
    single = [entry for entry in found if entry.name.lower() not in paired]
    named = [entry for entry in single if entry.says(words)]
    chosen = named or (single if alone else [])
    if len({_same_as(entry) for entry in chosen}) > 1:
        raise _several(what, [entry.name for entry in chosen])
    return chosen[0] if chosen else None


def _size_in(entries: Iterable[Entry]) -> tuple[int, int] | None:
    """The (width, height) of the images, under any name that says so."""
    found: dict[str, tuple[int, int]] = {}
    sides: dict[tuple[str, ...], dict[str, int]] = {}
    for entry in entries:
        words, numbers = set(entry.words), [] if entry.array is None else entry.array.ravel().tolist()
        if _BESIDE_SIZE & words or len(numbers) not in (1, 2) or any(n < _SMALLEST or n % 1 for n in numbers):
            continue
        first, last = int(numbers[0]), int(numbers[-1])
        if entry.shape == (2,) and words & {"size", "resolution", "imagesize", "imgsize"}:
            found[entry.name] = first, last
        for side, names in (("width", {"width", "w", "cols"}), ("height", {"height", "h", "rows"})):
            if len(numbers) == 1 and words & names:
                sides.setdefault(tuple(word for word in entry.words if word not in names), {})[side] = first
    for of, both in sides.items():
        if len(both) == 2:
            found[" ".join((*of, "width and height"))] = (both["width"], both["height"])
    if len(set(found.values())) > 1:
        raise _several("the image size", [f"{name} {wide}x{high}" for name, (wide, high) in found.items()])
    return next(iter(found.values()), None)


def _is_camera(entry: Entry) -> bool:
    """Whether it may be a camera matrix, of 3x3 or 3x4, transposed or a little off: with focal lengths that no rotation
    has."""
    array = entry.array
    if array is None or array.shape not in ((3, 3), (3, 4)) or (array.shape == (3, 4) and np.any(array[:, 3])):
        return False
    upper = np.abs(array[2, :2]).max() < 1e-3 or (np.abs(array[:2, 2]).max() < 1e-3 and array.shape == (3, 3))
    return bool(min(array[0, 0], array[1, 1]) > 2.0 and abs(array[2, 2] - 1.0) < 1e-3 and upper)


def _is_lens(entry: Entry) -> bool:
    shape = entry.shape
    if len(shape) != 1 or shape[0] not in _COUNTS or entry.says(_OF_RECTIFIED):
        return False
    return entry.says(_LENS) or (shape[0] >= 4 and not entry.says(_NO_LENS))


def _is_rotation(entry: Entry) -> bool:
    array = np.zeros(0) if entry.array is None else entry.array
    return array.shape == (3, 3) and bool(np.abs(array @ array.T - np.eye(3)).max() < 1e-3 < np.linalg.det(array))


def _is_vector(entry: Entry) -> bool:
    return entry.shape == (3,)
