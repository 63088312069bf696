"""The values of calibration files of any form as a list of named arrays; names that differ by the side of a camera
alone; and the calib.json into which they can be written by hand."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._read_files import AnyPath
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import Documents
from stereorecal.io.formats._matrix_values import Array
from stereorecal.io.formats._numbers import array_or_none, unpacked
from stereorecal.io.formats.text._document import Document, read_document
from stereorecal.io.formats.text._nodes import Keys

_SIDES = (("left", "right"), ("l", "r"), ("1", "2"), ("0", "1"), ("first", "second"), ("a", "b"), ("port", "starboard"),
          ("master", "slave"), ("primary", "secondary"), ("izq", "der"), ("links", "rechts"))  # fmt: skip
WAY_OUT = (  # of a message
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
    """A value of a file.

    Attributes:
        place: the number of the document, and the keys in it.
        name: what messages call it: the keys, joined by dots.
        array: the numbers, or None if it holds something else.
    """

    place: Keys
    name: str
    value: Any
    array: Array | None

    @property
    def words(self) -> list[str]:
        """The words of the name, in small letters: camera, matrix, l of cameraMatrixL."""
        return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", self.name)]

    def __str__(self) -> str:
        shape = () if self.array is None else self.array.shape
        return f"{self.name} ({'x'.join(map(str, shape)) or 'one value'})"


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


def pair_of(entries: Sequence[Entry], what: str) -> tuple[Entry, Entry] | None:
    """The two entries whose names differ by their side alone, left first; None if there are none."""
    by_name = {entry.name.lower(): entry for entry in entries}
    pairs = [(entry, by_name[other]) for name, entry in by_name.items() for other in partners(name) if other in by_name]
    if len({same_as(*pair) for pair in pairs}) > 1:
        raise several(what, [f"{one.name} and {other.name}" for one, other in pairs])
    return pairs[0] if pairs else None


def partners(name: str) -> Iterator[str]:
    """What the right camera's name may be if this is the left one's."""
    for left, right in _SIDES:
        if left in name:
            places = [found.start() for found in re.finditer(left, name)]
            yield from dict.fromkeys(
                [name.replace(left, right), *(name[:at] + right + name[at + len(left) :] for at in places)]
            )
    yield from (f"{name}2", f"{name}_2")


def same_as(*entries: Entry) -> bytes:
    """What is equal for entries with the same numbers."""
    return b"|".join(b"" if entry.array is None else entry.array.tobytes() for entry in entries)


def several(what: str, names: Sequence[str]) -> InputError:
    """What to raise where there are two readings of something."""
    return InputError(f"{what} may be {' or '.join(dict.fromkeys(names))}; remove what is not meant, or {WAY_OUT}")


def said_of(documents: Documents) -> str:
    """The arrays that documents hold, with their shapes, and how to say which is which."""
    found = [str(entry) for entry in entries_of(documents) if entry.array is not None and entry.array.size > 1]
    more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    has = f" It has {', '.join(found[:_SHOWN])}{more}." if found else ""
    return f"{has} {WAY_OUT[0].upper()}{WAY_OUT[1:]}"


def calibration_template(paths: Sequence[AnyPath]) -> str:
    """A calib.json without numbers, and beside them, under `found`, those of some files, to be copied from there."""
    documents: list[Document] = []
    for path in map(Path, paths):
        if not path.exists():
            raise InputError(f"{path}: there is no such file; check the path.")
        try:
            documents.append(read_document(path))
        except InputError:
            continue
    cameras = {f"{key}_{side}": rows for side in ("left", "right") for key, rows in _ROWS.items()}
    content: dict[str, Any] = {"image_size": [None, None], **cameras, "distortion_model": "opencv"}
    content |= {"R": [[None] * 3] * 3, "T": [None] * 3}
    entries = entries_of(tuple(documents))
    found = {e.name: e.array.tolist() for e in entries if e.array is not None and e.array.size <= _LARGEST}
    return strict_json_text({**content, "found": found})
