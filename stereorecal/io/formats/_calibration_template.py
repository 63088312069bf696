"""What to say of a file of no known form, and the calib.json that its matrices can be written into by hand."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.io._read_files import AnyPath
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import Documents
from stereorecal.io.formats._matrix_entries import WAY_OUT, entries_of
from stereorecal.io.formats.text._document import Document, read_document

_SHOWN = 12
_LARGEST = 16  # numbers of a matrix of a camera
_ROWS = {"K": [[None, 0, None], [0, None, None], [0, 0, 1]], "D": [None] * 5}


def said_of(documents: Documents) -> str:
    """The arrays that documents hold, with their shapes, and how to say which is which."""
    found = [str(entry) for entry in entries_of(documents) if entry.array is not None and entry.array.size > 1]
    more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    has = f" It has {', '.join(found[:_SHOWN])}{more}." if found else ""
    return f"{has} {WAY_OUT[0].upper()}{WAY_OUT[1:]}"


def calibration_template(paths: Sequence[AnyPath]) -> str:
    """A calib.json without numbers, and beside them, under `found`, those of some files, to be copied from there.

    Raises:
        InputError: if a file is missing; one that cannot be read adds nothing.
    """
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
