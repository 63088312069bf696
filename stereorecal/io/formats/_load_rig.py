"""From paths to a rig: the files of a calibration, alone or in a folder; and what is said of one that was read."""

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations
from pathlib import Path

import numpy as np

from stereorecal._errors import CalibrationWarning, InputError, UnsupportedModelError, checked_choice, warn
from stereorecal.geometry import METRES, StereoRig, described_turns, doubt_of_length, fitted_to, whole_size
from stereorecal.io._read_files import AnyPath
from stereorecal.io.formats._format import Documents, Format, Hints
from stereorecal.io.formats._matrix_search import said_of
from stereorecal.io.formats._read_rig import FORMATS, checked_cameras, named, recognised, rig_in
from stereorecal.io.formats._rig_file import ENDING, RigFile, file_of, read_stored_prior
from stereorecal.io.formats.text._document import Document, Syntax, read_document
from stereorecal.io.formats.text._nodes import DOCUMENTS
from stereorecal.io.formats.text._yaml import SEVERAL

_FAR = 0.15  # of the width or height: principal points of cameras whose images are whole lie nearer to the middle
_MOST_FILES = 12  # one for each matrix, and some beside; and those of a folder that are tried in pairs
_MOST_TOGETHER = 40  # of a folder, a file for each matrix
_ENDINGS = (".yaml", ".yml", ".xml", ".json", ".txt")
_BINARY = (".npz", ".npy", ".mat")  # read where a folder has no texts: most are images and maps
_OF_CAMERAS = ("cam0/sensor.yaml", "cam1/sensor.yaml")  # EuRoC's, which lie in folders of their own
_SCENE = "calib.json"


def load_rig(
    path: AnyPath | Sequence[AnyPath],
    right: AnyPath | None = None,
    *,
    format: str | None = None,
    unit: str | None = None,
    size: tuple[int, int] | None = None,
    cameras: tuple[str, str] | None = None,
) -> StereoRig:
    """The rig in a calibration file of any format of `docs/data.md`; it remembers the file, for `save_rig`. Where its
    cameras stand one above the other, or one is upside down, what matches images turns it, and them:
    `StereoRig.side_by_side`.

    Args:
        path: the file; a folder that holds one; or the left camera's file, where each camera has its own, alone or
            with the right one's, as `save_rig` takes them; or all files, where each matrix has its own.
        right: the right camera's file (or the extrinsics, where OpenCV's sample wrote them apart).
        format: name of the format, such as "kalibr"; by default it is recognised.
        unit: "m", "cm", "mm" or "in", of the lengths in the file; by default that of the format, or, if it has none
            (OpenCV, BoofCV), inferred from the baseline.
        size: (width, height) of the images, for files that say none.
        cameras: names of the left and the right camera where a file has more than two, such as ("cam2", "cam3"), or
            where the first one is the right one: ("cam1", "cam0"), or of any format ("right", "left").

    Raises:
        InputError: naming the file, if it cannot be read or does not hold a valid calibration; naming the formats that
            are known, if it is none of them.
        UnsupportedModelError: if the model of a lens is not known.

    Warns:
        CalibrationWarning: if the unit was inferred from the baseline, or the baseline is longer than 5 m or shorter
            than 5 mm, as of a rig in other units; or if the principal points are far from the middle of
            images whose size the file does not say.
    """
    paths = [*paths_of(path), *([] if right is None else [Path(right)])]
    if not 1 <= len(paths) <= _MOST_FILES:
        raise InputError(f"{len(paths)} calibration files were given; give one, or two where each camera has its own.")
    if len(paths) > 2 and len(set(paths)) < len(paths):
        raise InputError(f"{len(paths)} calibration files were given, and one of them twice; give each once.")
    size = None if size is None else whole_size(size)
    rig = read_files(paths, format, unit, Hints(size=size, cameras=checked_cameras(cameras)))
    if size is not None and rig.left.size != size:
        wide, high = rig.left.size
        raise InputError(
            f"{paths[0]}: the file is for images of {wide}x{high}, and the size that was given is {size[0]}x{size[1]}; "
            f"leave size out, and {fitted_to(rig.left.size, size)}."
        )
    warn_of_file(" and ".join(map(str, paths)), rig)
    return rig


def read_files(
    paths: Sequence[Path],
    format: str | None = None,
    unit: str | None = None,
    hints: Hints | None = None,
) -> StereoRig:
    """The rig in one file, in a left and a right file, or in a folder that holds such; it remembers where it came from.

    Args:
        format: name of the format; default: recognised.
        unit: of lengths in the files; default: that of the format, or inferred from the length of the baseline.

    Raises:
        InputError: naming the file, if it cannot be read, no format is recognised, or it holds no valid calibration.
        UnsupportedModelError: if the model of a lens is not known.
    """
    hints = hints or Hints()
    return rig_of_documents(*documents_of(paths, format, hints), unit, hints)


def rig_of_documents(documents: Documents, format: Format, unit: str | None, hints: Hints) -> StereoRig:
    """As `read_files`, of files that are parsed."""
    if unit is not None:
        checked_choice(unit, METRES, "unit")
    rig = rig_in(documents, format, unit, hints)
    return replace(rig, source=replace(rig.source, beside=read_stored_prior(Path(documents[0].name))))


def has_own_unit(paths: Sequence[Path], format: str | None = None) -> bool:
    """Whether the format of files has a unit of lengths; InputError, as of `read_files`, if it is not recognised."""
    return documents_of(paths, format, Hints())[1].unit is not None


def paths_of(path: AnyPath | Sequence[AnyPath]) -> list[Path]:
    """One path, or several, as a list."""
    return [Path(path)] if isinstance(path, str | os.PathLike) else [Path(each) for each in path]


# --- warnings


def warn_of_file(path: AnyPath, *rigs: StereoRig | None, sized: bool = True) -> None:
    """Warn, once for what `path` holds, of a baseline whose unit was inferred, or whose length speaks of another unit
    than its own; of turned images; and of principal points far from the middle of images, where the user and not the
    file says the size of these (`sized`: it may)."""
    known = [rig for rig in rigs if rig is not None]
    doubts = [_doubt_of_size] if sized else []
    said = [next(filter(None, map(doubt, known)), None) for doubt in (*doubts, _doubt_of_unit)]
    for turns in {rig.turns for rig in known if any(rig.turns)}:
        said.append(
            f"{described_turns(turns)} when they are read, and the calibration with them; files stay as they are."
        )
    for message in filter(None, said):
        warn(f"{path}: {message}", CalibrationWarning)


def _doubt_of_size(rig: StereoRig) -> str | None:
    source = file_of(rig)
    if source is None or source.hints.size is None:
        return None
    for camera in (rig.left, rig.right):
        place, size = np.asarray(camera.matrix)[:2, 2], np.array(camera.size)
        if (np.abs(place + 0.5 - size / 2.0) > _FAR * size).any() and _fits_any_size(source):
            return (
                f"the file has no image size, and its principal point ({place[0]:.0f}, {place[1]:.0f}) is far from the "
                f"middle of images of {size[0]}x{size[1]}; if it is for images of another size, give that size, and "
                "then resize or crop the rig (rig.resized, rig.cropped)."
            )
    return None


def _fits_any_size(source: RigFile) -> bool:
    """Whether a file is for images of any size that is said: of another one, too."""
    other = replace(source.hints, size=tuple(side + 1 for side in source.hints.size or ()))
    with suppress(InputError):
        return rig_in(source.documents, named(source.format), source.unit, other).left.size == other.size
    return False


def _doubt_of_unit(rig: StereoRig) -> str | None:
    length, source = float(rig.baseline), rig.source
    message = doubt_of_length(length, "m" if source is None else source.unit)
    if message is None and source is not None and source.inferred:
        return (
            f"the file has no unit; its translation is taken to be in {source.unit}, a baseline of {length:.3g} m: say "
            f"unit='{source.unit}' (--unit {source.unit}) if that is right, or another unit if it is not."
        )
    return message


# --- which files, and of which format


def documents_of(paths: Sequence[Path], format: str | None, hints: Hints) -> tuple[Documents, Format]:
    """The files of a calibration, parsed, and their format."""
    chosen = None if format is None else named(format)
    if len(paths) == 1 and paths[0].is_dir() and paths[0].suffix.lower() not in _ENDINGS:
        documents = _in_folder(paths[0], chosen, hints)
    else:
        documents = tuple(_parsed_file(path, chosen) for path in paths)
    return documents, chosen or _recognised(documents)


def _parsed_file(path: Path, format: Format | None) -> Document:
    """A file, parsed as the format that was chosen is: as lines, where it has those, over which others stumble."""
    kinds = () if format is None else format.syntax.values()
    of_lines = next((kind for kind in kinds if kind in (Syntax.COLONS, Syntax.EQUALS)), None)
    return read_document(path, of_lines, lines=format is None)


def _half_of(document: Document) -> Format | None:
    """The format of which a file is one of two."""
    return recognised((document, document))


def _recognised(documents: Documents) -> Format:
    """The format of documents; of two of which one is a half of a calibration, that of this one, whose reader says what
    the other one lacks."""
    found = recognised(documents)
    if found is not None:
        return found
    looks = [recognised((document,)) or _half_of(document) for document in documents]
    known = [format for format in looks if format is not None]
    if len(documents) == 2 and len(known) == 1 and known[0].files == 2:
        return known[0]
    if any(document.content.keys() == {DOCUMENTS} for document in documents):
        raise InputError(f"{' and '.join(document.name for document in documents)}: {SEVERAL}")
    if known and len(documents) <= 2:
        said = (
            f"{document.name} looks like {'nothing that is known' if format is None else format.name}"
            for document, format in zip(documents, looks, strict=True)
        )
        raise InputError(
            f"{', '.join(said)}: this is not one whole calibration; give one file, or the two files of one kind, left "
            f"before right ({known[0].name}: {known[0].about})."
        )
    raise InputError(f"{' and '.join(document.name for document in documents)}: {_unknown(documents)}")


def _unknown(documents: Documents) -> str:
    """What to say where nothing is recognised."""
    names = ", ".join(format.name for format in FORMATS)
    return f"the format is unknown; expected one of {names} (documentation, page Your data).{said_of(documents)}"


def _in_folder(folder: Path, format: Format | None, hints: Hints) -> Documents:
    """The file of a folder that holds a calibration, or the two that do so together; if none does, the likely ones."""
    if format is None and (folder / _SCENE).is_file():
        return (read_document(folder / _SCENE),)
    found, fits = _documents_in(folder, format), partial(_is_whole, format=format, hints=hints)
    single = [(document,) for document in found if fits((document,))]
    parts = [document for document in found if (document,) not in single][:_MOST_FILES]
    pairs = [next(filter(fits, permutations(two)), None) for two in combinations(parts, 2)]
    whole = [*single, *(pair for pair in pairs if pair is not None)]
    if not whole and 2 < len(found) <= _MOST_TOGETHER and fits(found):
        return found
    if len(whole) == 1:
        return whole[0]
    if whole:
        names = (" with ".join(str(Path(each.name).relative_to(folder)) for each in documents) for documents in whole)
        raise InputError(f"{folder}: several calibrations are in there ({', '.join(names)}); give one of them.")
    if not found:
        raise InputError(
            f"{folder}: there is no calibration file in it that can be read; give a file, or another folder."
        )
    looks = recognised if format is None else format.can_read
    for documents in (*permutations(parts, 2), *((document,) for document in found)):
        if looks(documents):
            return documents  # whose reader says what is wrong with it
    if format is None and len(found) <= 2:
        return found
    raise InputError(f"{folder}: {_unknown(found)}")


def _files_in(folder: Path, endings: tuple[str, ...] = _ENDINGS) -> list[Path]:
    found = (path for path in folder.iterdir() if path.suffix.lower() in endings and path.is_file())
    return sorted(path for path in found if not path.name.endswith(ENDING))


def _documents_in(folder: Path, format: Format | None) -> Documents:
    paths = _files_in(folder) or _files_in(folder, _BINARY)
    cameras = (root / name for root in (folder, folder / "mav0") for name in _OF_CAMERAS)
    documents = []
    for path in (*paths, *(path for path in cameras if path.is_file())):
        with suppress(InputError):  # something else that lies there
            documents.append(_parsed_file(path, format))
    return tuple(document for document in documents if document.content)


def _is_whole(documents: Documents, format: Format | None, hints: Hints) -> bool:
    """Whether documents are a whole calibration, and not a part of one."""
    format = format or recognised(documents)
    if format is None or not format.can_read(documents):
        return False
    try:
        rig_in(documents, format, None, hints)
    except UnsupportedModelError:
        return True
    except InputError:
        # One that has an error of its own is to be read, so that it is named; half a calibration is not.
        return len(documents) == 1 and _half_of(documents[0]) is None and format.name != "opencv"
    return True
